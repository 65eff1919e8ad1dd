use kiloray_core::node::Counts;
use kiloray_core::store::{Budget, LineBudget};
use kiloray_mesh::watch::Waits;
use serde::{Deserialize, Serialize};

use crate::{ProcessMemory, Spent};

/// What a node did, as it tells the host in the end.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct NodeReport {
    /// Its number.
    pub node: u16,
    /// Which of the processes that were there.
    pub incarnation: u32,
    /// What it did.
    pub counts: Counts,
    /// Where its time went.
    pub time: Spent,
    /// Bytes that it was given.
    pub memory: usize,
    /// Bytes in use when each line was fullest.
    pub peak_bytes: usize,
    /// The lines of its memory.
    pub lines: Vec<LineReport>,
    /// What its process held.
    pub process: ProcessMemory,
    /// Blocks it owns, the replicated top included.
    pub owned_blocks: u32,
    /// How long it waited for blocks and for answers to rays.
    #[serde(default, skip_serializing_if = "Waits::is_empty")]
    pub waits: Waits,
    /// Messages of the network that were for another process, or no packets.
    pub foreign: u64,
}

/// A line of a node's memory.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct LineReport {
    /// What it is for.
    pub name: String,
    /// Items it can hold.
    pub capacity: usize,
    /// Bytes it takes.
    pub bytes: usize,
    /// Most items it ever held.
    pub peak: usize,
    /// Their bytes.
    pub peak_bytes: usize,
}

impl NodeReport {
    /// Longest report that is read \[bytes\].
    pub const BYTES_MAX: usize = 128 << 10;

    /// Reads what a node has sent; `None` for what is no report.
    #[must_use]
    pub fn parse(bytes: &[u8]) -> Option<Self> {
        let bytes = Some(bytes).filter(|bytes| bytes.len() <= Self::BYTES_MAX)?;
        serde_json::from_slice(bytes).ok()
    }

    /// The lines of a memory.
    pub(crate) fn lines(budget: &Budget) -> Vec<LineReport> {
        budget.lines().iter().map(LineReport::from).collect()
    }
}

impl From<&LineBudget> for LineReport {
    fn from(line: &LineBudget) -> Self {
        Self {
            name: line.line.name().into(),
            capacity: line.capacity,
            bytes: line.bytes,
            peak: line.peak,
            peak_bytes: line.peak_bytes(),
        }
    }
}
