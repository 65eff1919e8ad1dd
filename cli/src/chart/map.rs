use std::{collections::BTreeMap, fmt::Write};

use super::{
    Layout,
    ink::{STEPS, heat},
};

/// Most nodes that tell their figures when pointed at.
const TITLES_MAX: usize = 512;
/// Width of a map on the page, at most \[px\].
const WIDTH: f64 = 210.0;

/// A value of each node, over the mesh.
pub(crate) struct Map<'a> {
    pub(crate) title: &'a str,
    /// Of each node; `None` for a node that has none.
    pub(crate) values: &'a [Option<f64>],
    /// What is black and what is bright.
    pub(crate) range: [f64; 2],
    /// A value in words.
    pub(crate) text: &'a dyn Fn(f64) -> String,
}

/// Draws a map as a figure with its scale.
pub(crate) fn map(map: &Map<'_>, layout: &Layout) -> String {
    let [w, h] = layout.size;
    // Cells of a small mesh are no larger than needed; maps of one mesh are all alike.
    let scale = (WIDTH / w).min(WIDTH / h).min(26.0);
    // Whole pixels, where cells are that large: no seams between them.
    let scale = if scale >= 2.0 && layout.is_of_boxes() { scale.floor() } else { scale };
    let gap = if scale > 6.0 { 1.0 } else { 0.0 };
    let [low, high] = map.range;
    let mut svg = format!(
        "<figure class=\"map\"><figcaption>{}</figcaption><svg width=\"{:.0}\" height=\"{:.0}\" viewBox=\"0 0 {:.1} {:.1}\" shape-rendering=\"{}\" role=\"img\" aria-label=\"{}\">",
        map.title,
        w * scale,
        h * scale,
        w * scale,
        h * scale,
        if layout.is_of_boxes() { "crispEdges" } else { "auto" },
        map.title,
    );
    let step = |value: f64| heat(if high > low { (value - low) / (high - low) } else { 0.0 });
    let titled = layout.cells.len() <= TITLES_MAX;
    let mut groups: BTreeMap<usize, (String, String)> = BTreeMap::new();
    for (node, (cell, value)) in layout.cells.iter().zip(map.values).enumerate() {
        let (key, colour) = value.map_or((STEPS, String::new()), step);
        let mut path = String::new();
        cell.path(scale, gap, &mut path);
        let group = groups.entry(key).or_insert_with(|| (colour, String::new()));
        // Writing to a string does not fail.
        let _ = if titled {
            let text = value.map_or_else(|| "none".into(), |value| (map.text)(value));
            write!(group.1, "<path d=\"{path}\"><title>node {node}: {text}</title></path>")
        } else {
            write!(group.1, "{path}")
        };
    }
    for (key, (colour, paths)) in groups {
        let fill =
            if key == STEPS { "class=\"dead\"".into() } else { format!("fill=\"{colour}\"") };
        let _ = if titled {
            write!(svg, "<g {fill}>{paths}</g>")
        } else {
            write!(svg, "<path {fill} d=\"{paths}\"/>")
        };
    }
    let known: Vec<_> = map.values.iter().flatten().copied().collect();
    let mean = known.iter().sum::<f64>() / known.len().max(1) as f64;
    let _ = writeln!(
        svg,
        "</svg>{}<p class=\"mean\">mean {}</p></figure>",
        scale_bar(&(map.text)(low), &(map.text)(high)),
        (map.text)(mean)
    );
    svg
}

/// The colours from the least to the greatest.
pub(crate) fn scale_bar(low: &str, high: &str) -> String {
    let stops: Vec<_> = (0..=8).map(|i| heat(f64::from(i) / 8.0).1).collect();
    format!(
        "<div class=\"scale\"><span>{low}</span><i style=\"background:linear-gradient(90deg,{})\"></i><span>{high}</span></div>",
        stops.join(",")
    )
}
