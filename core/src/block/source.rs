use core::fmt;

use super::expanded::ExpandedTop;
use super::file::KiloView;
use super::view::BlockView;

/// Where a traversal gets its blocks, by number.
///
/// A traversal holds one view at a time, and asks again when it comes back to a block: a source may
/// give the frame of the last block to the next. What it gives must be the same bytes each time, and
/// accepted by [`BlockView::parse`] once.
pub trait BlockSource {
    /// Why a block is not here. A cache that fetches and waits has errors of its medium; one that
    /// cannot wait says "missing", and the traversal goes on by its trail when the block has come.
    type Error;

    /// The block with this number.
    ///
    /// # Errors
    /// As the source defines; the traversal stops, and can go on by its [trail](crate::trace::Trail).
    fn block(&mut self, block: u32) -> Result<BlockView<'_>, Self::Error>;

    /// Whether all blocks are at hand, so that asking for one costs nothing and replaces no other.
    #[inline(always)]
    fn holds_all(&self) -> bool {
        false
    }

    /// The top of the tree, if it is here a second time, expanded. It must be that of the blocks, and only a source that
    /// [holds all](Self::holds_all) of them is asked for it: a traversal stops at no block below it.
    #[inline(always)]
    fn top(&self) -> ExpandedTop<'_> {
        ExpandedTop::NONE
    }
}

/// The file has no block of this number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct NoBlock(pub u32);

impl fmt::Display for NoBlock {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "the file has no block {}", self.0)
    }
}

impl core::error::Error for NoBlock {}

/// A file in memory has all its blocks. They must have been checked before.
impl BlockSource for KiloView<'_> {
    type Error = NoBlock;

    #[inline(always)]
    fn block(&mut self, block: u32) -> Result<BlockView<'_>, NoBlock> {
        self.trusted_block(block).ok_or(NoBlock(block))
    }

    #[inline(always)]
    fn holds_all(&self) -> bool {
        true
    }
}

impl<S: BlockSource + ?Sized> BlockSource for &mut S {
    type Error = S::Error;

    #[inline(always)]
    fn block(&mut self, block: u32) -> Result<BlockView<'_>, S::Error> {
        (**self).block(block)
    }

    #[inline(always)]
    fn holds_all(&self) -> bool {
        (**self).holds_all()
    }

    #[inline(always)]
    fn top(&self) -> ExpandedTop<'_> {
        (**self).top()
    }
}
