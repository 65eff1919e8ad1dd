use super::{Dealing, Placement};
use crate::block::{BlockSource, BlockView};
use crate::network::NodeId;
use crate::store::{Arena, ArenaFull, BlockCache};

/// Blocks that a node reads in place: its share of the scene.
#[derive(Debug, Clone, Copy)]
pub struct Rom<'a> {
    bytes: &'a [u8],
    block_bytes: usize,
    placement: Placement,
    here: NodeId,
    /// The ranges it holds: the top, and one for each copy of [`Dealing::Subtrees`].
    ranges: [Range; 1 + COPIES],
    /// The node's blocks back to back, rather than those of all nodes.
    packed: bool,
}

/// Blocks that follow each other in the scene and in memory.
#[derive(Debug, Clone, Copy)]
struct Range {
    first: u32,
    len: u32,
    /// Blocks before it in a share.
    at: u32,
}

impl Range {
    const EMPTY: Self = Self { first: 0, len: 0, at: 0 };

    /// Where a block of the range lies in a share.
    #[inline(always)]
    fn place(&self, block: u32) -> Option<usize> {
        let index = block.wrapping_sub(self.first);
        (index < self.len).then(|| self.at.wrapping_add(index) as usize)
    }
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
        let mut ranges = [Range::EMPTY; 1 + COPIES];
        let mut at: u32 = 0;
        for (copy, range) in ranges.iter_mut().enumerate() {
            let (first, end) = match copy.checked_sub(1) {
                None => (0, placement.top.min(placement.blocks)),
                Some(copy) if copy < usize::from(placement.copies()) => {
                    placement.range(here, copy as u16).unwrap_or((0, 0))
                }
                Some(_) => (0, 0),
            };
            *range = Range { first, len: end.saturating_sub(first), at };
            at = at.saturating_add(range.len);
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
        self.place_in_range(block).is_some()
            || self.has_others() && self.placement.holds(self.here, block)
    }

    /// A block that the node has.
    #[inline(always)]
    #[must_use]
    pub fn block(&self, block: u32) -> Option<&'a [u8]> {
        match self.place_in_range(block) {
            Some(place) => self.bytes_of(block, place),
            None if self.has_others() && self.placement.holds(self.here, block) => {
                self.bytes_of(block, self.place(block))
            }
            None => None,
        }
    }

    /// Where a block of the node lies among its blocks in a [share](Self::of_share): range behind range, then by number.
    #[must_use]
    pub fn place(&self, block: u32) -> usize {
        self.place_in_range(block).unwrap_or_else(|| {
            let before =
                self.ranges.iter().fold(0, |sum: u32, range| sum.saturating_add(range.len));
            let first = if self.placement.dealing == Dealing::Subtrees { COPIES as u16 } else { 0 };
            let others = (first..self.placement.copies())
                .map(|copy| self.placement.before(self.here, copy, block));
            others.fold(before, u32::saturating_add) as usize
        })
    }

    #[inline(always)]
    fn place_in_range(&self, block: u32) -> Option<usize> {
        self.ranges.iter().find_map(|range| range.place(block))
    }

    /// Whether it may have blocks in none of its ranges.
    #[inline]
    fn has_others(&self) -> bool {
        self.placement.dealing == Dealing::RoundRobin
            || usize::from(self.placement.copies()) > COPIES
    }

    /// The bytes of a block, of which the place in a share is known.
    #[inline(always)]
    fn bytes_of(&self, block: u32, place: usize) -> Option<&'a [u8]> {
        let index = if self.packed { place } else { block as usize };
        self.bytes.get(index.checked_mul(self.block_bytes)?..)?.get(..self.block_bytes)
    }

    /// The same share in the arena, as on a machine that has no other memory.
    ///
    /// # Errors
    /// [`ArenaFull`] if it does not fit.
    pub fn copied<'m>(&self, arena: &mut Arena<'m>) -> Result<Rom<'m>, ArenaFull> {
        let bytes: &'m mut [u8] = arena.carve(self.len().saturating_mul(self.block_bytes))?;
        for block in (0..self.placement.blocks).filter(|&block| self.holds(block)) {
            let begin = self.place(block).saturating_mul(self.block_bytes);
            let place = bytes.get_mut(begin..).and_then(|rest| rest.get_mut(..self.block_bytes));
            if let (Some(place), Some(block)) = (place, self.block(block)) {
                place.copy_from_slice(block);
            }
        }
        Ok(Rom::of_share(bytes, self.block_bytes, self.placement, self.here))
    }

    /// A block of the top, which all nodes have: most visits are to these.
    #[inline(always)]
    fn top(&self, block: u32) -> Option<&'a [u8]> {
        let [top, ..] = &self.ranges;
        self.bytes_of(block, top.place(block)?)
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

impl Blocks<'_> {
    /// The bytes of a block that is not of the top.
    #[inline(never)]
    fn below(&mut self, block: u32) -> Option<&[u8]> {
        match self.rom.block(block) {
            Some(bytes) => Some(bytes),
            None => {
                #[cfg(test)]
                self.cache.pin(block, self.pins);
                self.cache.get(block)
            }
        }
    }
}

impl BlockSource for Blocks<'_> {
    type Error = Missing;

    #[inline(always)]
    fn block(&mut self, block: u32) -> Result<BlockView<'_>, Missing> {
        let bytes = match self.rom.top(block) {
            Some(bytes) => Some(bytes),
            None => self.below(block),
        };
        bytes.map(BlockView::trusted).ok_or(Missing(block))
    }

    #[inline]
    fn holds_all(&self) -> bool {
        self.rom.holds_all()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::store::{CHUNK_BYTES, Chunk};
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn a_share_in_the_arena_has_the_blocks_of_the_file_and_no_byte_more(
            blocks in 1_u32..60, nodes in 1_u16..10, top in 0_u32..8, replicas in 1_u16..6, robin: bool,
        ) {
            let dealing = if robin { Dealing::RoundRobin } else { Dealing::Subtrees };
            let placement = Placement { dealing, blocks, nodes, top, replicas };
            let block_bytes = CHUNK_BYTES;
            let file: Vec<u8> = (0..blocks).flat_map(|b| vec![b as u8; block_bytes]).collect();
            for here in (0..nodes).map(NodeId) {
                let rom = Rom::of_file(&file, block_bytes, placement, here);
                let mut memory = vec![Chunk::ZERO; rom.len()];
                let mut arena = Arena::new(&mut memory);
                let copy = rom.copied(&mut arena).unwrap();
                for block in 0..blocks {
                    prop_assert_eq!(copy.block(block), rom.block(block));
                    prop_assert_eq!(copy.block(block).is_some(), placement.holds(here, block));
                }
                prop_assert!(rom.is_empty() || rom.copied(&mut arena).is_err());
            }
        }
    }
}
