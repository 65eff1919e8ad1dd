//! What this machine can do at once.

/// Its cores, as far as this process may use them.
pub(crate) fn cores() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from)
}

/// As many threads as `--threads` says, else one for each core.
pub(crate) fn threads(asked: Option<u32>) -> usize {
    asked.map_or_else(cores, |threads| threads as usize)
}
