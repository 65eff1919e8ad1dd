//! Pictures on this machine.
//!
//! [`render`] runs the renderer of [`kiloray_core::render`] on all cores over a file in memory, or, with
//! [`Options::memory`], as a single node in an arena of that size, which fetches blocks from the file. The
//! pixels are the same, to the bit.
//!
//! With [`Options::undersampling`] a picture takes fewer camera rays than it has pixels, in rounds over all its tiles.
//!
//! [`MeshNode`] is a node of a mesh on this machine, simulated or as a process.
//!
//! It is a crate of its own since pictures need no importer, and since it starts threads, which `kiloray-core` and `kiloray-simd` do not.
//! All of tracing is compiled here, with all lanes: its tests stand beside it, in `tests`, so that they do not compile it once more.

mod error;
pub mod framing;
mod job;
mod mapped;
mod mesh_node;
mod node;
mod options;
mod picture;
mod scratch;
mod top;
mod undersampled;

pub use error::{Error, PictureError};
pub use job::{Control, Rendered, Report, plan, render};
pub use mesh_node::MeshNode;
pub use options::{Lanes, Options, Undersampling};
pub use picture::{Picture, camera, filled};
pub use scratch::ThreadScratch;
pub use top::Top;
