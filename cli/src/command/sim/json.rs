use kiloray_sim::{NodeReport, Report};
use serde_json::{Value, json};

use super::{Run, lost::lost};
use crate::command::{
    division,
    mesh::{self, add_counts, losses_json, part},
    report,
};

impl Run<'_> {
    /// The fields that scripts rely on.
    pub(in crate::command) fn as_json(&self) -> Value {
        let outcome = &self.done.outcome;
        let report = &outcome.report;
        let (counts, picture) = (&report.totals.counts, &outcome.picture);
        let bounds: serde_json::Map<_, _> = self
            .bounds()
            .iter()
            .map(|bound| (bound.key.to_owned(), json!(seconds(bound.ns))))
            .collect();
        let head = report::Head {
            scene: self.scene,
            options: self.options_json(),
            picture,
            image_hash: &self.done.image_hash,
            nodes: report.nodes.len(),
            time_s: self.done.all_s,
            fetched: counts.cache.fetched,
            overflows: outcome.overflows,
        };
        let mut json = head.with(json!({
            "complete": outcome.is_complete(),
            "profile_source": self.options.profile.source,
            "lost_block": outcome.lost(),
            "mesh_s": self.done.mesh_s,
            "virtual_time_s": seconds(report.virtual_ns),
            "virtual_time_one_node_s": self.done.compared().map(|one| seconds(one.virtual_ns)),
            "efficiency": self.done.efficiency(),
            "skipped": report::skipped_json(self.scene, &report::skipped(self.scene, &counts.shade)),
            "messages": {
                "count": report.messages.iter().map(|m| m.sent).sum::<u64>(),
                "bytes": report.messages.iter().map(|m| m.sent_bytes).sum::<u64>(),
                "by_kind": report.messages,
            },
            "links": {
                "packets": report.totals.packets,
                "control_packets": report.totals.control_packets,
                "bytes": report.totals.link_bytes,
                "busiest": self.busiest_link().map(|link| json!({
                    "from": link.from,
                    "to": link.to,
                    "busy": part(link.busy_ns, report.virtual_ns),
                })),
                "worst_cut": self.cut.as_ref().map(|cut| json!({
                    "name": cut.name,
                    "links": cut.links,
                    "bytes": cut.bytes,
                    "bound_s": seconds(cut.bound_ns),
                })),
            },
            "memory": {
                "limit": self.options.mesh.memory,
                "peak": report.totals.peak_bytes,
                "peak_node": report.totals.peak_node,
                "lines": super::lines(report),
                "beside": mesh::beside_json(),
            },
            "points": points_json(report),
            "tiles": report.tiles,
            "lost": losses_json(&lost(report, self.done.compared())),
            "bounds_s": bounds,
            "latencies": report.latencies,
            "faults": report.faults,
            "events": report.events,
            "fingerprint": report.fingerprint,
        }));
        json["blocks"]["owned_max"] = json!(report.nodes.iter().map(|n| n.owned_blocks).max());
        add_counts(&mut json, counts);
        json
    }

    /// The same, and all that the page draws: a line for each field, node and link.
    pub(in crate::command) fn as_json_with_details(&self) -> String {
        let mut json = self.as_json();
        let report = &self.done.outcome.report;
        json["mesh"] = json!(report.mesh);
        json["timeline"] = json!(report.timeline);
        let mut fields: Vec<_> = json
            .as_object()
            .into_iter()
            .flatten()
            .map(|(name, value)| format!("\"{name}\": {value}"))
            .collect();
        let list = |items: Vec<String>| format!("[\n{}\n]", items.join(",\n"));
        let nodes = report.nodes.iter().map(|node| json!(node).to_string());
        fields.push(format!("\"per_node\": {}", list(nodes.collect())));
        let links = report.links.iter().map(|link| json!(link).to_string());
        fields.push(format!("\"per_link\": {}", list(links.collect())));
        format!("{{\n{}\n}}\n", fields.join(",\n"))
    }

    fn options_json(&self) -> Value {
        let o = self.options;
        let size = (o.mesh.width, o.mesh.height);
        let mut options = report::options_json(
            &self.sim.common,
            &self.sim.scene.scenes,
            self.scene,
            size,
            self.exposure,
        );
        let division = &self.done.outcome.division;
        division::add_json(&mut options, &self.sim.mesh, division, &self.topology);
        let bundle = o.bundle_age.unwrap_or_else(|| o.link.bundle_age(division.packet.into()));
        options["bundle"] = json!(bundle);
        options["link_bandwidth"] = json!(o.link.bandwidth);
        options["link_latency"] = json!(o.link.latency);
        options["switching"] = json!(match o.link.switching {
            kiloray_sim::Switching::StoreAndForward => "store",
            kiloray_sim::Switching::CutThrough => "cut",
        });
        options["loss"] = json!(rate(o.faults.loss));
        options["duplicate"] = json!(rate(o.faults.duplicate));
        options["jitter"] = json!(o.faults.jitter);
        options["fault_seed"] = json!(o.seed);
        options
    }
}

fn rate(rate: kiloray_sim::Rate) -> f64 {
    f64::from(rate.count) / f64::from(rate.of.max(1))
}

fn seconds(ns: u64) -> f64 {
    ns as f64 / 1e9
}

/// Of the node that had the most.
fn points_json(report: &Report) -> Value {
    let name = kiloray_core::store::Line::Points.name();
    let of = |node: &NodeReport| node.lines.iter().find(|l| l.name == name).copied();
    let lines: Vec<_> = report.nodes.iter().filter_map(of).collect();
    json!({
        "capacity": lines.iter().map(|l| l.capacity).max().unwrap_or(0),
        "peak": lines.iter().map(|l| l.peak).max().unwrap_or(0),
    })
}
