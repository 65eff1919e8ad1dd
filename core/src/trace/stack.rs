//! What is still to be visited.

use super::cursor::Place;
use crate::block::format::DEPTH_MAX;

/// Places of a stack: of each level of a sound tree seven children may wait, of the last eight are put down at a time.
const PLACES: usize = 7 * DEPTH_MAX + 8;
/// Blocks that lie within each other, and the top.
const OUTER: usize = DEPTH_MAX + 1;

/// Children that wait, the next one first: the last place is filled first.
#[derive(Debug, Clone)]
pub(super) struct Stack {
    /// Where the ray enters them.
    near: [f32; PLACES],
    /// See [`Entry`].
    entry: [u32; PLACES],
    /// The blocks that were left for one within them, each with what waits there.
    outer: [Outer; OUTER],
    /// Of each level on the path the place of the child that was taken.
    taken: [u8; DEPTH_MAX],
}

#[derive(Debug, Clone, Copy)]
struct Outer {
    block: u32,
    base: u32,
}

/// A child as a stack holds it.
///
/// | bits | |
/// | --- | --- |
/// | 0–15 | its bits |
/// | 16–18 | its place in the order of its node |
/// | 24–29 | its level |
///
/// A child of the [top](crate::block::ExpandedTop) has all bits for itself.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Entry(pub(super) u32);

impl Entry {
    /// The root.
    pub(super) const ROOT: Self = Self(0);

    /// A child with these bits, of a level.
    #[inline(always)]
    pub(super) const fn new(child: u16, level: u8) -> Self {
        Self(child as u32 | (level as u32) << 24)
    }

    /// Its bits.
    #[inline(always)]
    pub(super) const fn child(self) -> u16 {
        self.0 as u16
    }

    /// Another child instead, on the same level.
    #[inline(always)]
    pub(super) const fn with_child(self, child: u16) -> Self {
        Self(self.0 & !0xffff | child as u32)
    }

    /// Its level.
    #[inline(always)]
    pub(super) const fn level(self) -> u8 {
        (self.0 >> 24) as u8
    }

    /// Its place in the order of its node.
    #[inline(always)]
    pub(super) const fn place(self) -> u8 {
        (self.0 >> 16 & 7) as u8
    }

    /// What its own children have beside their bits and places.
    #[inline(always)]
    pub(super) const fn tag(self) -> u32 {
        (self.level().wrapping_add(1) as u32) << 24
    }
}

/// Eight places of a stack, for the children of a node that a ray meets: they stand at the end, the one that is visited first first.
#[derive(Debug)]
pub struct Places<'s> {
    /// Where the ray enters them, if that is asked.
    pub near: Option<&'s mut [f32; 8]>,
    /// What they are.
    pub entry: &'s mut [u32; 8],
}

/// The children of a node that a ray meets.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Met {
    /// How many: so many places at the end are theirs.
    pub count: u32,
    /// The one that is visited first. Means nothing if there is none.
    pub first: u32,
    /// Of an expanded node, if that is a leaf, its [lines](crate::block::ExpandedNode::lines), or 0.
    pub lines: u8,
}

/// Where on a stack a traversal is.
#[derive(Debug, Clone, Copy)]
pub(super) struct Height {
    /// The next child is eight places behind this one: between them children are put down.
    free: usize,
    /// The same at the end of what waits in this block.
    base: usize,
    /// Blocks that were left.
    outer: usize,
}

/// How many children are put down at a time.
const GROUP: usize = 8;

impl Height {
    /// Nothing waits.
    pub(super) const NONE: Self = Self { free: PLACES - GROUP, base: PLACES - GROUP, outer: 0 };

    /// The place of the next child.
    #[inline(always)]
    const fn at(&self) -> usize {
        self.free.wrapping_add(GROUP)
    }
}

/// Where a traversal goes on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Next {
    /// In this block.
    Here,
    /// In another block.
    Elsewhere,
    /// Nothing is left.
    Nowhere,
}

impl Stack {
    pub(super) const fn new() -> Self {
        Self {
            near: [0.0; PLACES],
            entry: [0; PLACES],
            outer: [Outer { block: 0, base: 0 }; OUTER],
            taken: [0; DEPTH_MAX],
        }
    }

