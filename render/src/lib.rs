//! Pictures on this machine.
//!
//! [`render`] runs the renderer of [`kiloray_core::render`] on all cores over a file in memory, or, with
//! [`Options::memory`], as a single node in an arena of that size, which fetches blocks from the file. The
//! pixels are the same, to the bit.
//!
//! [`Ledger`] is the host of a mesh: it gives out the tiles of a picture and puts it together, over whatever network there is.
//!
//! It is a crate of its own since pictures need no importer, and since it starts threads, which `kiloray-core` and `kiloray-simd` do not.

mod error;
pub mod framing;
mod job;
mod mapped;
mod mesh;
mod node;
mod options;
mod picture;
mod top;

#[cfg(test)]
mod tests;

pub use error::{Error, PictureError};
pub use job::{Control, Rendered, Report, plan, render};
pub use mesh::{Ledger, LedgerCounts, MeshLayout, MeshOptions, ThreadScratch, watch};
pub use options::{Lanes, Options};
pub use picture::{Picture, camera};
pub use top::Top;
