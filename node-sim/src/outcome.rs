use kiloray_core::network::NodeId;
use kiloray_mesh::MeshOptions;
use kiloray_render::Picture;

use crate::Report;

/// What came of a run.
#[derive(Debug, Clone, PartialEq)]
pub struct Outcome {
    /// The picture; black where it is incomplete.
    pub picture: Picture,
    /// Why it ended.
    pub end: End,
    /// Pixels whose sum was too great to count.
    pub overflows: u64,
    /// How the run was divided: the options, with what was found where nothing was said.
    pub division: MeshOptions,
    /// What was done.
    pub report: Report,
}

/// Why a run ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum End {
    /// All pixels are there.
    Complete,
    /// It was cancelled.
    Cancelled,
    /// Of this block no living node holds a copy.
    Lost(u32),
    /// Nothing happens any more but what this node does, which is slow: it would take too long.
    Slow(NodeId),
    /// Nothing happens any more: a mistake of ours.
    Stuck,
}

impl Outcome {
    /// Whether all pixels are there.
    #[must_use]
    pub fn is_complete(&self) -> bool {
        self.end == End::Complete
    }

    /// The block of which no copy is left, if that is why it is not complete.
    #[must_use]
    pub const fn lost(&self) -> Option<u32> {
        match self.end {
            End::Lost(block) => Some(block),
            _ => None,
        }
    }
}
