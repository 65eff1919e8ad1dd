use core::fmt;

use super::code::INDEX;
use super::octant::ordered;
use super::trail::Trail;
use super::visit::Taken;
use crate::block::format::{DEPTH_MAX, Ref};
use crate::geometry::Hit;

/// The whole state of a traversal: where it is, what is still to be visited, and the best hit so far.
///
/// About 2 KiB, of which a traversal touches a part as deep as it goes. One is made once and used for ray after ray.
/// When its source stops a traversal, the cursor has the [`Trail`] by which it goes on, with this cursor or with any other.
#[derive(Debug, Clone)]
pub struct Cursor {
    pub(super) trail: Trail,
    pub(super) best: Option<Hit>,
    pub(super) levels: Levels,
}

/// What was visited: what a machine profile turns into time.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Visited {
    /// Nodes: eight boxes each.
    pub nodes: u64,
    /// Leaves: one to four groups of up to four primitives each.
    pub leaves: u64,
    /// Blocks entered.
    pub blocks: u64,
}

impl Visited {
    /// Both.
    pub(super) const fn and(self, other: &Self) -> Self {
        Self {
            nodes: self.nodes.wrapping_add(other.nodes),
            leaves: self.leaves.wrapping_add(other.leaves),
            blocks: self.blocks.wrapping_add(other.blocks),
        }
    }
}

/// Where a traversal goes next.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Place {
    /// The block it needs.
    pub(super) block: u32,
    /// The child it visits there, as its bits; an empty one: back to the deepest live level.
    pub(super) child: u16,
    /// The level of that child.
    pub(super) depth: u8,
    /// Nodes that it may still visit, from bit 32 on; below, leaves that it has visited: one register counts both.
    pub(super) steps: u64,
}

impl Place {
    /// The root.
    pub(super) const ROOT: Self = Self { block: 0, child: 0, depth: 0, steps: NODES_MAX << 32 };

    /// Counts a node. `true`: no sound tree has so many, or is so deep.
    #[inline(always)]
    pub(super) fn spent(&mut self) -> bool {
        let (steps, spent) = self.steps.overflowing_sub(1 << 32);
        self.steps = steps;
        spent || usize::from(self.depth) >= DEPTH_MAX
    }

    /// Counts a leaf.
    #[inline(always)]
    pub(super) fn tests(&mut self) {
        self.steps = self.steps.wrapping_add(1);
    }

    /// Goes through a reference.
    #[inline(always)]
    pub(super) fn enter(&mut self, to: Ref) {
        self.block = to.block;
        self.child = to.node & INDEX;
    }

    /// Goes to a child that was left. `true`: it lies in another block.
    #[inline(always)]
    pub(super) fn follow(&mut self, to: &Taken) -> bool {
        self.child = to.child;
        self.depth = to.depth;
        let other = self.block != to.block;
        self.block = to.block;
        other
    }

    /// Goes back to the root.
    #[inline(always)]
    pub(super) fn leave(&mut self) {
        *self = Self { steps: self.steps, ..Self::ROOT };
    }
}

/// The path from the root to the current node, with what is left to visit beside it.
#[derive(Debug, Clone)]
pub(super) struct Levels {
    /// Bit `d`: level `d` has children left.
    pub(super) live: u32,
    pub(super) level: [Level; DEPTH_MAX],
    pub(super) visited: Visited,
}

/// A node on the path.
#[derive(Debug, Clone, Copy)]
#[repr(C, align(32))]
pub(super) struct Level {
    /// Where the ray enters the children, by slot.
    pub(super) near: [f32; 8],
    /// The children, by slot.
    pub(super) child: [u16; 8],
    /// The block that the node lies in.
    pub(super) block: u32,
    /// Slot `k ^ flip` is visited `k`th.
    pub(super) flip: u8,
    /// Bit `k`: still to be visited.
    pub(super) pending: u8,
    /// The `k` that was taken last.
    pub(super) taken: u8,
    pub(super) _zero: [u8; 9],
}

const _: () = {
    assert!(DEPTH_MAX <= 32, "a level is a bit of `live`");
    assert!(size_of::<Level>() == 64);
};

