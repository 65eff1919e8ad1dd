//! Mutation fuzzing of every parser and of what comes over links, on stable Rust.
//!
//! `cargo run --release -p kiloray-fuzz -- --seconds 600` takes each [`Target`] in turn: it mutates
//! the seeds of `fuzz/corpus/TARGET`, keeps what brings out a new answer (a new kind of error or
//! note), and demands that no input panics, hangs or takes more memory than [`memory_max`]. What
//! breaks is written to `fuzz/found/` and fails the run; `--replay FILE` runs one file again. The
//! tests of this crate run the seeds and a few thousand mutations of each.
//!
//! Everything follows from the seed that is printed, except where the time limit cuts it off.
//!
//! `cargo fuzz` and `bolero` with libFuzzer need a nightly compiler, for the coverage that guides them; what guides this one is what parsers say. So it runs wherever the tests do.
//! Formats of bytes (files, packets, setups) begin from what their writers make, not from files of a corpus, which each change of a format would outdate.

mod corpus;
mod host;
mod link;
mod mesh;
mod mutate;
mod node;
mod picture;
mod run;
mod target;

pub use corpus::seeds;
pub use run::{Finding, Report, Run, memory_max};
pub use target::Target;
