//! What nodes have told of themselves.

use std::collections::BTreeMap;

use kiloray_core::node::{Counts, Figures};
use kiloray_mesh::Ledger;
use serde_json::{Value, json};

use crate::command::mesh::Line;

/// All of it.
#[derive(Debug)]
pub(super) struct Told<'a> {
    by_node: &'a BTreeMap<u16, Figures>,
    /// Of all nodes.
    pub(super) counts: Counts,
}

impl<'a> Told<'a> {
    pub(super) fn of(ledger: &'a Ledger) -> Self {
        let by_node = ledger.told();
        let mut counts = Counts::default();
        by_node.values().for_each(|figures| counts.add(&figures.counts()));
        Self { by_node, counts }
    }

    /// The node of whose memory the greatest part was in use: memories differ.
    pub(super) fn fullest(&self) -> Option<(u16, &'a Figures)> {
        let part =
            |figures: &Figures| figures.peak_bytes() as f64 / f64::from(figures.memory.max(1));
        let nodes = self.by_node.iter().map(|(&node, figures)| (node, figures));
        nodes.max_by(|(_, a), (_, b)| part(a).total_cmp(&part(b)))
    }

    /// The lines of all nodes.
    pub(super) fn lines(&self) -> impl Iterator<Item = Line<'static>> {
        self.by_node.values().flat_map(lines)
    }

    /// A node for a node.
    pub(super) fn per_node(&self) -> Vec<Value> {
        let node = |(node, figures): (&u16, &Figures)| {
            let counts = figures.counts();
            json!({
                "node": node,
                "memory": figures.memory,
                "peak": figures.peak_bytes(),
                "lines": lines(figures).collect::<Vec<_>>(),
                "tiles": counts.tiles,
                "rays": counts.shade.rays(),
                "fetched": counts.cache.fetched,
            })
        };
        self.by_node.iter().map(node).collect()
    }

    /// Those that have not told: they are dead, or did not answer.
    pub(super) fn missing(&self, nodes: u16) -> Vec<u16> {
        (0..nodes).filter(|node| !self.by_node.contains_key(node)).collect()
    }
}

fn lines(figures: &Figures) -> impl Iterator<Item = Line<'static>> {
    figures.lines().map(|line| Line {
        name: line.line.name(),
        capacity: line.capacity,
        bytes: line.bytes,
        peak: line.peak,
        peak_bytes: line.peak_bytes(),
    })
}
