use kiloray_render::{MeshOptions, Picture};

use crate::Report;

/// What came of a run.
#[derive(Debug, Clone, PartialEq)]
pub struct Outcome {
    /// The picture; black where it is incomplete.
    pub picture: Picture,
    /// Whether all pixels are there.
    pub complete: bool,
    /// The block of which no copy is left, if that is why it is not complete; it was cancelled else.
    pub lost: Option<u32>,
    /// Pixels whose sum was too great to count.
    pub overflows: u64,
    /// How the run was divided: the options, with what was found where nothing was said.
    pub division: MeshOptions,
    /// What was done.
    pub report: Report,
}
