//! The restart trail.

use bytemuck::{Pod, Zeroable};

use super::cursor::Place;
use super::stack::{Entry, Stack};
use crate::block::format::DEPTH_MAX;

/// Where a traversal is, in the fewest bytes: what a ray that waits or migrates carries beside itself and its best hit.
///
/// It is the child that comes next, and on each level above it which child was taken, by its place in the order of the
/// ray's signs: a path from the root (Laine, Restart Trail for Stackless BVH Traversal, 2010). All children before the path
/// are done; those behind it are found again, when all below the child is done, by a second visit of the nodes on the path. That
/// order is a function of ray and node alone, so a ray may go on with any lanes on any machine that has the blocks, and needs one of them at a time, however many it passes through (rule 12 of the mesh). Laine's trail
/// has one bit a level, as its nodes have two children, and starts from the root each time; this one begins at
/// the child, so that a ray that will find nothing behind its path never comes back to it.
///
/// # Bounds
/// Any bytes are a trail. One that does not fit the blocks may skip hits, or end in an error.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct Trail {
    /// Bit `d` of word `b` is bit `b` of the place that was taken on level `d`.
    path: [u32; 3],
    /// The block that the child lies in.
    block: u32,
    /// The child, as its bits.
    child: u16,
    /// [`Span`] as one number.
    span: u16,
}

/// Which levels a trail speaks of, each at most [`DEPTH_MAX`].
#[derive(Clone, Copy)]
struct Span {
    /// The level of the child.
    depth: u32,
    /// Levels before this one may have children left, above the child.
    above: u32,
    /// The path leads on to this level, below the child; 0: the child itself is to be visited.
    below: u32,
}

/// Numbers of a [`Span`] from 0.
const RADIX: u32 = DEPTH_MAX as u32 + 1;

impl Span {
    const fn encode(self) -> u16 {
        const { assert!(RADIX * RADIX * RADIX <= 1 << 16) };
        ((self.below * RADIX + self.above) * RADIX + self.depth) as u16
    }

    /// `None`: not the number of a span.
    const fn decode(span: u16) -> Option<Self> {
        let span = span as u32;
        let depth = span % RADIX;
        let above = span / RADIX % RADIX;
        let below = span / (RADIX * RADIX);
        if above <= depth && below < RADIX && (below == 0 || below > depth) {
            Some(Self { depth, above, below })
        } else {
            None
        }
    }
}

impl Trail {
    /// Before the root.
    pub const START: Self = Self { path: [0; 3], block: 0, child: 0, span: 0 };

    /// The block that the traversal needs next.
    #[must_use]
    pub const fn block(&self) -> u32 {
        self.block
    }

    /// The trail of a traversal that goes on at this place, with children left on these levels; of each level which child was taken.
    pub(super) fn new(at: &Place, taken: impl Iterator<Item = u8>, left: u32) -> Self {
        let depth = u32::from(at.entry.level()).min(RADIX - 1);
        let span =
            Span { depth, above: end(left & before(depth)), below: end(left & !before(depth)) };
        let mut path = [0; 3];
        for (taken, bit) in taken.zip(0..depth.max(span.below)) {
            for (word, b) in path.iter_mut().zip(0..3) {
                *word |= (u32::from(taken) >> b & 1) << bit;
            }
        }
        Self { path, block: at.block, child: at.child(), span: span.encode() }
    }

    /// Lays the path down. Returns the place to go on at, and the levels which may have children left.
    #[inline]
    pub(super) fn lay(&self, stack: &mut Stack) -> Option<(Place, u32)> {
        let at = |level| Place {
            block: self.block,
            entry: Entry::new(self.child, level),
            ..Place::ROOT
        };
        if self.span == 0 {
            return Some((at(0), 0));
        }
        let span = Span::decode(self.span)?;
        self.lay_path(stack.taken_mut(), span);
        Some((at(span.depth as u8), before(span.above) | before(span.below) & !before(span.depth)))
    }

    #[inline(never)]
    fn lay_path(&self, path: &mut [u8; DEPTH_MAX], span: Span) {
        let [b0, b1, b2] = self.path;
        for (taken, bit) in path.iter_mut().zip(0..span.depth.max(span.below)) {
            *taken = (b0 >> bit & 1 | (b1 >> bit & 1) << 1 | (b2 >> bit & 1) << 2) as u8;
        }
    }
}

/// The levels before one.
const fn before(depth: u32) -> u32 {
    ((1_u64 << depth) - 1) as u32
}

/// The level behind the last of some.
const fn end(levels: u32) -> u32 {
    u32::BITS - levels.leading_zeros()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_is_a_span_or_none() {
        let mut spans = 0;
        for number in 0..=u16::MAX {
            if let Some(span) = Span::decode(number) {
                assert_eq!(span.encode(), number);
                assert!(span.above <= span.depth && span.depth <= 32 && span.below <= 32);
                assert!(span.below == 0 || span.below > span.depth);
                spans += 1;
            }
        }
        // Of each depth `d`, `d + 1` levels above, and 32 - d below, or none.
        assert_eq!(spans, (0..=32).map(|d| (d + 1) * (32 - d + 1)).sum::<u32>());
        assert_eq!(size_of::<Trail>(), 20);
    }
}
