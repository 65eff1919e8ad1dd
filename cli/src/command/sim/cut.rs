//! Cuts through a mesh: what has to pass from one part to the other.

use kiloray_sim::{LinkReport, MeshReport, Report};

/// One direction of a cut.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::command) struct Cut {
    /// Which.
    pub(in crate::command) name: String,
    /// Links across it, in this direction.
    pub(in crate::command) links: u64,
    /// Bytes that crossed it.
    pub(in crate::command) bytes: u64,
    /// Time that its links need for them together \[ns\].
    pub(in crate::command) bound_ns: u64,
}

/// A link's ends.
pub(in crate::command) fn link_name(link: &LinkReport) -> String {
    let end = |node: Option<u16>| node.map_or_else(|| "host".into(), |node| node.to_string());
    format!("{} to {}", end(link.from), end(link.to))
}

/// The cut whose links need longest: of planes through a grid (halves of one that wraps), of the links
/// of a tree, and of the host's links.
pub(in crate::command) fn worst(report: &Report, bandwidth: u64) -> Option<Cut> {
    let mut cuts = host(report);
    match report.mesh.shape {
        "grid" => cuts.extend(planes(report)),
        // Each link of a tree is a cut.
        "tree" => cuts.extend(
            report
                .links
                .iter()
                .filter(|link| link.from.is_some() && link.to.is_some())
                .map(|link| (format!("link {}", link_name(link)), 1, link.bytes)),
        ),
        _ => {
            let half = report.mesh.nodes / 2;
            for (name, low) in [("first half to second", true), ("second half to first", false)] {
                let crosses = |a: u16, b: u16| (a < half) == low && (b < half) != low;
                cuts.push(sum(report, name.into(), crosses));
            }
        }
    }
    let bound = |links: u64, bytes: u64| {
        let ns = (bytes as f64 * 1e9 / (links as f64 * bandwidth as f64)).round() as u64;
        // The last packets may not be through when the picture is there.
        ns.min(report.virtual_ns)
    };
    cuts.into_iter()
        .filter(|&(_, links, _)| links > 0)
        .map(|(name, links, bytes)| Cut { name, links, bytes, bound_ns: bound(links, bytes) })
        .max_by_key(|cut| cut.bound_ns)
}

type Sum = (String, u64, u64);

fn sum(report: &Report, name: String, crosses: impl Fn(u16, u16) -> bool) -> Sum {
    let ends =
        |link: &&LinkReport| matches!((link.from, link.to), (Some(a), Some(b)) if crosses(a, b));
    let across = report.links.iter().filter(ends);
    let (links, bytes) = across.fold((0, 0), |(n, bytes), link| (n + 1, bytes + link.bytes));
    (name, links, bytes)
}

/// From the host and to it.
fn host(report: &Report) -> Vec<Sum> {
    let of = |name: &str, wanted: fn(&LinkReport) -> bool| {
        let links = report.links.iter().filter(|link| wanted(link));
        let (links, bytes) = links.fold((0, 0), |(n, bytes), link| (n + 1, bytes + link.bytes));
        (name.to_owned(), links, bytes)
    };
    vec![
        of("the host's links, to it", |link| link.to.is_none()),
        of("the host's links, from it", |link| link.from.is_none()),
    ]
}

/// Both directions of every plane across a dimension.
fn planes(report: &Report) -> Vec<Sum> {
    let MeshReport { sizes, wraps, .. } = &report.mesh;
    let mut cuts = Vec::new();
    let mut stride = 1_u64;
    for (dimension, &size) in sizes.iter().enumerate() {
        let size = u64::from(size.max(1));
        let place = |node: u16| u64::from(node) / stride % size;
        let is_ring = *wraps && size > 2;
        // Of a ring, halves: bytes across both ends of each, for every beginning at once.
        let halves = match size {
            // Of an odd number each plane is the beginning of another half.
            _ if is_ring && size % 2 == 1 => size,
            _ if is_ring => size / 2,
            _ => size.saturating_sub(1),
        };
        let mut steps = vec![[(0_u64, 0_u64); 2]; size as usize];
        for link in &report.links {
            let (Some(from), Some(to)) = (link.from, link.to) else { continue };
            let (a, b) = (place(from), place(to));
            if a == b {
                continue;
            }
            // Up: from place p to p + 1, also where the ring closes. It crosses plane p.
            let up = b == a + 1 || (is_ring && a + 1 == size && b == 0);
            let plane = if up { a } else { b };
            let (links, bytes) = &mut steps[plane as usize][usize::from(!up)];
            (*links, *bytes) = (*links + 1, *bytes + link.bytes);
        }
        let axis = char::from(b"xyzuvwabcdefghi"[dimension.min(14)]);
        for p in 0..halves as usize {
            // The part above plane p; in a ring it ends at the opposite plane.
            let n = size as usize;
            let q = if is_ring { (p + n / 2) % n } else { p + n / 2 };
            let both = |a: (u64, u64), b: (u64, u64)| (a.0 + b.0, a.1 + b.1);
            let none = (0, 0);
            let far = |way: usize| if is_ring { steps[q][way] } else { none };
            let into = both(steps[p][0], far(1));
            let out = both(steps[p][1], far(0));
            let name = |way: &str| {
                if is_ring {
                    format!("{way} {axis} {} to {q}", (p + 1) % n)
                } else {
                    format!("{way} {axis} above {p}")
                }
            };
            cuts.push((name("into"), into.0, into.1));
            cuts.push((name("out of"), out.0, out.1));
        }
        stride *= size;
    }
    cuts
}
