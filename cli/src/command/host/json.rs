use kiloray_sim::{MessageReport, TileReport};
use serde_json::{Value, json};

use super::Run;
use crate::command::{
    division,
    mesh::{add_counts, losses_json, total},
    report,
};

impl Run<'_> {
    /// The fields that scripts rely on: those of `sim`, with times of the clock.
    pub(super) fn as_json(&self) -> Value {
        let (outcome, counts, options) = (self.outcome, &self.counts, self.options);
        let messages = MessageReport::of(counts);
        let nodes = &outcome.nodes;
        let fullest = self.fullest();
        let points = kiloray_core::store::Line::Points.name();
        let points: Vec<_> =
            nodes.iter().flat_map(|n| &n.lines).filter(|line| line.name == points).collect();
        let head = report::Head {
            scene: self.scene,
            options: self.options_json(),
            picture: &outcome.picture,
            image_hash: &self.image_hash,
            nodes: options.topology.nodes().into(),
            time_s: self.time_s,
            fetched: counts.cache.fetched,
            overflows: outcome.overflows,
        };
        let mut json = head.with(json!({
            "complete": outcome.complete,
            "lost_block": outcome.lost,
            "start_s": outcome.start.map(|start| start.as_secs_f64()),
            "mesh_s": outcome.start.map(|_| outcome.render.as_secs_f64()),
            "virtual_time_s": null,
            "efficiency": null,
            "skipped": report::skipped_json(self.scene, &report::skipped(self.scene, &counts.shade)),
            "messages": {
                "count": total(messages.iter().map(|m| m.sent)),
                "bytes": total(messages.iter().map(|m| m.sent_bytes)),
                "by_kind": messages,
            },
            "links": {
                "packets": total(nodes.iter().map(|n| n.time.packets_sent)),
                "bytes": total(nodes.iter().map(|n| n.time.bytes_sent)),
                "dropped": total(nodes.iter().map(|n| n.time.dropped)),
                "foreign": total(nodes.iter().map(|n| n.foreign)),
            },
            "memory": {
                "limit": options.memory,
                "peak": fullest.map(|node| node.peak_bytes),
                "peak_node": fullest.map(|node| node.node),
                "lines": self.lines(),
                "processes": {
                    "peak": self.greatest().map(|(_, peak)| peak),
                    "budget": self.greatest().map(|(process, _)| process.budget_bytes),
                    "limit": self.greatest().and_then(|(process, _)| process.limit_bytes),
                },
            },
            "points": {
                "capacity": points.iter().map(|line| line.capacity).max().unwrap_or(0),
                "peak": points.iter().map(|line| line.peak).max().unwrap_or(0),
            },
            "tiles": TileReport::from(outcome.ledger),
            "lost": losses_json(&self.lost()),
            "latencies": outcome.latencies,
            "faults": {
                "replaced": outcome.replacements,
                // What they did is in no count of nodes: `rays`, `messages`, `cache` and so on.
                "uncounted_processes": outcome.replacements.len(),
            },
            "per_node": nodes,
            "host": outcome.host,
        }));
        json["blocks"]["owned_max"] = json!(nodes.iter().map(|n| n.owned_blocks).max());
        add_counts(&mut json, counts);
        json
    }

    fn options_json(&self) -> Value {
        let o = self.options;
        let size = (o.width, o.height);
        let mut all =
            report::options_json(self.common, self.scenes, self.scene, size, self.exposure);
        let topology = self.division.topology_name(&o.topology);
        division::add_json(&mut all, self.division, o, &topology);
        all
    }
}
