use std::fmt::Write;

use kiloray_sim::MeshReport;

/// Columns of a line of nodes before it turns.
const ROW: usize = 64;

/// Where the nodes of a mesh are drawn: a shape for each, in a plane.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Layout {
    /// Width and height of the plane, in cells.
    pub(crate) size: [f64; 2],
    /// Of each node, by its number.
    pub(crate) cells: Vec<Cell>,
    /// What a person should know of it.
    pub(crate) legend: String,
}

/// The shape of a node.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Cell {
    /// Corner, width and height.
    Box([f64; 4]),
    /// Four corners.
    Quad([[f64; 2]; 4]),
}

impl Layout {
    /// Of a mesh.
    pub(crate) fn new(mesh: &MeshReport) -> Self {
        let nodes = usize::from(mesh.nodes);
        let sizes: Vec<_> = mesh.sizes.iter().map(|&s| usize::from(s.max(1))).collect();
        match (mesh.shape, sizes.as_slice()) {
            ("grid", [n]) if mesh.wraps => ring(*n),
            ("grid", [n]) => snake(*n),
            ("grid", [w, h]) => boxes([*w, *h], (0..nodes).map(|i| [i % w, i / w]), plane(*w, *h)),
            ("grid", [w, h, d]) => slices([*w, *h, *d]),
            ("grid", sizes) => folded(sizes),
            ("tree", _) => icicle(nodes, usize::from(mesh.arity.max(1))),
            _ => {
                let w = (nodes as f64).sqrt().ceil().max(1.0) as usize;
                let places = (0..nodes).map(|i| [i % w, i / w]);
                boxes([w, nodes.div_ceil(w)], places, "Nodes in rows by number.".into())
            }
        }
    }

    /// Whether all cells are upright boxes of one size.
    pub(crate) fn is_of_boxes(&self) -> bool {
        self.cells
            .iter()
            .all(|cell| matches!(cell, Cell::Box([_, _, w, h]) if *w == 1.0 && *h == 1.0))
    }

    /// The middle of a node.
    pub(crate) fn middle(&self, node: usize) -> Option<[f64; 2]> {
        Some(match self.cells.get(node)? {
            Cell::Box([x, y, w, h]) => [x + w / 2.0, y + h / 2.0],
            Cell::Quad(corners) => {
                [0, 1].map(|axis| corners.iter().map(|c| c[axis]).sum::<f64>() / 4.0)
            }
        })
    }
}

impl Cell {
    /// Draws itself, as a path in units of `scale`, with `gap` left free at right and below.
    pub(super) fn path(&self, scale: f64, gap: f64, out: &mut String) {
        let r = |x: f64| (x * 10.0).round() / 10.0;
        // Writing to a string does not fail.
        let _ = match self {
            Self::Box([x, y, w, h]) => {
                let (w, h) = ((w * scale - gap).max(0.1), (h * scale - gap).max(0.1));
                let (x, y) = (r(x * scale), r(y * scale));
                write!(out, "M{x},{y}h{}v{}h-{}z", r(w), r(h), r(w))
            }
            Self::Quad(corners) => {
                let [a, b, c, d] =
                    corners.map(|[x, y]| format!("{},{}", r(x * scale), r(y * scale)));
                write!(out, "M{a}L{b} {c} {d}z")
            }
        };
    }
}

fn plane(w: usize, h: usize) -> String {
    format!("{w} x {h} nodes, node 0 at the top left.")
}

fn boxes(size: [usize; 2], places: impl Iterator<Item = [usize; 2]>, legend: String) -> Layout {
    let cells = places.map(|[x, y]| Cell::Box([x as f64, y as f64, 1.0, 1.0])).collect();
    Layout { size: size.map(|s| s as f64), cells, legend }
}

/// Row below row, there and back, so that neighbours stay neighbours.
fn snake(n: usize) -> Layout {
    let w = if n <= ROW { n } else { (n as f64).sqrt().ceil() as usize }.max(1);
    let place = |i: usize| {
        let (x, y) = (i % w, i / w);
        [if y % 2 == 0 { x } else { w - 1 - x }, y]
    };
    let legend = if n <= w {
        "Node 0 at the left.".into()
    } else {
        "The line turns at the end of each row, there and back; node 0 at the top left.".into()
    };
    boxes([w, n.div_ceil(w)], (0..n).map(place), legend)
}

fn ring(n: usize) -> Layout {
    const SIDE: f64 = 12.0;
    let corner = |i: usize, radius: f64| {
        let angle = std::f64::consts::TAU * i as f64 / n.max(1) as f64;
        [SIDE / 2.0 + radius * angle.sin(), SIDE / 2.0 - radius * angle.cos()]
    };
    let (inner, outer) = (SIDE * 0.32, SIDE * 0.5);
    let cells = (0..n).map(|i| {
        let (a, b) = (i, i + 1);
        Cell::Quad([corner(a, inner), corner(a, outer), corner(b, outer), corner(b, inner)])
    });
    let legend = "Node 0 at the top, numbers grow clockwise.".into();
    Layout { size: [SIDE; 2], cells: cells.collect(), legend }
}