    /// The eight places before the next child. `None`: no sound tree takes so many.
    #[inline(always)]
    pub(super) fn places(&mut self, height: &Height) -> Option<Places<'_>> {
        let (from, to) = (height.free, height.at());
        let near = self.near.get_mut(from..to)?.first_chunk_mut()?;
        let entry = self.entry.get_mut(from..to)?.first_chunk_mut()?;
        Some(Places { near: Some(near), entry })
    }

    /// Goes to the first of the children that were just put down; the others wait. There is one.
    #[inline(always)]
    pub(super) fn descend(&mut self, height: &mut Height, at: &mut Place, met: Met) {
        height.free = height.free.wrapping_sub(met.count as usize).wrapping_add(1);
        at.entry = Entry(met.first);
    }

    /// The child that comes next, if one waits; or else what was there before.
    #[inline(always)]
    pub(super) fn waiting(&self, height: &Height) -> Option<Entry> {
        self.entry.get(height.at()).copied().map(Entry)
    }

    /// Notes which child was taken, for the trail.
    #[inline(always)]
    pub(super) fn note(&mut self, entry: Entry) {
        if let Some(taken) = self.taken.get_mut(usize::from(entry.level()).wrapping_sub(1)) {
            *taken = entry.place();
        }
    }

    /// Leaves a block for another within it. `false`: no sound blocks lie so deep within each other.
    #[inline(always)]
    #[must_use]
    pub(super) fn leave(&mut self, height: &mut Height, block: u32) -> bool {
        if height.free == height.base {
            // Nothing waits in it: it is not come back to.
            return true;
        }
        let Some(outer) = self.outer.get_mut(height.outer) else { return false };
        *outer = Outer { block, base: height.base as u32 };
        height.outer += 1;
        height.base = height.free;
        true
    }

    /// Takes the next child that the ray may still reach: without its end it reaches all.
    #[inline(always)]
    pub(super) fn next(&mut self, height: &mut Height, at: &mut Place, t_max: Option<f32>) -> Next {
        let mut next = Next::Here;
        loop {
            if height.free == height.base {
                let above = height.outer.wrapping_sub(1);
                let Some(&Outer { block, base }) = self.outer.get(above) else {
                    return Next::Nowhere;
                };
                (height.outer, height.base, at.block) = (above, base as usize, block);
                next = Next::Elsewhere;
                continue;
            }
            let (Some(&near), Some(&entry)) =
                (self.near.get(height.at()), self.entry.get(height.at()))
            else {
                return Next::Nowhere;
            };
            height.free = height.free.wrapping_add(1);
            // Not at equality: the order of hits decides among equals.
            if t_max.is_some_and(|t_max| near > t_max) {
                continue;
            }
            at.entry = Entry(entry);
            return next;
        }
    }

    /// Keeps of the children that were just put down those behind a place of the order. Whether the one in this place was among them.
    #[inline(always)]
    pub(super) fn keep_behind(&self, height: &mut Height, met: Met, place: u8) -> bool {
        let from = height.at().wrapping_sub(met.count as usize);
        let put_down = self.entry.get(from..height.at()).unwrap_or_default().iter();
        let mut places = put_down.map(|&entry| Entry(entry).place());
        let behind = places.clone().take_while(|&other| other <= place).count();
        height.free = from.wrapping_add(behind).wrapping_sub(GROUP);
        places.any(|other| other == place)
    }

    /// The levels with children that the ray may still reach.
    pub(super) fn reached(&self, height: &Height, t_max: f32) -> u32 {
        let waiting = self.near.iter().zip(&self.entry).skip(height.at());
        let reached = waiting.filter(|(near, _)| **near <= t_max);
        reached.fold(0, |levels, (_, &entry)| {
            levels | 1_u32.unbounded_shl(u32::from(Entry(entry).level()).wrapping_sub(1))
        })
    }

    /// Which child was taken, by level.
    pub(super) const fn taken(&self) -> &[u8; DEPTH_MAX] {
        &self.taken
    }

    /// The same, to be laid down.
    pub(super) fn taken_mut(&mut self) -> &mut [u8; DEPTH_MAX] {
        &mut self.taken
    }
}
