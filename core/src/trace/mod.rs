//! Closest hit, any hit and transmittance over blocks.
//!
//! One traversal serves all machines. It is generic over [`Lanes`] (how many boxes and triangles are
//! tested at once: [`Scalar`] here, eight in `kiloray-simd`), over the [`BlockSource`](crate::block::BlockSource) (a
//! mapped file, a cache that fetches, a node that must wait) and over what is asked of the ray. The
//! [hit](crate::geometry#what-a-hit-is) is the same to the bit, whatever of these is used.
//!
//! A traversal is depth first, the slots of a node in the order that it has for the ray's signs. Its whole state
//! lies in a [`Cursor`] of fixed size, and it holds one block at a time: a source that does not have a
//! block stops it, and it goes on by its [`Trail`], 20 bytes, on any machine.
//!
//! Rays come one by one (`walk.rs`), or many at a time (`stream.rs`): as a [`Bundle`], whose rays wait each for itself where a block is lacking, or as a
//! [`Batch`], which then begins anew.
//!
//! # Why no box test loses a hit
//!
//! See [`BoxFrame`].

mod batch;
mod beam;
mod bundle;
mod clip;
mod code;
mod cursor;
mod flow;
mod frame;
mod group;
mod lanes;
mod leaf;
mod query;
mod restart;
mod scalar;
mod stack;
mod stream;
#[cfg(test)]
pub(crate) mod tests;
mod top;
mod tracer;
mod trail;
mod turn;
mod walk;

pub use batch::Batch;
pub use beam::Beam;
pub use bundle::{BUNDLE, Bundle, BundleVisited};
pub use clip::{Clip, ClipCounts, ClipEntry};
pub(crate) use clip::{Frame as ClipFrame, primitives};
pub use cursor::{Cursor, TraceError, Visited};
pub use frame::{BoxFrame, BoxRay};
pub use group::{Crossings, Filled, GROUP, Group, Kind, Octet, Quad, Row, Verdict};
pub use lanes::{Kernel, Lanes};
pub use query::{Query, Whole};
pub use scalar::Scalar;
pub use stack::{Met, Places};
pub use tracer::{Search, Tracer};
pub use trail::Trail;
pub use turn::Turn;
