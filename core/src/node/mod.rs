//! The actor: a node of a mesh, in one arena.
//!
//! [`Node`] is plain functions from its state, the packets in its router and a time to a new state, packets and counted [`Work`]:
//! it waits for nothing, reads no clock and holds no link. A host (the simulator, a process, a board) calls [`Node::poll`], carries packets between
//! [routers](crate::network::Router), and turns work into time or lets it take its own. [`run`] does so as one `async fn`, over links and a clock
//! that a process or a board gives it.
//!
//! # What it holds
//!
//! | line | what |
//! | --- | --- |
//! | rays | a slot for each path under way, from its start to its end |
//! | shadow rays | those that are run here, waiting for a bundle or a block |
//! | roots | what waits for rays to end: tiles in work, and visits (rays of other nodes) |
//! | fetches, frames | blocks on their way, blocks here |
//! | outbox, inbox, router | messages |
//!
//! # How a path runs
//!
//! Every ray carries its share of the pixel, and what it brings is an integer ([`crate::shade`]). So a hit adds its light to its *root*,
//! its shadow rays go to the queue, its first child takes over its slot and the second gets another: no point waits for its children, the root
//! only counts what is open. What must wait is a ray that was sent to another node: its slot is what it is made again from, and what it is run in
//! if nobody else has room.
//!
//! At the other end the ray is a *visit*: a root that answers when nothing of it is open. A visit of which a single ray is left
//! gives that ray its own return address and what it has brought so far, and is gone (a tail call): the answer goes past it.
//!
//! # Who goes where
//!
//! A ray that needs a block which is not here either waits for it (demand driven) or goes to its owner (data parallel): [`Schedule`] says which, by the
//! kind of the ray. All else is the same for all schedules.
//!
//! # Why it always ends
//!
//! The rules are named where they are kept. What holds a slot waits only for: room in a buffer, a block, an answer, or another slot.
//! Buffers empty since replies are consumed at once and requests answered or refused (rules 1 to 6); a block comes since its frame is reserved and its owner answers without waiting
//! for anything but buffers (11 to 13); an answer comes, or the ray is run at home (8); for slots see `Node::reserve` (7).

mod actor;
mod counts;
mod fetch;
mod figures;
mod group;
mod help;
mod inbox;
#[cfg(debug_assertions)]
mod invariants;
mod outbox;
mod picture;
mod placement;
mod plan;
mod points;
mod rays;
mod rom;
mod rules;
mod settings;
mod setup;
mod shadows;
mod share;
mod shell;
mod slots;
mod tell;
#[cfg(test)]
mod tests;
mod tiles;
mod together;
mod work;
mod world;

pub use actor::Node;
pub use counts::{Counts, Kind, Kinds};
pub use fetch::signal;
pub use figures::Figures;
pub use picture::{Lights, Picture};
pub use placement::{Dealing, Placement};
pub use plan::{NodeNeeds, NodePlan};
pub use rom::{Missing, Rom};
pub use settings::{PointHome, Prefetch, RayKind, Schedule, Settings, ShadowPolicy, TaskOrder};
pub use setup::{Setup, SetupError};
pub use share::{Share, ShareError, ShareHeader};
pub use shell::{Actor, Clock, Joint, Receive, Transmit, run};
pub use work::{Lack, Next, Progress, Time, Work};
pub use world::{Ends, Lit, Traced, World};
