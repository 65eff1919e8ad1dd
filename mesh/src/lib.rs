//! The host's side of a mesh: no I/O, no threads, no clock; whoever has a network brings messages and the time.
//!
//! * [`Ledger`] gives tiles to those that ask, takes their pixels, and knows when all is there.
//! * [`Watch`](watch::Watch) takes down how long nodes wait, from the packets that it is shown.
//! * [`MeshLayout`] divides blocks, memory and picture among the nodes, before it begins.
//!
//! Every message may be lost, doubled, late or overtaken, and any node may die:
//!
//! | what happens | what follows |
//! | --- | --- |
//! | an ask or its grant is lost | the node asks again under the same number, and gets the same places |
//! | an ask is doubled | so is the grant; the node takes the one with its number, once |
//! | pixels are lost | the node has no acceptance, and sends them again |
//! | an acceptance is lost | the node sends pixels again, and hears again that the tile is complete |
//! | pixels are doubled, or come from two nodes | they are the same, as a tile's sums do not depend on who renders it; the first are kept |
//! | a node dies, is slow, or never hears of a grant | its tiles become overdue, and are given to others when nothing else is left |

mod delay;
mod layout;
mod leases;
mod ledger;
mod outbox;
pub mod watch;

#[cfg(test)]
mod tests;

pub use layout::{MeshLayout, MeshOptions};
pub use ledger::{Ledger, LedgerCounts};
