use super::table::Row;
use crate::{
    args::{Axis, Sweep, axes},
    chart::{Line, Lines, Mark, Scale},
};

/// A figure of all points over one axis.
#[derive(Debug)]
pub(super) struct Plot {
    /// Of the file.
    pub(super) name: String,
    title: &'static str,
    x: Scale,
    x_name: String,
    y_name: &'static str,
    y: Scale,
    y_max: Option<f64>,
    lines: Vec<Line>,
}

/// What is plotted: file, title, name of the axis up, where it is in the JSON.
const FIGURES: [(&str, &str, &str, &str); 7] = [
    ("efficiency", "Parallel efficiency", "T1 / (nodes x TN)", "/efficiency"),
    ("speed-up", "Speed-up", "T1 / TN", "/speed_up"),
    ("time", "Virtual time", "ms", "/virtual_time_ms"),
    ("fetched", "Blocks fetched", "blocks", "/blocks/fetched"),
    ("messages", "Bytes of messages", "bytes", "/messages/bytes"),
    ("waiting", "Waiting for blocks", "part of the time of all nodes", "/lost/data"),
    ("imbalance", "Without work", "part of the time of all nodes", "/lost/imbalance"),
];

impl Plot {
    /// Draws it, for a file of its own or for a page.
    pub(super) fn svg(&self, alone: bool) -> String {
        Lines {
            title: self.title,
            x: self.x.clone(),
            x_name: &self.x_name,
            y_name: self.y_name,
            y: self.y.clone(),
            y_max: self.y_max,
            lines: self.lines.clone(),
            size: [510, 340],
            alone,
        }
        .svg()
    }
}

/// What plots of any sweep can be called: of all combinations, and over one option at a time.
pub(super) fn names() -> impl Iterator<Item = String> {
    let heads = std::iter::once(None).chain(axes().into_iter().map(Some));
    heads.flat_map(|over| FIGURES.map(|(figure, ..)| name(over.as_deref(), figure)))
}

fn name(over: Option<&str>, figure: &str) -> String {
    over.map_or_else(|| figure.to_owned(), |option| format!("{option}-{figure}"))
}

/// The file of a plot.
pub(super) fn file(name: &str) -> String {
    format!("{name}.svg")
}

/// All plots, under what they are over where that is not the same for all.
pub(super) fn of_sweep(sweep: &Sweep, rows: &[Row]) -> Vec<(String, Vec<Plot>)> {
    if !sweep.each {
        return vec![(String::new(), plots(&sweep.over, rows))];
    }
    let of = |axis: &Axis| {
        let rows: Vec<_> = rows.iter().filter_map(|row| row.of_axis(&axis.option)).collect();
        let mut plots = plots(std::slice::from_ref(axis), &rows);
        for plot in &mut plots {
            plot.name = name(Some(&axis.option), &plot.name);
        }
        (axis.option.clone(), plots)
    };
    sweep.over.iter().map(of).collect()
}

/// The plots over the axis that is across, with a line for each combination of the others.
pub(super) fn plots(axes: &[Axis], rows: &[Row]) -> Vec<Plot> {
    let is_long = |axis: &&Axis| axis.values.len() > 1;
    let across = axes
        .iter()
        .filter(is_long)
        .find(|axis| numbers(axis).is_some())
        .or_else(|| axes.iter().find(is_long))
        .or(axes.first());
    let Some(across) = across else { return Vec::new() };
    let place = axes.iter().position(|axis| axis == across).unwrap_or(0);
    let (x, xs, unit) = scale(across);
    let x_name =
        if unit.is_empty() { across.option.clone() } else { format!("{}, {unit}", across.option) };
    FIGURES
        .iter()
        .filter_map(|&(name, title, y_name, at)| {
            let mut lines = lines(rows, axes, place, &xs, &across.values, at);
            if lines.is_empty() {
                return None;
            }
            // What would be best, to compare with.
            let ideal = match name {
                "speed-up" if across.option == "nodes" => {
                    Some(xs.iter().map(|&n| (n, n)).collect())
                }
                "efficiency" => Some(xs.iter().map(|&x| (x, 1.0)).collect()),
                _ => None,
            };
            if let Some(points) = ideal {
                let name = if name == "speed-up" { "ideal".into() } else { String::new() };
                lines.insert(0, Line { name, mark: Mark::Thin, colour: 0, points });
            }
            let y_max = (name == "efficiency").then_some(1.1);
            // The ideal is a straight line where both double; where little differs, it is seen better in even steps.
            let is_ratio = matches!(name, "speed-up" | "time") && x == Scale::Doubling;
            let ys = lines.iter().flat_map(|line| line.points.iter().map(|point| point.1));
            let y = if is_ratio && is_wide(ys) { Scale::Doubling } else { Scale::Even };
            let (x, x_name) = (x.clone(), x_name.clone());
            Some(Plot { name: name.to_owned(), title, x, x_name, y_name, y, y_max, lines })
        })
        .collect()
}