/// More nodes than this no ray visits in a tree that makes sense: 2²⁴. It bounds the time on a file
/// whose blocks refer to the same nodes again and again.
pub(super) const NODES_MAX: u64 = 1 << 24;

/// Why a traversal stopped before its end.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TraceError<E> {
    /// The source did not give a block. The traversal can go on by its [`Trail`].
    Source(E),
    /// A block refers to a node that is not there, the tree is too deep or too large, or the trail is none of this tree.
    Corrupt {
        /// The block where it was found.
        block: u32,
    },
}

impl Default for Cursor {
    fn default() -> Self {
        Self::new()
    }
}

impl Cursor {
    /// Room for a traversal.
    #[must_use]
    pub const fn new() -> Self {
        Self { trail: Trail::START, best: None, levels: Levels::new() }
    }

    /// Where to go on, after the source has stopped the traversal.
    #[must_use]
    pub const fn trail(&self) -> Trail {
        self.trail
    }

    /// The closest hit so far, after the source has stopped the search for it.
    #[must_use]
    pub const fn best(&self) -> Option<Hit> {
        self.best
    }

    /// What was visited since the cursor was made, or [`Cursor::take_visited`] was called.
    #[must_use]
    pub const fn visited(&self) -> Visited {
        self.levels.visited
    }

    /// What was visited; counts from zero again.
    pub fn take_visited(&mut self) -> Visited {
        core::mem::take(&mut self.levels.visited)
    }

    /// Counts what was visited on the way to a place.
    #[inline(always)]
    pub(super) fn count(&mut self, at: &Place) {
        let visited = &mut self.levels.visited;
        visited.nodes = visited.nodes.wrapping_add(NODES_MAX.wrapping_sub(at.steps >> 32));
        visited.leaves = visited.leaves.wrapping_add(at.steps & u64::from(u32::MAX));
    }

    /// Keeps where to go on.
    #[cold]
    #[inline(never)]
    pub(super) fn stop(&mut self, at: Place, collapsed: u32, t_max: f32) {
        let taken = self.levels.level.iter().map(|level| level.taken);
        self.trail = Trail::new(&at, taken, collapsed | self.levels.reached(t_max));
    }
}

impl Level {
    /// The children of a node of this block, to be visited in this order.
    #[inline(always)]
    pub(super) fn hold(&mut self, child: &[u16; 8], block: u32, flip: u8) {
        self.child = *child;
        self.block = block;
        self.flip = flip;
    }

    /// Whether the ray may still reach a child that is left.
    fn is_reached(&self, t_max: f32) -> bool {
        let left = ordered(u32::from(self.pending), self.flip);
        self.near.iter().zip(0..).any(|(&near, slot)| left >> slot & 1 == 1 && near <= t_max)
    }
}

impl Levels {
    pub(super) const fn new() -> Self {
        const LEVEL: Level = Level {
            near: [0.0; 8],
            child: [0; 8],
            block: 0,
            flip: 0,
            pending: 0,
            taken: 0,
            _zero: [0; 9],
        };
        let visited = Visited { nodes: 0, leaves: 0, blocks: 0 };
        Self { live: 0, level: [LEVEL; DEPTH_MAX], visited }
    }

    #[inline(always)]
    #[allow(clippy::indexing_slicing, reason = "the mask keeps it in range")]
    pub(super) fn at_mut(&mut self, depth: u32) -> &mut Level {
        // Sound trees stay below DEPTH_MAX; an unsound one finds other levels in place of its own.
        const { assert!(DEPTH_MAX == 32) };
        &mut self.level[(depth & 31) as usize]
    }

    /// The live levels with children that the ray may still reach.
    fn reached(&self, t_max: f32) -> u32 {
        let levels = self.level.iter().zip(0..);
        let reached = levels.filter(|(level, _)| level.is_reached(t_max));
        reached.fold(0, |reached, (_, depth)| reached | 1 << depth) & self.live
    }
}

impl<E: fmt::Display> fmt::Display for TraceError<E> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Source(error) => error.fmt(f),
            Self::Corrupt { block } => {
                write!(
                    f,
                    "block {block} refers to a node that is not there, the tree is too deep, or the ray's trail is of another"
                )
            }
        }
    }
}

impl<E: fmt::Debug + fmt::Display> core::error::Error for TraceError<E> {}
