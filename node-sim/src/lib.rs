//! A mesh of nodes in virtual time.
//!
//! [`simulate`](simulate()) runs the real node actor of [`kiloray_core::node`] in every node, joined by the real routers of
//! [`kiloray_core::network`], over links with bandwidth, latency and faults. The operations that a node
//! carries out become virtual time by a [`Profile`]. The same options give the same run, to the byte.
#![forbid(unsafe_code)]

mod arenas;
mod check;
mod error;
mod options;
mod outcome;
mod pace;
mod plan;
mod profile;
mod report;
mod run;
mod simulate;
mod watchdog;

#[cfg(test)]
mod tests;

pub use error::Error;
/// The picture, and how it is divided among the nodes.
#[doc(no_inline)]
pub use kiloray_mesh::{MeshLayout, MeshOptions};
pub use options::{Control, Crash, Faults, Link, Options, Rate, Slow, Status, Switching};
pub use outcome::{End, Outcome};
pub use plan::{least, plan};
pub use profile::{Profile, estimates};
pub use report::{
    CrashReport, FaultReport, Histogram, HistogramBucket, Latencies, LineReport, LinkReport,
    MeshReport, MessageReport, NodeReport, NodeTime, Report, Sample, TileReport, Timeline, Totals,
    TraceEvent, TraceFlow,
};
pub use simulate::{TASK_BYTES, simulate};
