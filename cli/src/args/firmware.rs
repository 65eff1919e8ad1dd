//! What a board's firmware takes of its RAM beside the memory of its node: rounded up from what `node-board/sizes` prints.

/// The future of the node's task, the buffers of its lines, and what else has its place from the start \[bytes\].
pub(crate) const STATICS: u64 = 13 << 10;
/// The deepest calls and an interrupt \[bytes\].
pub(crate) const STACK: u64 = 11 << 10;
