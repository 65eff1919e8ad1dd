//! A mesh of processes: one node of a mesh in each, joined by a network.
//!
//! Every process runs the actor of [`kiloray_core::node`], unchanged, in one arena of the size that it is given, over blocks that it maps from the
//! scene's file: those of its share. The picture has the bits of every other way to render it.
//!
//! Lowest first:
//!
//! * [`Transport`] is what a process knows of a network: packets to and from its neighbours, and which of them are there.
//!   [`Exchange`] is one within a process, for tests; [`Network`] one of [Zenoh](https://zenoh.io) sessions, the only place that knows it.
//! * [`drive`](drive()) runs an actor over a transport.
//! * [`Config`] is all that a process is told; [`run_node`] is a node's life, [`run_host`] the host's: the ledger of tiles, and who is there.
//! * [`Supervisor`] starts the nodes of one machine, and replaces those that die.
#![forbid(unsafe_code)]

mod config;
mod drive;
mod error;
mod exchange;
mod frame;
mod host;
mod identity;
mod job;
mod memory;
mod network;
mod node;
mod report;
mod security;
mod supervisor;
mod transport;

#[cfg(test)]
mod tests;

pub use config::{Config, MeshConfig, PictureConfig, ViewConfig};
pub use drive::{Drive, Spent, drive};
pub use error::Error;
pub use exchange::{Exchange, Wire};
pub use frame::Frame;
pub use host::{Control, Outcome, Status, run_host};
pub use identity::{Identity, Place};
pub use job::Job;
pub use memory::{PROCESS_BYTES, ProcessMemory};
pub use network::Network;
pub use node::{run_node, tie};
pub use report::{LineReport, NodeReport};
pub use security::TlsConfig;
pub use supervisor::{Folder, Replacement, Supervisor};
pub use transport::{Event, Transport};
