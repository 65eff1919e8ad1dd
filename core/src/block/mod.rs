//! A block: a piece of the tree as position-independent bytes, read in place.
//!
//! [`format`] is the layout, byte by byte. [`BlockView::parse`] checks every index of a block once, on
//! arrival; nothing of a block is trusted before. [`KiloView`] reads a whole file, from a mapping or
//! from flash. [`BlockSource`] is where a traversal gets its blocks. [`ExpandedTop`] is the top of the tree for machines with memory to spare.

mod check;
mod error;
mod expanded;
mod file;
pub mod format;
pub mod octahedral;
mod source;
mod tables;
mod view;

pub use error::BlockError;
pub use expanded::{Expanded, ExpandedChild, ExpandedNode, ExpandedTop};
pub use file::{FileError, KiloView, Table};
pub use source::{BlockSource, NoBlock};
pub use view::{BlockLimits, BlockView, Vertices, checksum};

/// Whether this build has spheres; without them a block that holds one is refused.
pub const SPHERES: bool = cfg!(feature = "sphere");