/// Slices of a box, side by side in nearly a square.
fn slices([w, h, d]: [usize; 3]) -> Layout {
    const GAP: f64 = 0.6;
    let side = |n: usize, size: usize| n as f64 * (size as f64 + GAP) - GAP;
    let columns = (1..=d)
        .min_by(|&a, &b| {
            let excess = |c: usize| (side(c, w) / side(d.div_ceil(c), h)).ln().abs();
            excess(a).total_cmp(&excess(b))
        })
        .unwrap_or(1);
    let cells = (0..w * h * d).map(|i| {
        let (x, y, z) = (i % w, i / w % h, i / (w * h));
        let (column, row) = (z % columns, z / columns);
        let at = |place: usize, slice: usize, size: usize| {
            place as f64 + slice as f64 * (size as f64 + GAP)
        };
        Cell::Box([at(x, column, w), at(y, row, h), 1.0, 1.0])
    });
    Layout {
        size: [side(columns, w), side(d.div_ceil(columns), h)],
        cells: cells.collect(),
        legend: format!("{w} x {h} x {d} nodes: slices of the third dimension, row by row."),
    }
}

/// More dimensions: every second one goes across, the others down. In a hypercube the places follow
/// the Gray code, so that cells side by side are neighbours.
fn folded(sizes: &[usize]) -> Layout {
    let is_cube = sizes.iter().all(|&s| s == 2);
    let half = sizes.len().div_ceil(2);
    let extent = |part: &[usize]| part.iter().product::<usize>();
    let (across, down) = sizes.split_at(half);
    let size = [extent(across), extent(down)];
    // The place whose Gray code is this one.
    let ungray = |code: usize| (0..usize::BITS).fold(0, |place, shift| place ^ (code >> shift));
    let place = |i: usize| {
        let place = [i % size[0], i / size[0]];
        if is_cube { place.map(ungray) } else { place }
    };
    let legend = if is_cube {
        format!(
            "A hypercube of {} dimensions: {half} across and {} down, in Gray code, so that cells side by side are neighbours.",
            sizes.len(),
            sizes.len() - half
        )
    } else {
        format!("{half} dimensions across, {} down.", sizes.len() - half)
    };
    boxes(size, (0..extent(sizes)).map(place), legend)
}

/// A tree with the root on top: children share the width of their parent.
fn icicle(nodes: usize, arity: usize) -> Layout {
    let mut cells: Vec<Cell> = Vec::with_capacity(nodes);
    let mut levels = 0;
    const WIDTH: f64 = 12.0;
    for i in 0..nodes {
        let cell = match i.checked_sub(1) {
            None => [0.0, 0.0, WIDTH, 1.0],
            Some(before) => {
                let Some(&Cell::Box([x, y, w, _])) = cells.get(before / arity) else { break };
                let w = w / arity as f64;
                [x + w * (before % arity) as f64, y + 1.0, w, 1.0]
            }
        };
        levels = levels.max(cell[1] as usize + 1);
        cells.push(Cell::Box(cell));
    }
    // Levels as high as make a drawing of a good shape.
    let height = (WIDTH * 0.8 / levels.max(1) as f64).min(2.0);
    for cell in &mut cells {
        if let Cell::Box([_, y, _, h]) = cell {
            (*y, *h) = (*y * height, height);
        }
    }
    let legend = format!("The root on top; up to {arity} children below each node.");
    Layout { size: [WIDTH, levels as f64 * height], cells, legend }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mesh(shape: &'static str, sizes: &[u16], wraps: bool, arity: u16) -> MeshReport {
        let nodes = if shape == "grid" { sizes.iter().product() } else { sizes[0] };
        MeshReport { shape, sizes: sizes.to_vec(), wraps, arity, nodes, attached: vec![0] }
    }

    #[test]
    fn every_node_has_a_place_of_its_own_within_the_plane() {
        for mesh in [
            mesh("grid", &[7], false, 0),
            mesh("grid", &[200], false, 0),
            mesh("grid", &[16], true, 0),
            mesh("grid", &[8, 8], true, 0),
            mesh("grid", &[4, 4, 5], true, 0),
            mesh("grid", &[2; 6], false, 0),
            mesh("grid", &[3, 3, 2, 2], false, 0),
            mesh("grid", &[1], false, 0),
            mesh("tree", &[30], false, 3),
            mesh("full", &[10], false, 0),
        ] {
            let layout = Layout::new(&mesh);
            assert_eq!(layout.cells.len(), usize::from(mesh.nodes), "{mesh:?}");
            let mut middles: Vec<_> = (0..layout.cells.len())
                .map(|i| layout.middle(i).unwrap().map(|x| (x * 1000.0).round() as i64))
                .collect();
            for middle in &middles {
                let [w, h] = layout.size.map(|s| (s * 1000.0) as i64);
                assert!((0..=w).contains(&middle[0]) && (0..=h).contains(&middle[1]), "{mesh:?}");
            }
            middles.sort_unstable();
            middles.dedup();
            assert_eq!(middles.len(), layout.cells.len(), "{mesh:?}");
        }
    }

    #[test]
    fn cells_side_by_side_are_neighbours_in_a_hypercube() {
        let layout = Layout::new(&mesh("grid", &[2; 6], false, 0));
        let at = |i: usize| layout.middle(i).unwrap();
        for a in 0..64_usize {
            for b in 0..64 {
                let near = (at(a)[0] - at(b)[0]).abs() + (at(a)[1] - at(b)[1]).abs() < 1.5;
                assert!(!near || (a ^ b).count_ones() <= 1, "{a} {b}");
            }
        }
    }
}