fn lines(
    rows: &[Row],
    axes: &[Axis],
    across: usize,
    xs: &[f64],
    values: &[String],
    at: &str,
) -> Vec<Line> {
    let mut lines: Vec<Line> = Vec::new();
    for row in rows {
        let Some(y) = row.number(at) else { continue };
        let Some(x) = values.iter().position(|v| *v == row.values[across]).and_then(|i| xs.get(i))
        else {
            continue;
        };
        let others = row.values.iter().zip(axes).enumerate().filter(|&(i, _)| i != across);
        let name: Vec<_> = others
            .map(|(_, (value, axis))| {
                // A number alone says little.
                let is_number = value.starts_with(|c: char| c.is_ascii_digit());
                if is_number || value == "all" {
                    format!("{} {value}", axis.option)
                } else {
                    value.clone()
                }
            })
            .collect();
        let name = name.join(", ");
        match lines.iter_mut().find(|line| line.name == name) {
            Some(line) => line.points.push((*x, y)),
            None => {
                let colour = lines.len();
                lines.push(Line { name, mark: Mark::Dots, colour, points: vec![(*x, y)] });
            }
        }
    }
    for line in &mut lines {
        line.points.sort_by(|a, b| a.0.total_cmp(&b.0));
    }
    // Zeros alone say nothing.
    if lines.iter().flat_map(|line| &line.points).all(|p| p.1 == 0.0) { Vec::new() } else { lines }
}

/// Where each value stands.
fn scale(axis: &Axis) -> (Scale, Vec<f64>, String) {
    let Some((numbers, unit)) = numbers(axis) else {
        let places = (0..axis.values.len()).map(|i| i as f64).collect();
        return (Scale::Names(axis.values.clone()), places, String::new());
    };
    let is_wide = is_wide(numbers.iter().copied());
    (if is_wide { Scale::Doubling } else { Scale::Even }, numbers, unit)
}

/// Whether numbers are doubled twice from the least to the greatest.
fn is_wide(numbers: impl Iterator<Item = f64> + Clone) -> bool {
    let least = numbers.clone().fold(f64::INFINITY, f64::min);
    least > 0.0 && numbers.fold(0.0, f64::max) >= 4.0 * least
}

/// The values as numbers in the unit of the first; `None` if one is no number, or some count blocks and some bytes.
fn numbers(axis: &Axis) -> Option<(Vec<f64>, String)> {
    let parsed: Option<Vec<_>> = axis.values.iter().map(|value| number(value)).collect();
    let parsed = parsed?;
    let counts = parsed.iter().filter(|(_, unit)| unit.is_empty()).count();
    if axis.option == "top" && (1..parsed.len()).contains(&counts) {
        return None;
    }
    let unit = parsed.iter().map(|(_, unit)| *unit).find(|unit| !unit.is_empty()).unwrap_or("");
    let of = |unit| crate::args::scale(unit).ok();
    let first = of(unit)?;
    let all: Option<Vec<_>> = parsed.iter().map(|(n, unit)| Some(n * of(unit)? / first)).collect();
    Some((all?, unit.to_owned()))
}

fn number(text: &str) -> Option<(f64, &str)> {
    if let Some((a, b)) = text.split_once('/')
        && let (Ok(a), Ok(b)) = (a.parse::<f64>(), b.parse::<f64>())
    {
        return Some((a / b, ""));
    }
    let end = text.bytes().take_while(|b| b.is_ascii_digit() || *b == b'.').count();
    let (number, unit) = text.split_at(end);
    Some((number.parse().ok()?, unit))
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn axis(text: &str) -> Axis {
        text.parse().unwrap()
    }

    #[test]
    fn values_are_places_in_one_unit() {
        assert_eq!(
            scale(&axis("memory=64KiB..256KiB,1MiB")),
            (Scale::Doubling, vec![64.0, 128.0, 256.0, 1024.0], "KiB".into())
        );
        assert_eq!(scale(&axis("top=16KiB,32KiB")), (Scale::Even, vec![16.0, 32.0], "KiB".into()));
        let (names, ..) = scale(&axis("top=4,16KiB"));
        assert_eq!(names, Scale::Names(vec!["4".into(), "16KiB".into()]));
        assert_eq!(scale(&axis("loss=0,1/100")), (Scale::Even, vec![0.0, 0.01], String::new()));
        let (names, places, _) = scale(&axis("prefetch=0,4,all"));
        assert_eq!(names, Scale::Names(vec!["0".into(), "4".into(), "all".into()]));
        assert_eq!(places, [0.0, 1.0, 2.0]);
    }

    #[test]
    fn numbers_go_across_and_the_others_make_a_line_each() {
        let axes = [axis("schedule=hybrid,data"), axis("nodes=1..4")];
        let mut rows = Vec::new();
        for schedule in &axes[0].values {
            for nodes in &axes[1].values {
                let json = json!({ "efficiency": 0.5, "speed_up": 2.0 });
                rows.push(Row::of_json(&[schedule, nodes], json));
            }
        }
        let plots = plots(&axes, &rows);
        assert_eq!(
            plots.iter().map(|p| p.name.as_str()).collect::<Vec<_>>(),
            ["efficiency", "speed-up"]
        );
        let names: Vec<_> = plots[1].lines.iter().map(|line| line.name.as_str()).collect();
        assert_eq!(names, ["ideal", "hybrid", "data"]);
        assert_eq!(plots[1].lines[2].points, [(1.0, 2.0), (2.0, 2.0), (4.0, 2.0)]);
        assert!(plots[1].svg(true).contains("nodes"));
    }
}
