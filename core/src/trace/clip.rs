//! Which blocks a bundle of rays may touch, found before it is traced.

use super::cursor::TraceError;
use super::turn::Turn;
use crate::block::format::{Child, DEPTH_MAX, Node, RECORD_SPHERES, Record};
use crate::block::{BlockSource, BlockView};
use crate::geometry::{Planes, Primitive, Pyramid};
use core::convert::Infallible;
use glam::Vec3;

/// The list of subtrees that a bundle may touch, front to back, in rounds as blocks arrive
/// (pyramid clipping: Reinhard 1999, chapter 5).
///
/// An entry is a node of a block, with what lies below it *in that block*; what lies in other blocks has entries of its own. So
/// a bundle is traced by taking entries from the front, each with one block in memory. Every hit of a ray of the bundle lies in
/// a subtree that the list names sooner or later, by the conservative tests of [`Pyramid`].
///
/// The list is a window in memory that the caller lends. An entry whose block is not here waits. An entry whose block is here is replaced by
/// what the bundle may touch of it: the entry itself, ready, if it touches primitives of the block, and one entry for each reference to another
/// block. If these do not fit, the rest stays behind them as one entry, and is looked into again when
/// there is room. So any window of [`window_min`](Self::window_min) entries is enough for any bundle.
///
/// When the list is empty and complete, nothing can be hit: the shadow rays of the bundle need not be traced.
#[derive(Debug)]
pub struct Clip<'w> {
    pyramid: Pyramid,
    window: &'w mut [ClipEntry],
    len: usize,
    /// Places that looking into any other entry than the first leaves free.
    reserve: usize,
    counts: ClipCounts,
}

/// A subtree of one block.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ClipEntry {
    /// The block.
    pub block: u32,
    /// The node of it that the subtree begins with.
    pub node: u16,
    state: State,
    /// Planes of the pyramid that cut the subtree.
    planes: Planes,
    /// How many of its references have entries already.
    skip: u16,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum State {
    /// Its block has not been looked into.
    Waiting,
    /// Its block has been looked into, but not all of its references have entries.
    Rest,
    /// The bundle may touch primitives of the block below the node.
    Ready,
}

impl ClipEntry {
    /// To fill a window with.
    pub const EMPTY: Self =
        Self { block: 0, node: 0, state: State::Waiting, planes: Planes::ALL, skip: 0 };

    /// Whether its block has been looked into: the bundle can be traced in it.
    #[must_use]
    pub fn is_ready(&self) -> bool {
        self.state == State::Ready
    }
}

/// What a clip has come across.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct ClipCounts {
    /// Blocks looked into; one counts again for each of its subtrees and each time that its references did not fit.
    pub blocks: u32,
    /// Boxes of nodes tested.
    pub boxes: u32,
    /// Primitives that may be touched.
    pub primitives: u32,
}

/// More boxes than this are not tested: it bounds the time on a file whose blocks refer to the same nodes again and again.
const BOXES_MAX: u32 = 1 << 26;

impl<'w> Clip<'w> {
    /// Begins at the root. `nesting` is that of block 0 (`BlockHeader::nesting`): how many blocks lie within each other.
    ///
    /// `None` if the window has fewer than [`window_min`](Self::window_min) entries.
    #[must_use]
    pub fn new(pyramid: Pyramid, nesting: u16, window: &'w mut [ClipEntry]) -> Option<Self> {
        if window.len() < Self::window_min(nesting) {
            return None;
        }
        *window.first_mut()? = ClipEntry::EMPTY;
        let reserve = usize::from(nesting);
        Some(Self { pyramid, window, len: 1, reserve, counts: ClipCounts::default() })
    }

    /// The least number of entries of a window: one for each block within another, and one.
    #[must_use]
    pub const fn window_min(nesting: u16) -> usize {
        nesting as usize + 1
    }

