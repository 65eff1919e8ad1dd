use bytemuck::{Pod, Zeroable};

/// Names a frame of a cache.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Pod, Zeroable)]
#[repr(transparent)]
pub(super) struct FrameId(u32);

impl FrameId {
    /// No frame.
    pub(super) const NONE: Self = Self(u32::MAX);

    /// Its index.
    #[must_use]
    pub(super) const fn index(self) -> usize {
        self.0 as usize
    }
}

/// What the cache knows of a frame.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(super) struct FrameEntry {
    block: u32,
    /// Towards the one to leave first; in the list of free frames the next one.
    older: FrameId,
    newer: FrameId,
    state: u32,
}

/// In [`FrameEntry::state`]: the frame belongs to `block`. Without it the frame is free.
const TAKEN: u32 = 1;
/// The bytes are not all there.
const ON_ITS_WAY: u32 = 2;
/// Not to be evicted before its first use.
const UNUSED: u32 = 4;
/// Not to be evicted, against the rules.
#[cfg(test)]
const PINNED: u32 = 8;

impl FrameEntry {
    const FREE: Self = Self { block: 0, older: FrameId::NONE, newer: FrameId::NONE, state: 0 };
}

/// So many subsequent blocks begin their search near one another.
const NEAR: u32 = 8;

/// Length of the index for this many frames: a power of two, at most half full.
#[must_use]
pub(super) const fn index_len(frames: usize) -> usize {
    match frames.saturating_mul(2).checked_next_power_of_two() {
        Some(len) => len,
        None => usize::MAX,
    }
}

/// What the table of a cache takes of an arena, for this many frames.
#[must_use]
pub const fn frame_table_bytes(frames: usize) -> usize {
    super::Arena::bytes_of::<FrameEntry>(frames)
        .saturating_add(super::Arena::bytes_of::<u32>(index_len(frames)))
}

/// Which block lies in which frame, and which frame leaves next.
///
/// The index is a hash table with linear probing (Knuth, TAOCP 3, 6.4, algorithms L and R: a removal
/// moves later entries back, so there are no tombstones and a search stays short for ever). Frames
/// that may leave are linked from newest to oldest; what is unused or on its way
/// is in no list. As long as no block had to leave, the newest is the one that came last: where all blocks fit, to use one costs nothing.
#[derive(Debug)]
pub(super) struct FrameTable<'a> {
    entries: &'a mut [FrameEntry],
    /// See [`word`].
    index: &'a mut [u32],
    newest: FrameId,
    oldest: FrameId,
    free: FrameId,
    free_len: usize,
    evictable_len: usize,
    /// A block had to leave. Before the first one, no use changes the order.
    evicts: bool,
}

/// In a [`word`]: the frame's number plus one. Above it lies what is held of the block's number.
const FRAME: u32 = (1 << 24) - 1;

/// Most frames of a table.
const FRAMES_MOST: usize = FRAME as usize - 1;

/// What the index holds of a block in a frame: the frame's number plus one, and above it the lowest bits of the block's, so that hardly any other block's
/// entry is looked at in search of it. Zero is none.
const fn word(block: u32, frame: FrameId) -> u32 {
    block << FRAME.count_ones() | frame.0.wrapping_add(1) & FRAME
}

/// Whether a word may be this block's.
const fn is_alike(word: u32, block: u32) -> bool {
    (word ^ block << FRAME.count_ones()) & !FRAME == 0
}

/// The frame that a word names.
fn frame_of(word: u32) -> Option<FrameId> {
    (word & FRAME).checked_sub(1).map(FrameId)
}

impl<'a> FrameTable<'a> {
    /// A table of free frames, as many as there are `entries`; `index` is of length [`index_len`].
    pub(super) fn new(entries: &'a mut [FrameEntry], index: &'a mut [u32]) -> Self {
        entries.fill(FrameEntry::FREE);
        index.fill(0);
        let mut table = Self {
            entries,
            index,
            newest: FrameId::NONE,
            oldest: FrameId::NONE,
            free: FrameId::NONE,
            free_len: 0,
            evictable_len: 0,
            evicts: false,
        };
        for frame in (0..table.entries.len().min(FRAMES_MOST) as u32).rev() {
            table.put_free(FrameId(frame));
        }
        table
    }

    /// Number of frames.
    pub(super) const fn len(&self) -> usize {
        self.entries.len()
    }

    /// Frames without a block.
    pub(super) const fn free_len(&self) -> usize {
        self.free_len
    }

    /// Frames that a new block can have: the free and the evictable ones.
    pub(super) const fn available(&self) -> usize {
        self.free_len.saturating_add(self.evictable_len)
    }

