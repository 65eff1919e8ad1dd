//! The network of a mesh as its nodes know it: who is next to whom, which way a packet goes, and how
//! a link never overruns the buffer at its far end.
//!
//! * [`Topology`] names nodes and ports, and gives the next hop of a deadlock-free route; [`Mesh`] adds the host.
//! * [`CreditSender`] and [`CreditReceiver`] are the two ends of one lane of a link.
//! * [`Router`] holds the packets of a node: those that pass, arrive and leave.
//!
//! The rules that they keep are those of bounded progress: two channels (requests and replies) of
//! own buffers and own credit, each split in two [classes](Hop::class) where routes wrap round.

mod buffers;
mod credit;
mod grid;
mod heads;
mod mesh;
mod packet;
mod parse;
mod port;
mod router;
mod topology;

pub use buffers::{HOST_REPLY_MAX, RouterSize, Site};
pub use credit::{Arrival, CreditReceiver, CreditSender, Sequence};
pub use grid::{DIMENSIONS_MAX, Grid};
pub use mesh::{HOST, Mesh};
pub use packet::{Channel, LANES, Lane, PacketHeader};
pub use parse::TopologyError;
pub use router::{Busy, Received, Router};
pub use topology::{Hop, NODES_MAX, NodeId, Port, Topology};