    /// Looks into every waiting entry whose block the source has, front to back, as far as there is
    /// room; an error of the source means that the block is not here.
    ///
    /// # Why it does not get stuck
    ///
    /// An entry whose block has nesting `n` needs `n - 1` free places when it is the first: one for the rest of the block, and
    /// what its first reference needs, of nesting `n - 1` at most. It has them: looking into
    /// it leaves `n - 2` free for its references; looking into others before it leaves as many free as they add before it, so that
    /// they are free again when it has become the first; and looking into others behind it leaves `nesting - 1`.
    ///
    /// # Errors
    /// [`TraceError::Corrupt`] if a block refers to a node that is not there, if blocks lie deeper within each other than
    /// they say, or if the tree has no end.
    pub fn round<S: BlockSource>(&mut self, source: &mut S) -> Result<(), TraceError<Infallible>> {
        let (mut at, mut first) = (0, true);
        while let Some(&entry) = self.entries().get(at) {
            if entry.is_ready() {
                at += 1;
                continue;
            }
            let Ok(view) = source.block(entry.block) else {
                (at, first) = (at + 1, false);
                continue;
            };
            let nesting = usize::from(view.header().nesting);
            let keep = if first { nesting.saturating_sub(2) } else { self.reserve };
            let places = (self.window.len() + 1).saturating_sub(self.len + keep);
            let corrupt = TraceError::Corrupt { block: entry.block };
            if places > 1 || places == 1 && view.refs().is_empty() {
                at = self.look_into(&view, at, entry, places).ok_or(corrupt)?;
            } else if at == 0 {
                return Err(corrupt);
            } else {
                (at, first) = (at + 1, false);
            }
        }
        Ok(())
    }

    /// The list, front to back.
    #[must_use]
    pub fn entries(&self) -> &[ClipEntry] {
        self.window.get(..self.len).unwrap_or_default()
    }

    /// The entries that wait for their block, front to back: what to fetch.
    pub fn waiting(&self) -> impl Iterator<Item = &ClipEntry> {
        self.entries().iter().filter(|entry| !entry.is_ready())
    }

    /// Whether all blocks have been looked into: the list will not grow any more.
    #[must_use]
    pub fn is_complete(&self) -> bool {
        self.waiting().next().is_none()
    }

    /// Whether the list is empty, and no more is to come. At the start: no ray can hit anything.
    #[must_use]
    pub fn is_done(&self) -> bool {
        self.len == 0
    }

    /// Takes the first entry, if it is ready.
    pub fn pop(&mut self) -> Option<ClipEntry> {
        let entry = self.entries().first().copied().filter(ClipEntry::is_ready)?;
        self.remove(0);
        Some(entry)
    }

    /// What was looked at so far.
    #[must_use]
    pub fn counts(&self) -> ClipCounts {
        self.counts
    }

    /// Replaces the entry at `at` by what the bundle may touch of it, with at most `places` entries.
    /// Returns the place of the first of them that waits, or the place behind; `None` if the block is corrupt.
    fn look_into(
        &mut self,
        view: &BlockView<'_>,
        at: usize,
        entry: ClipEntry,
        places: usize,
    ) -> Option<usize> {
        self.counts.blocks = self.counts.blocks.saturating_add(1);
        let known = entry.state == State::Rest;
        // One place is kept for the entry itself.
        let places = if known { places } else { places.saturating_sub(1) };
        let mut found =
            Found { at, places, left: entry.skip, refs: 0, full: false, touched: known };
        self.remove(at);
        self.walk(view, &entry, &mut found)?;
        if found.full {
            // The last reference makes place for the rest, of which it is the first.
            let last = found.at.checked_sub(1).filter(|_| found.refs > 0)?;
            self.remove(last);
            let skip = entry.skip.saturating_add(found.refs.saturating_sub(1));
            self.insert(last, ClipEntry { skip, state: State::Rest, ..entry });
        }
        if found.touched && !known {
            self.insert(at, ClipEntry { state: State::Ready, ..entry });
            return Some(at + 1);
        }
        Some(at)
    }

    /// Visits what the bundle may touch below an entry, depth first, front to back.
    fn walk(&mut self, view: &BlockView<'_>, entry: &ClipEntry, found: &mut Found) -> Option<()> {
        let frame = Frame::new(view, &self.pyramid);
        let turn = Turn::along(self.pyramid.direction());
        let mut levels = [Level { node: entry.node, next: 0, planes: entry.planes }; DEPTH_MAX];
        let mut depth = 0_usize;
        loop {
            let level = levels.get_mut(depth)?;
            let node = view.node(level.node)?;
            if level.next == 8 {
                match depth.checked_sub(1) {
                    Some(up) => depth = up,
                    None => return Some(()),
                }
                continue;
            }
            let slot = turn.slot(turn.of_node(&node.order), u32::from(level.next)) as u8;
            level.next += 1;
            let child = Child::decode(*node.child.get(usize::from(slot))?);
            if child == Child::Empty {
                continue;
            }
            self.counts.boxes = self.counts.boxes.checked_add(1).filter(|&n| n < BOXES_MAX)?;
            let (lo, hi) = frame.slot(node, slot)?;
            let Some(planes) = self.pyramid.clip_relative(lo, hi, frame.reach, level.planes) else {
                continue;
            };
            match child {
                Child::Empty => {}
                Child::Node(node) => {
                    depth += 1;
                    *levels.get_mut(depth)? = Level { node, next: 0, planes };
                }
                Child::Leaf { at, count } => {
                    // The rest of a block has had its leaves looked at.
                    if entry.state == State::Waiting {
                        found.touched |= self.leaf(view, view.leaf(at, count), planes);
                    }
                }
                Child::Ref(index) => {
                    let r = view.reference(index)?;
                    self.reference(
                        ClipEntry { block: r.block, node: r.node, planes, ..ClipEntry::EMPTY },
                        found,
                    );
                }
            }
        }
    }