    /// The frame of a block. O(1) expected.
    #[cfg_attr(feature = "bundles", inline)]
    #[cfg_attr(not(feature = "bundles"), inline(never))]
    pub(super) fn find(&self, block: u32) -> Option<FrameId> {
        let mut at = self.home(block);
        for _ in 0..self.index.len() {
            let word = *self.index.get(at)?;
            let frame = frame_of(word)?;
            if is_alike(word, block) && self.entries.get(frame.index())?.block == block {
                return Some(frame);
            }
            at = self.after(at);
        }
        None
    }

    /// Whether the bytes of a frame are not all there yet.
    pub(super) fn is_on_its_way(&self, frame: FrameId) -> bool {
        self.entries.get(frame.index()).is_some_and(|e| e.state & ON_ITS_WAY != 0)
    }

    /// Takes a frame for a block that has none: a free one, or else the oldest evictable one, whose block leaves (then it says `true`).
    /// The block is on its way, and kept for its first use if `unused`.
    pub(super) fn take(&mut self, block: u32, unused: bool) -> Option<bool> {
        let evicts = self.free == FrameId::NONE;
        let frame = if evicts { self.oldest } else { self.free };
        let older = self.entries.get(frame.index())?.older;
        if evicts {
            self.evicts = true;
            self.unlink(frame);
            self.forget(frame);
        } else {
            self.free = older;
            self.free_len = self.free_len.saturating_sub(1);
        }
        let state = TAKEN | ON_ITS_WAY | if unused { UNUSED } else { 0 };
        let entry = self.entries.get_mut(frame.index())?;
        *entry = FrameEntry { block, state, ..FrameEntry::FREE };
        let mut at = self.home(block);
        // Every loop over the index is bounded by its length: a fault may lose a block, not hang.
        for _ in 0..self.index.len() {
            if self.index.get(at).is_some_and(|&frame| frame == 0) {
                break;
            }
            at = self.after(at);
        }
        *self.index.get_mut(at)? = word(block, frame);
        Some(evicts)
    }

    /// Frees a frame, whatever its state.
    pub(super) fn release(&mut self, frame: FrameId) {
        let Some(state) = self.entries.get(frame.index()).map(|e| e.state) else { return };
        if state == TAKEN {
            self.unlink(frame);
        }
        if state & TAKEN != 0 {
            self.forget(frame);
            self.put_free(frame);
        }
    }

    /// All bytes of a frame on its way are there.
    pub(super) fn arrived(&mut self, frame: FrameId) {
        self.set(frame, 0, ON_ITS_WAY);
    }

    /// The frame of a block all of whose bytes are there: it is used, and becomes the newest.
    #[inline]
    pub(super) fn used(&mut self, block: u32) -> Option<FrameId> {
        let frame = self.find(block)?;
        let state = self.entries.get(frame.index())?.state;
        if state == TAKEN {
            if self.evicts && frame != self.newest {
                self.unlink(frame);
                self.link_newest(frame);
            }
        } else if state & ON_ITS_WAY != 0 {
            return None;
        } else {
            self.set(frame, 0, UNUSED);
        }
        Some(frame)
    }

    /// Sets and clears bits of a state, and enters or leaves the list as the result says.
    fn set(&mut self, frame: FrameId, bits: u32, clear: u32) {
        let Some(entry) = self.entries.get_mut(frame.index()) else { return };
        let before = entry.state;
        if before & TAKEN == 0 {
            return;
        }
        entry.state = before & !clear | bits;
        let after = entry.state;
        if before == TAKEN && after != TAKEN {
            self.unlink(frame);
        } else if before != TAKEN && after == TAKEN {
            self.link_newest(frame);
        }
    }

    /// Keeps a frame from eviction: a rule that tests break.
    #[cfg(test)]
    pub(super) fn pin(&mut self, frame: FrameId) {
        self.set(frame, PINNED, 0);
    }

    /// Keeps none any more.
    #[cfg(test)]
    pub(super) fn unpin(&mut self) {
        (0..self.entries.len() as u32).for_each(|frame| self.set(FrameId(frame), 0, PINNED));
    }

    /// All of it.
    #[cfg(test)]
    pub(super) fn snapshot(&mut self, snapshot: &mut crate::tests::snapshot::Snapshot) {
        snapshot.all(self.entries);
        snapshot.all(self.index);
        for frame in [&mut self.newest, &mut self.oldest, &mut self.free] {
            snapshot.pod(frame);
        }
        snapshot.len(&mut self.free_len);
        snapshot.len(&mut self.evictable_len);
        snapshot.bool(&mut self.evicts);
    }

    fn put_free(&mut self, frame: FrameId) {
        let free = self.free;
        if let Some(entry) = self.entries.get_mut(frame.index()) {
            *entry = FrameEntry { older: free, ..FrameEntry::FREE };
            self.free = frame;
            self.free_len = self.free_len.saturating_add(1);
        }
    }

