//! What a run reports.

mod link;
mod node;
mod timeline;
mod totals;

pub use link::{LinkReport, MeshReport};
pub use node::{LineReport, NodeReport, NodeTime};
pub use timeline::{Sample, Timeline};
pub use totals::Totals;

use kiloray_core::node::{Counts, Kind};
use kiloray_mesh::LedgerCounts;
pub use kiloray_mesh::watch::{Histogram, HistogramBucket, Latencies, TraceFlow};
use serde::Serialize;

/// What a run reports.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Report {
    /// The mesh.
    pub mesh: MeshReport,
    /// Name of the machine profile.
    pub profile: String,
    /// From the first event to the last pixel \[ns\].
    pub virtual_ns: u64,
    /// Every node, by its number.
    pub nodes: Vec<NodeReport>,
    /// Every direction of every link, by the node it leaves, then by port; those of the host come last.
    pub links: Vec<LinkReport>,
    /// Messages by kind, in a fixed order.
    pub messages: Vec<MessageReport>,
    /// How the run went on.
    pub timeline: Timeline,
    /// How long things took.
    pub latencies: Latencies,
    /// What went wrong by request.
    pub faults: FaultReport,
    /// The host's ledger of tiles.
    pub tiles: TileReport,
    /// Sums over nodes and links.
    pub totals: Totals,
    /// What each node did when; empty unless asked for.
    pub trace: Vec<TraceEvent>,
    /// The fetches of blocks that go with the trace, by the time of their end.
    pub flows: Vec<TraceFlow>,
    /// Events of the simulation.
    pub events: u64,
    /// A hash of all events: equal for equal runs, in hexadecimal.
    pub fingerprint: String,
}

/// Messages of one kind.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct MessageReport {
    /// What they are called: `fetch`, `part`, `tile`, `ray`, `answer`, `refusal`.
    pub kind: &'static str,
    /// How many the nodes sent.
    pub sent: u64,
    /// Their bytes, without packet headers.
    pub sent_bytes: u64,
    /// How many the nodes handled.
    pub received: u64,
    /// Their bytes, without packet headers.
    pub received_bytes: u64,
}

impl MessageReport {
    /// Of these counts, by kind.
    #[must_use]
    pub fn of(counts: &Counts) -> Vec<Self> {
        let (sent, received) = (counts.sent.named(), counts.received.named());
        let report = |((kind, sent), (_, received)): ((&'static str, Kind), (_, Kind))| Self {
            kind,
            sent: sent.count,
            sent_bytes: sent.bytes,
            received: received.count,
            received_bytes: received.bytes,
        };
        sent.into_iter().zip(received).map(report).collect()
    }
}

/// The host's ledger of tiles.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
pub struct TileReport {
    /// Pixels that are there: all, where the picture is complete.
    pub pixels: u64,
    /// Tiles given for the first time: those of the picture, where it is complete.
    pub given: u64,
    /// Tiles that were out for long, and were given to another node as well.
    pub given_again: u64,
    /// Asks that came again, and had the same answer again.
    pub asked_again: u64,
    /// Pixels that were there already when they came.
    pub pixels_again: u64,
    /// Of those, pixels with another sum: there are none, as long as nodes are sound.
    pub pixels_differing: u64,
    /// Messages that were answered or entered.
    pub messages: u64,
    /// Messages that make no sense to a host, or could not be read.
    pub refused: u64,
}

impl From<LedgerCounts> for TileReport {
    fn from(counts: LedgerCounts) -> Self {
        Self {
            pixels: counts.pixels,
            given: counts.given,
            given_again: counts.given_again,
            asked_again: counts.repeated,
            pixels_again: counts.duplicates,
            pixels_differing: counts.differing,
            messages: counts.messages,
            refused: counts.bad + counts.unexpected + counts.damaged,
        }
    }
}

/// What went wrong by request.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize)]
pub struct FaultReport {
    /// Packets lost on links.
    pub lost: u64,
    /// Packets doubled on links.
    pub doubled: u64,
    /// Packets delayed on links.
    pub delayed: u64,
    /// Packets that arrived late or doubled, and were dropped by their number.
    pub stale: u64,
    /// Packets for a dead node, dropped.
    pub for_the_dead: u64,
    /// Nodes that died before the end, by time.
    pub crashes: Vec<CrashReport>,
}

/// A node that died.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct CrashReport {
    /// The node.
    pub node: u16,
    /// When \[ns\].
    pub at_ns: u64,
}

/// What a node did for a while.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct TraceEvent {
    /// What: `trace`, `shade`, `clip`, `messages`, `checks`, `forwards`: what took most of it.
    pub name: &'static str,
    /// The node.
    pub node: u16,
    /// When it began \[ns\].
    pub start_ns: u64,
    /// How long it took \[ns\].
    pub duration_ns: u64,
}
