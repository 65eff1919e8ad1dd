use kiloray_core::node::{Counts, Work};
use serde::Serialize;

use super::{LinkReport, NodeReport, NodeTime};

/// Sums over nodes and links.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct Totals {
    /// What the nodes did; peaks are those of the node that had the greatest.
    pub counts: Counts,
    /// Operations.
    pub work: Work<u64>,
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
            totals.counts.add(&node.counts);
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
}
