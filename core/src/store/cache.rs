use super::frame_table::{FrameEntry, FrameId, FrameTable, index_len};
use super::{Arena, ArenaFull};
use core::fmt;

/// Blocks that a node can read: its own, and those that lie in frames of its arena.
///
/// A fetched block lies in its frame in the format of the file, and is thereby part of the octree for
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
/// Nothing else keeps a frame. A task runs in one block at a time, and what the oldest one still needs is the block that its ray waits for, which 3 keeps:
/// that it protects further frames (dissertation, 4.5) is needed where a task holds several at once.
///
/// # Invariants
/// A block has at most one frame. The owned range has none.
#[derive(Debug)]
pub struct BlockCache<'a> {
    table: FrameTable<'a>,
    frames: &'a mut [u8],
    block_bytes: usize,
    owned_first: u32,
    owned: &'a [u8],
    counts: CacheCounts,
}

/// Where a block is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Place {
    /// In the node's own slice.
    Owned,
    /// In a frame.
    Cached,
    /// Requested; its frame is reserved.
    OnItsWay,
    /// With another node, or in the file.
    Remote,
}

/// A block that can be read now.
#[derive(Debug, Clone, Copy)]
pub(super) enum Found {
    Owned(u32),
    Frame(FrameId),
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
    /// Times a block was asked for and in a frame. Owned blocks count neither as hit nor as miss.
    pub hits: u64,
    /// Times a block was asked for and in no frame.
    pub misses: u64,
    /// Blocks that left for another.
    pub evictions: u64,
    /// Blocks that arrived.
    pub fetched: u64,
    /// Most frames in use at once.
    pub frames_peak: u64,
}

impl<'a> BlockCache<'a> {
    /// A cache with `frames` empty frames in `arena`, and without owned blocks.
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
            owned_first: 0,
            owned: &[],
            counts: CacheCounts::default(),
        })
    }

    /// Makes the blocks from `first` on, back to back in `bytes`, the node's own.
    #[must_use]
    pub const fn with_owned(mut self, first: u32, bytes: &'a [u8]) -> Self {
        (self.owned_first, self.owned) = (first, bytes);
        self
    }

    /// Where a block is. Changes and counts nothing.
    #[must_use]
    pub fn place(&self, block: u32) -> Place {
        if self.owned_bytes(block).is_some() {
            return Place::Owned;
        }
        match self.table.find(block) {
            Some(frame) if self.table.is_on_its_way(frame) => Place::OnItsWay,
            Some(_) => Place::Cached,
            None => Place::Remote,
        }
    }

    /// The bytes of a block that is here: a hit, and its frame becomes the newest. Otherwise a miss.
    #[inline]
    pub fn get(&mut self, block: u32) -> Option<&[u8]> {
        let found = self.find(block)?;
        self.bytes(found)
    }

    /// As [`get`](Self::get), with the bytes left to [`bytes`](Self::bytes).
    #[inline]
    pub(super) fn find(&mut self, block: u32) -> Option<Found> {
        if self.owned_bytes(block).is_some() {
            return Some(Found::Owned(block));
        }
        let found = self.first_use(block);
        let count = if found.is_some() { &mut self.counts.hits } else { &mut self.counts.misses };
        *count = count.saturating_add(1);
        found
    }

    /// As [`find`](Self::find), but neither hit nor miss: the miss that made the block come has been counted.
    pub(super) fn first_use(&mut self, block: u32) -> Option<Found> {
        self.table.used(block).map(Found::Frame)
    }

    /// What was found.
    #[inline]
    pub(super) fn bytes(&self, found: Found) -> Option<&[u8]> {
        match found {
            Found::Owned(block) => self.owned_bytes(block),
            Found::Frame(frame) => self.frame(frame),
        }
    }

    /// Sees to it that a block has a frame; one that is here or on its way keeps the one it has.
    /// `Ok(true)` says that the frame is new and the block must be requested.
    ///
    /// # Errors
    /// [`CacheFull`] if no frame can be had now, or, for a prefetch, only the last one.
    pub fn reserve(&mut self, block: u32, claim: Claim) -> Result<bool, CacheFull> {
        if self.place(block) != Place::Remote {
            return Ok(false);
        }
        if claim == Claim::Prefetch && self.table.available() < 2 {
            return Err(CacheFull);
        }
        let (_, evicted) = self.table.take(block, claim == Claim::Demand).ok_or(CacheFull)?;
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

    #[inline]
    fn frame(&self, frame: FrameId) -> Option<&[u8]> {
        let at = frame.index().checked_mul(self.block_bytes)?;
        self.frames.get(at..)?.get(..self.block_bytes)
    }

    #[inline]
    fn owned_bytes(&self, block: u32) -> Option<&'a [u8]> {
        let at = (block.checked_sub(self.owned_first)? as usize).checked_mul(self.block_bytes)?;
        self.owned.get(at..)?.get(..self.block_bytes)
    }
}

#[cfg(test)]
mod tests;
