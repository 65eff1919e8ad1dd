use serde::Serialize;

/// How a run went on, in equal steps of time.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct Timeline {
    /// Length of a step \[ns\].
    pub step_ns: u64,
    /// The steps, at most 256.
    pub samples: Vec<Sample>,
}

/// A step of time.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct Sample {
    /// Nodes at work, on average.
    pub busy: f64,
    /// Of them, those that traced and shaded: over all nodes the efficiency of this step.
    pub useful: f64,
    /// Nodes that waited for blocks, answers or room to send, on average.
    pub waiting: f64,
    /// Nodes without work, on average.
    pub idle: f64,
    /// Nodes that had crashed, on average.
    pub dead: f64,
    /// Rays that all nodes together held for later, the most in this step.
    pub stored: u64,
    /// Bytes sent on links, headers included.
    pub link_bytes: u64,
    /// Pixels that were complete at its end.
    pub pixels: u64,
}