    fn link_newest(&mut self, frame: FrameId) {
        let newest = self.newest;
        if let Some(entry) = self.entries.get_mut(frame.index()) {
            (entry.older, entry.newer) = (newest, FrameId::NONE);
        }
        match self.entries.get_mut(newest.index()) {
            Some(entry) => entry.newer = frame,
            None => self.oldest = frame,
        }
        self.newest = frame;
        self.evictable_len = self.evictable_len.saturating_add(1);
    }

    fn unlink(&mut self, frame: FrameId) {
        let Some(&FrameEntry { older, newer, .. }) = self.entries.get(frame.index()) else {
            return;
        };
        match self.entries.get_mut(older.index()) {
            Some(entry) => entry.newer = newer,
            None => self.oldest = newer,
        }
        match self.entries.get_mut(newer.index()) {
            Some(entry) => entry.older = older,
            None => self.newest = older,
        }
        self.evictable_len = self.evictable_len.saturating_sub(1);
    }

    /// Takes a frame's block out of the index.
    fn forget(&mut self, frame: FrameId) {
        let Some(block) = self.entries.get(frame.index()).map(|e| e.block) else { return };
        let named = word(block, frame);
        let mut gap = self.home(block);
        for _ in 0..self.index.len() {
            if self.index.get(gap).is_none_or(|&f| f == 0 || f == named) {
                break;
            }
            gap = self.after(gap);
        }
        let mut at = self.after(gap);
        for _ in 0..self.index.len() {
            let Some(&next) = self.index.get(at).filter(|&&next| next != 0) else { break };
            let frame = frame_of(next).unwrap_or(FrameId::NONE);
            let block = self.entries.get(frame.index()).map_or(0, |e| e.block);
            // It may fill the gap if its home does not lie behind the gap (cyclically).
            let mask = self.index.len().wrapping_sub(1);
            let from_home = at.wrapping_sub(self.home(block)) & mask;
            let from_gap = at.wrapping_sub(gap) & mask;
            if from_home >= from_gap {
                if let Some(place) = self.index.get_mut(gap) {
                    *place = next;
                }
                gap = at;
            }
            at = self.after(at);
        }
        if let Some(place) = self.index.get_mut(gap) {
            *place = 0;
        }
    }

    /// Where the search for a block begins: those of subsequent numbers, which lie near one another in the tree, begin in one line of a cache, which
    /// is anywhere (Fibonacci hashing; Knuth, TAOCP 3, 6.4).
    #[inline]
    fn home(&self, block: u32) -> usize {
        let line = u64::from((block / NEAR).wrapping_mul(0x9e37_79b9));
        let lines = (self.index.len() / NEAR as usize).max(1) as u64;
        let at = ((line * lines) >> 32) as usize * NEAR as usize + (block % NEAR) as usize;
        at & self.index.len().wrapping_sub(1)
    }

    #[inline]
    const fn after(&self, at: usize) -> usize {
        at.wrapping_add(1) & self.index.len().wrapping_sub(1)
    }
}

/// What so many frames of `block_bytes` take of an arena, with their table.
pub(crate) const fn frame_bytes(frames: usize, block_bytes: usize) -> usize {
    let blocks = super::Arena::bytes_of::<u8>(block_bytes.saturating_mul(frames));
    frame_table_bytes(frames).saturating_add(blocks)
}

/// The most frames of `block_bytes` that fit `bytes` of an arena together with their table.
#[must_use]
pub const fn frames_that_fit(bytes: usize, block_bytes: usize) -> usize {
    let frames = bytes / if block_bytes == 0 { 1 } else { block_bytes };
    // Bisection: what frames take grows with their number.
    let most = if frames < FRAMES_MOST { frames } else { FRAMES_MOST };
    let (mut fit, mut over) = (0, most.saturating_add(1));
    while over - fit > 1 {
        let middle = fit + (over - fit) / 2;
        if frame_bytes(middle, block_bytes) > bytes {
            over = middle;
        } else {
            fit = middle;
        }
    }
    fit
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn as_many_frames_fit_as_can_be() {
        for block in [1 << 10, 4 << 10, 64 << 10] {
            for size in (0..400_000).step_by(97) {
                let frames = frames_that_fit(size, block);
                assert!(frames == 0 || frame_bytes(frames, block) <= size);
                assert!(frame_bytes(frames + 1, block) > size, "{size} {block}");
            }
        }
    }

    #[test]
    fn no_memory_is_too_vast_to_be_divided() {
        for (size, block) in [(usize::MAX, 4 << 10), (usize::MAX / 10, 1 << 10), (usize::MAX, 0)] {
            let frames = frames_that_fit(size, block);
            assert!(frame_bytes(frames, block) <= size);
        }
    }
}
