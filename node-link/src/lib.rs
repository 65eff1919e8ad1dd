//! Serial links between nodes: packets as frames over any asynchronous byte stream.
//!
//! A board brings its UARTs, a PC its serial devices or sockets, as readers and writers of [`embedded_io_async`]; the rest is the same on both ends.
//!
//! * [`frame`]: a packet and its checksum between two zeros.
//! * [`Receiver`] and [`Sender`]: the two halves of a link, as [`core::node::run`](kiloray_core::node::run) wants them. Damaged frames are counted and
//!   dropped; the packets above heal by themselves.
//! * [`Link`] and [`ask`]: a node that has been switched on asks its neighbours for the [`Setup`](kiloray_core::node::Setup) of the run until one
//!   has it; whoever runs answers. So a setup spreads from the host over the mesh, whatever is lost and whoever comes late. Ends of different versions
//!   both find out.
#![cfg_attr(not(test), no_std)]
#![forbid(unsafe_code)]
#![cfg_attr(
    not(test),
    warn(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::indexing_slicing)
)]

mod counts;
pub mod frame;
mod serial;
mod start;
#[cfg(test)]
mod tests;

pub use counts::{LinkCounts, Tally};
pub use serial::{Receiver, Sender};
pub use start::{Link, NoSetup, ask};
