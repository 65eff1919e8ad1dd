use kiloray_core::node::{Counts, Kind, Kinds, Work};
use serde::Serialize;

use super::{LinkReport, MessageReport, NodeReport, NodeTime};

/// Sums over nodes and links.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct Totals {
    /// What the nodes did; peaks are those of the node that had the greatest.
    pub counts: Counts,
    /// Operations.
    pub work: Work,
    /// Where the time of the nodes went.
    pub time: NodeTime,
    /// Packets on links, one for each hop; control packets not counted.
    pub packets: u64,
    /// Packets that bring credit only.
    pub control_packets: u64,
    /// Bytes on links, headers and control packets included.
    pub link_bytes: u64,
    /// The node that used the most memory.
    pub peak_node: u16,
    /// The most memory that any node used \[bytes\].
    pub peak_bytes: usize,
}

impl Totals {
    /// Of these nodes and links.
    pub(crate) fn new(nodes: &[NodeReport], links: &[LinkReport]) -> Self {
        let mut totals = Self::default();
        for node in nodes {
            add(&mut totals.counts, &node.counts);
            totals.work += node.work;
            totals.time += node.time;
            if node.peak_bytes > totals.peak_bytes {
                (totals.peak_node, totals.peak_bytes) = (node.node, node.peak_bytes);
            }
        }
        for link in links {
            totals.packets += link.packets;
            totals.control_packets += link.control_packets;
            totals.link_bytes += link.bytes;
        }
        totals
    }

    /// Messages by kind.
    pub(crate) fn messages(&self) -> Vec<MessageReport> {
        let (sent, received) = (kinds(&self.counts.sent), kinds(&self.counts.received));
        let report =
            |((kind, sent), (_, received)): ((&'static str, Kind), (_, Kind))| MessageReport {
                kind,
                sent: sent.count,
                sent_bytes: sent.bytes,
                received: received.count,
                received_bytes: received.bytes,
            };
        sent.into_iter().zip(received).map(report).collect()
    }
}

fn kinds(kinds: &Kinds) -> [(&'static str, Kind); 6] {
    let Kinds { fetch, part, tile, ray, answer, refusal } = *kinds;
    [
        ("fetch", fetch),
        ("part", part),
        ("tile", tile),
        ("ray", ray),
        ("answer", answer),
        ("refusal", refusal),
    ]
}

fn add(all: &mut Counts, one: &Counts) {
    all.shade.add(&one.shade);
    all.cache.hits += one.cache.hits;
    all.cache.misses += one.cache.misses;
    all.cache.evictions += one.cache.evictions;
    all.cache.fetched += one.cache.fetched;
    all.cache.frames_peak = all.cache.frames_peak.max(one.cache.frames_peak);
    all.tiles += one.tiles;
    all.packets += one.packets;
    add_kinds(&mut all.sent, &one.sent);
    add_kinds(&mut all.received, &one.received);
    all.migrated += one.migrated;
    all.visitors += one.visitors;
    all.refused += one.refused;
    all.run_at_home += one.run_at_home;
    all.rays_again += one.rays_again;
    all.fetches_again += one.fetches_again;
    all.tiles_again += one.tiles_again;
    all.unasked += one.unasked;
    all.damaged += one.damaged;
    all.blocks_refused += one.blocks_refused;
    all.stalls += one.stalls;
    all.rays_peak = all.rays_peak.max(one.rays_peak);
    all.shadows_peak = all.shadows_peak.max(one.shadows_peak);
    all.visitors_peak = all.visitors_peak.max(one.visitors_peak);
    all.tiles_peak = all.tiles_peak.max(one.tiles_peak);
}

fn add_kinds(all: &mut Kinds, one: &Kinds) {
    for (all, one) in [
        (&mut all.fetch, one.fetch),
        (&mut all.part, one.part),
        (&mut all.tile, one.tile),
        (&mut all.ray, one.ray),
        (&mut all.answer, one.answer),
        (&mut all.refusal, one.refusal),
    ] {
        all.count += one.count;
        all.bytes += one.bytes;
    }
}
