use super::{Dealing, Placement};
use crate::block::{BlockSource, BlockView};
use crate::network::NodeId;
use crate::store::BlockCache;

/// Blocks that a node reads in place: its share of the scene.
#[derive(Debug, Clone, Copy)]
pub struct Rom<'a> {
    bytes: &'a [u8],
    block_bytes: usize,
    placement: Placement,
    here: NodeId,
    /// The ranges it holds: the top, and one for each copy of [`Dealing::Subtrees`].
    ranges: [(u32, u32); 1 + COPIES],
    /// The node's blocks back to back, rather than those of all nodes.
    packed: bool,
}

/// Copies whose ranges are kept; more are looked up by the formula.
const COPIES: usize = 3;

impl<'a> Rom<'a> {
    /// The share of node `here` in a file whose blocks lie back to back in `bytes`.
    #[must_use]
    pub fn of_file(
        bytes: &'a [u8],
        block_bytes: usize,
        placement: Placement,
        here: NodeId,
    ) -> Self {
        let mut ranges = [(0, 0); 1 + COPIES];
        for (copy, range) in ranges.iter_mut().enumerate() {
            *range = match copy.checked_sub(1) {
                None => (0, placement.top.min(placement.blocks)),
                Some(copy) if copy < usize::from(placement.copies()) => {
                    placement.range(here, copy as u16).unwrap_or((0, 0))
                }
                Some(_) => (0, 0),
            };
        }
        Self { bytes, block_bytes, placement, here, ranges, packed: false }
    }

    /// The share of node `here`, with nothing else in `bytes`: the top, then range behind range, or by number where blocks are dealt in turn.
    #[must_use]
    pub fn of_share(
        bytes: &'a [u8],
        block_bytes: usize,
        placement: Placement,
        here: NodeId,
    ) -> Self {
        Self { packed: true, ..Self::of_file(bytes, block_bytes, placement, here) }
    }

    /// Whose share it is.
    #[must_use]
    pub const fn here(&self) -> NodeId {
        self.here
    }

    /// Whether the node has this block.
    #[inline]
    #[must_use]
    pub fn holds(&self, block: u32) -> bool {
        if self.is_in_range(block) {
            return true;
        }
        let looked_up = matches!(self.placement.dealing, Dealing::RoundRobin)
            || usize::from(self.placement.copies()) > COPIES;
        looked_up && self.placement.holds(self.here, block)
    }

    /// A block that the node has.
    #[inline]
    #[must_use]
    pub fn block(&self, block: u32) -> Option<&'a [u8]> {
        if !self.holds(block) {
            return None;
        }
        let index = if self.packed { self.place(block) } else { block as usize };
        let at = index.checked_mul(self.block_bytes)?;
        self.bytes.get(at..)?.get(..self.block_bytes)
    }

    /// Where a block of the node lies among its blocks in a [share](Self::of_share): range behind range, then by number.
    #[must_use]
    pub fn place(&self, block: u32) -> usize {
        let mut before = 0;
        for &(first, end) in &self.ranges {
            if (first..end).contains(&block) {
                return (before + u64::from(block.wrapping_sub(first))) as usize;
            }
            before += u64::from(end.saturating_sub(first));
        }
        let (top, in_top) = (self.placement.top, before as usize);
        let behind = |&b: &u32| self.holds(b) && !self.is_in_range(b);
        in_top.saturating_add((top..block).filter(behind).count())
    }

    #[inline]
    fn is_in_range(&self, block: u32) -> bool {
        self.ranges.iter().any(|&(first, end)| (first..end).contains(&block))
    }

    /// Whether the node has all blocks.
    #[must_use]
    pub fn holds_all(&self) -> bool {
        self.placement.nodes <= self.placement.copies()
            || self.placement.top >= self.placement.blocks
    }

    /// Blocks that the node has.
    #[must_use]
    pub fn len(&self) -> usize {
        self.placement.held(self.here) as usize
    }

    /// Whether the node has no block.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// The blocks that a node can read now: its share, and those in frames.
#[derive(Debug)]
pub(super) struct Blocks<'a> {
    pub(super) rom: Rom<'a>,
    pub(super) cache: BlockCache<'a>,
    /// A broken rule: what a ray has used is kept until a ray ends.
    #[cfg(test)]
    pub(super) pins: bool,
}

/// A block that is not here.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Missing(pub u32);

impl BlockSource for Blocks<'_> {
    type Error = Missing;

    #[inline]
    fn block(&mut self, block: u32) -> Result<BlockView<'_>, Missing> {
        let bytes = match self.rom.block(block) {
            Some(bytes) => Some(bytes),
            None => {
                #[cfg(test)]
                self.cache.pin(block, self.pins);
                self.cache.get(block)
            }
        };
        bytes.map(BlockView::trusted).ok_or(Missing(block))
    }

    #[inline]
    fn holds_all(&self) -> bool {
        self.rom.holds_all()
    }
}