    fn reference(&mut self, entry: ClipEntry, found: &mut Found) {
        if found.left > 0 {
            found.left -= 1;
        } else if found.places > 0 {
            self.insert(found.at, entry);
            found.at += 1;
            found.refs += 1;
            found.places -= 1;
        } else {
            found.full = true;
        }
    }

    /// Whether the bundle may touch primitives of a leaf.
    fn leaf(&mut self, view: &BlockView<'_>, records: &[Record], planes: Planes) -> bool {
        let mut touched = 0;
        for record in records {
            for primitive in primitives(view, record) {
                touched += u32::from(self.pyramid.touches(&primitive, planes));
            }
        }
        self.counts.primitives = self.counts.primitives.saturating_add(touched);
        touched > 0
    }

    fn remove(&mut self, at: usize) {
        if at < self.len {
            for i in at + 1..self.len {
                if let (Some(&entry), Some(i)) = (self.window.get(i), i.checked_sub(1)) {
                    self.put(i, entry);
                }
            }
            self.len -= 1;
        }
    }

    fn insert(&mut self, at: usize, entry: ClipEntry) {
        if self.len < self.window.len() && at <= self.len {
            for i in (at..self.len).rev() {
                if let Some(&entry) = self.window.get(i) {
                    self.put(i + 1, entry);
                }
            }
            self.put(at, entry);
            self.len += 1;
        }
    }

    fn put(&mut self, at: usize, entry: ClipEntry) {
        if let Some(place) = self.window.get_mut(at) {
            *place = entry;
        }
    }
}

/// What has been found below an entry.
struct Found {
    /// Where the next entry goes.
    at: usize,
    /// How many entries more there is place for.
    places: usize,
    /// References still to be left out.
    left: u16,
    /// References that got an entry.
    refs: u16,
    /// A reference found no place.
    full: bool,
    /// The bundle may touch primitives.
    touched: bool,
}

/// A node on the way down.
#[derive(Clone, Copy)]
struct Level {
    node: u16,
    /// How many slots have been visited.
    next: u8,
    planes: Planes,
}

/// The frame of a block, relative to a pyramid's origin.
pub(crate) struct Frame {
    origin: Vec3,
    scale: Vec3,
    /// At least the distance along any axis from the pyramid's origin to any box in the frame.
    pub(crate) reach: f32,
}

impl Frame {
    pub(crate) fn new(view: &BlockView<'_>, pyramid: &Pyramid) -> Self {
        let header = view.header();
        let origin = Vec3::from_array(header.origin) - pyramid.origin();
        let scale = Vec3::from_array(header.scale);
        Self { origin, scale, reach: (origin.abs() + scale * 65536.0).max_element() }
    }

    /// The box of a slot. `scale * q` is exact; the sum is rounded once, as the origin was.
    pub(crate) fn slot(&self, node: &Node, slot: u8) -> Option<(Vec3, Vec3)> {
        let corner = |q: &[[u16; 8]; 3]| {
            let [x, y, z] = q;
            let at = |q: &[u16; 8]| q.get(usize::from(slot)).map(|&q| f32::from(q));
            Some(self.origin + self.scale * Vec3::new(at(x)?, at(y)?, at(z)?))
        };
        Some((corner(&node.lo)?, corner(&node.hi)?))
    }
}

/// The primitives of a record.
pub(crate) fn primitives<'a>(
    view: &'a BlockView<'_>,
    record: &'a Record,
) -> impl Iterator<Item = Primitive> + 'a {
    let base = usize::from(record.base & !RECORD_SPHERES);
    let used = record.index.iter().take_while(|[a, b, c]| a != b || b != c);
    used.filter_map(move |index| {
        let [a, b, c] = index.map(|i| view.vertex(base + usize::from(i)));
        Some(if record.base & RECORD_SPHERES == 0 {
            Primitive::Triangle { vertices: [a?, b?, c?], normals: None }
        } else {
            let shape = b?;
            Primitive::Sphere { center: a?, radius: shape.x, inward: shape.y != 0.0 }
        })
    })
}

#[cfg(test)]
mod tests;
