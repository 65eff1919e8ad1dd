use super::frame_table::{FrameEntry, FrameId, FrameTable, index_len};
use super::{Arena, ArenaFull};
use crate::tally::tally;
use core::fmt;

/// Fetched blocks, in frames of a node's arena.
///
/// A fetched block lies in its frame in the format of the file, and is thereby part of the tree for
/// every later task (dissertation, 4.5: there a flag and a list through the object sets; here the
/// lookup by block number is a table of its own, so that blocks stay untouched bytes). The least
/// recently used block leaves first; uses count from the first time on that one leaves.
///
/// A borrow of a block's bytes is its pin: while it is traced nothing can be evicted, and nothing can
/// wait, by the borrow's type.
///
/// # The life of a frame
/// 1. [`reserve`](Self::reserve) before the request leaves, so that the reply always has a place: *on its way*.
/// 2. Fragments are written to [`incoming`](Self::incoming); [`arrived`](Self::arrived) ends it: *cached*.
/// 3. A frame taken for [`Claim::Demand`] stays until its first [`get`](Self::get); one for
///    [`Claim::Prefetch`] may leave at any time.
///
/// No other frame is protected. A task needs one block at a time, and 3 keeps it until its first use; the dissertation (4.5) protects more, as its
/// tasks hold several blocks at once.
///
/// # Invariants
/// A block has at most one frame.
#[derive(Debug)]
pub struct BlockCache<'a> {
    table: FrameTable<'a>,
    frames: &'a mut [u8],
    block_bytes: usize,
    counts: CacheCounts,
}

/// Where a block is, for the cache.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Residency {
    /// In a frame.
    Cached,
    /// Requested; its frame is reserved.
    OnItsWay,
    /// In no frame.
    Remote,
}

/// For what a frame is taken.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Claim {
    /// A task cannot go on without the block: it stays until it was used once.
    Demand,
    /// The block may be of use. Never takes the last frame.
    Prefetch,
}

/// No frame can be had now: all are on their way or unused.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CacheFull;

impl fmt::Display for CacheFull {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("all block frames are in use")
    }
}

impl core::error::Error for CacheFull {}

/// What the cache did so far.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct CacheCounts {
    /// Times a block was asked for and in a frame. (A node does not ask for the blocks that it owns.)
    pub hits: u64,
    /// Times a block was waited for as it was in no frame.
    pub misses: u64,
    /// Blocks that left for another.
    pub evictions: u64,
    /// Blocks that arrived.
    pub fetched: u64,
    /// Most frames in use at once.
    pub frames_peak: u64,
}

impl CacheCounts {
    pub(crate) fn add(&mut self, other: &Self) {
        tally!(self, other, Self { sum hits, misses, evictions, fetched; max frames_peak; });
    }
}

impl<'a> BlockCache<'a> {
    /// A cache with `frames` empty frames in `arena`.
    ///
    /// # Errors
    /// [`ArenaFull`] if the arena has not the bytes.
    pub fn new(
        arena: &mut Arena<'a>,
        block_bytes: usize,
        frames: usize,
    ) -> Result<Self, ArenaFull> {
        let entries: &mut [FrameEntry] = arena.carve(frames)?;
        let index: &mut [u32] = arena.carve(index_len(frames))?;
        Ok(Self {
            table: FrameTable::new(entries, index),
            frames: arena.carve(block_bytes.saturating_mul(frames))?,
            block_bytes,
            counts: CacheCounts::default(),
        })
    }

    /// Where a block is. Changes and counts nothing.
    #[must_use]
    pub fn residency(&self, block: u32) -> Residency {
        match self.table.find(block) {
            Some(frame) if self.table.is_on_its_way(frame) => Residency::OnItsWay,
            Some(_) => Residency::Cached,
            None => Residency::Remote,
        }
    }

    /// The bytes of a block that is here: a hit, and its frame becomes the newest. Whether it is a [miss](Self::note_miss) if it is not here, the caller knows.
    #[inline]
    pub fn get(&mut self, block: u32) -> Option<&[u8]> {
        let found = self.find(block)?;
        self.bytes(found)
    }

