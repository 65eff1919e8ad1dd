use core::fmt::Debug;

#[cfg(feature = "bundles")]
use super::Neighbours;
use crate::trace::Cursor;

/// What a node works in during a step, and needs nothing of afterwards. Nodes that take their steps in turns may share it.
///
/// A [`Cursor`] is all that a node must have; rays are traced together where there is room for that, too.
pub trait Scratch: Debug {
    /// Lends what a traversal runs in.
    fn cursor<R>(&mut self, work: impl FnOnce(&mut Cursor) -> R) -> R;

    /// Lends room for rays that are traced together, as it was left by this node, or by another before this step; `None` if there is none.
    #[cfg(feature = "bundles")]
    fn neighbours<R>(&self, work: impl FnOnce(&mut Neighbours) -> R) -> Option<R>;
}

impl Scratch for Cursor {
    fn cursor<R>(&mut self, work: impl FnOnce(&mut Cursor) -> R) -> R {
        work(self)
    }

    #[cfg(feature = "bundles")]
    fn neighbours<R>(&self, _: impl FnOnce(&mut Neighbours) -> R) -> Option<R> {
        None
    }
}
