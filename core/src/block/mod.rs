//! A block: a piece of the octree as position-independent bytes, read in place.
//!
//! [`format`] is the layout, byte by byte. `BlockView::parse` checks every index of a block once, on
//! arrival; nothing of a block is trusted before.

pub mod format;
pub mod octahedral;