    /// As [`get`](Self::get), with the bytes left to [`bytes`](Self::bytes).
    #[inline]
    pub(super) fn find(&mut self, block: u32) -> Option<FrameId> {
        let found = self.first_use(block);
        self.counts.hits = self.counts.hits.saturating_add(found.is_some().into());
        found
    }

    /// A block is waited for.
    pub fn note_miss(&mut self) {
        self.counts.misses = self.counts.misses.saturating_add(1);
    }

    /// As [`find`](Self::find), but no hit: the miss that made the block come has been counted.
    pub(super) fn first_use(&mut self, block: u32) -> Option<FrameId> {
        self.table.used(block)
    }

    /// What lies in a frame.
    #[inline]
    pub(super) fn bytes(&self, frame: FrameId) -> Option<&[u8]> {
        let at = frame.index().checked_mul(self.block_bytes)?;
        self.frames.get(at..)?.get(..self.block_bytes)
    }

    /// Sees to it that a block has a frame; one that is here or on its way keeps the one it has.
    /// `Ok(true)` says that the frame is new and the block must be requested.
    ///
    /// # Errors
    /// [`CacheFull`] if no frame can be had now, or, for a prefetch, only the last one.
    pub fn reserve(&mut self, block: u32, claim: Claim) -> Result<bool, CacheFull> {
        if self.residency(block) != Residency::Remote {
            return Ok(false);
        }
        if claim == Claim::Prefetch && self.table.available() < 2 {
            return Err(CacheFull);
        }
        let evicted = self.table.take(block, claim == Claim::Demand).ok_or(CacheFull)?;
        self.counts.evictions = self.counts.evictions.saturating_add(u64::from(evicted));
        let used = self.table.len().saturating_sub(self.table.free_len()) as u64;
        self.counts.frames_peak = self.counts.frames_peak.max(used);
        Ok(true)
    }

    /// Where the bytes of a block on its way belong. `None` for any other block: a late or doubled
    /// reply is dropped.
    pub fn incoming(&mut self, block: u32) -> Option<&mut [u8]> {
        let frame = self.on_its_way(block)?;
        let at = frame.index().checked_mul(self.block_bytes)?;
        self.frames.get_mut(at..)?.get_mut(..self.block_bytes)
    }

    /// All bytes of a block on its way have been written, and checked. `false` for any other block.
    pub fn arrived(&mut self, block: u32) -> bool {
        let Some(frame) = self.on_its_way(block) else { return false };
        self.counts.fetched = self.counts.fetched.saturating_add(1);
        self.table.arrived(frame);
        true
    }

    /// Gives up the frame of a block, whatever its state: it was damaged, or nobody waits for it.
    pub fn discard(&mut self, block: u32) {
        if let Some(frame) = self.table.find(block) {
            self.table.release(frame);
        }
    }

    /// Keeps the frame of a block, the last one too.
    #[cfg(test)]
    pub(crate) fn pin(&mut self, block: u32, pins: bool) {
        if let Some(frame) = self.table.find(block).filter(|_| pins) {
            self.table.pin(frame);
        }
    }

    /// Keeps none any more.
    #[cfg(test)]
    pub(crate) fn unpin(&mut self) {
        self.table.unpin();
    }

    /// All of it but what it counts.
    #[cfg(test)]
    pub(crate) fn snapshot(&mut self, snapshot: &mut crate::tests::snapshot::Snapshot) {
        self.table.snapshot(snapshot);
        for frame in self.frames.chunks_mut(self.block_bytes) {
            snapshot.bytes(frame);
        }
        self.counts = CacheCounts::default();
    }

    /// Number of frames.
    #[must_use]
    pub const fn capacity(&self) -> usize {
        self.table.len()
    }

    /// Bytes of a block.
    #[must_use]
    pub const fn block_bytes(&self) -> usize {
        self.block_bytes
    }

    /// What it did so far.
    #[must_use]
    pub const fn counts(&self) -> CacheCounts {
        self.counts
    }

    fn on_its_way(&self, block: u32) -> Option<FrameId> {
        self.table.find(block).filter(|&frame| self.table.is_on_its_way(frame))
    }
}

#[cfg(test)]
mod tests;
