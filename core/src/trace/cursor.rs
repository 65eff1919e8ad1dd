use core::fmt;

use super::code::INDEX;
use crate::block::format::{DEPTH_MAX, Ref};
use crate::geometry::{Hit, PreparedRay, Ray};

/// The whole state of a traversal: where it is, what is still to be visited, and the best hit so far.
///
/// About 2 KiB, of which a traversal touches a part as deep as it goes. One is made once and used for ray after ray.
/// A traversal that was stopped by its source goes on from its cursor.
#[derive(Debug, Clone)]
pub struct Cursor {
    /// As it was when the source stopped it.
    pub(super) run: Run,
    /// As it was when the source stopped it.
    pub(super) best: Option<Hit>,
    pub(super) levels: Levels,
}

/// What a traversal keeps in registers as far as it can.
#[derive(Debug, Clone, Copy)]
pub(super) struct Run {
    pub(super) ray: PreparedRay,
    pub(super) at: Place,
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
    /// Nodes that it may still visit.
    pub(super) steps: u32,
}

impl Place {
    /// The root.
    pub(super) const ROOT: Self = Self { block: 0, child: 0, depth: 0, steps: STEPS_MAX };

    /// Counts a node. `true`: no sound tree has so many, or is so deep.
    #[inline(always)]
    pub(super) fn spent(&mut self) -> bool {
        self.steps = self.steps.saturating_sub(1);
        self.steps == 0 || usize::from(self.depth) >= DEPTH_MAX
    }

    /// Goes through a reference.
    #[inline(always)]
    pub(super) fn enter(&mut self, to: Ref) {
        self.block = to.block;
        self.child = to.node & INDEX;
    }
}

/// The path from the root to the current node, with what is left to visit beside it.
#[derive(Debug, Clone)]
pub(super) struct Levels {
    /// Bit `d`: level `d` has children left.
    pub(super) live: u32,
    pub(super) level: [Level; DEPTH_MAX],
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
    pub(super) _zero: [u8; 10],
}

const _: () = {
    assert!(DEPTH_MAX <= 32, "a level is a bit of `live`");
    assert!(size_of::<Level>() == 64);
};

/// More nodes than this no ray visits in a tree that makes sense: 2²⁴. It bounds the time on a file
/// whose blocks refer to the same nodes again and again.
const STEPS_MAX: u32 = 1 << 24;

/// Why a traversal stopped before its end.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TraceError<E> {
    /// The source did not give a block. The traversal can be resumed.
    Source(E),
    /// A block refers to a node that is not there, or the tree is too deep or too large.
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
        Self {
            run: Run { ray: PreparedRay::NONE, at: Place::ROOT },
            best: None,
            levels: Levels::new(),
        }
    }

    /// Keeps what is needed to go on.
    #[cold]
    #[inline(never)]
    pub(super) fn stop(&mut self, run: Run, best: Option<Hit>) {
        self.run = run;
        self.best = best;
    }

    /// The block that the traversal needs next.
    #[must_use]
    pub fn block(&self) -> u32 {
        self.run.at.block
    }
}

impl Run {
    /// Begins a ray, at the root.
    #[inline(always)]
    pub(super) fn new(ray: &Ray) -> Self {
        Self { ray: PreparedRay::new(ray), at: Place::ROOT }
    }
}

impl Levels {
    pub(super) const fn new() -> Self {
        const LEVEL: Level =
            Level { near: [0.0; 8], child: [0; 8], block: 0, flip: 0, pending: 0, _zero: [0; 10] };
        Self { live: 0, level: [LEVEL; DEPTH_MAX] }
    }

    #[inline(always)]
    #[allow(clippy::indexing_slicing, reason = "the mask keeps it in range")]
    pub(super) fn at_mut(&mut self, depth: u32) -> &mut Level {
        // Sound trees stay below DEPTH_MAX; an unsound one finds other levels in place of its own.
        const { assert!(DEPTH_MAX == 32) };
        &mut self.level[(depth & 31) as usize]
    }
}

impl<E: fmt::Display> fmt::Display for TraceError<E> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Source(error) => error.fmt(f),
            Self::Corrupt { block } => {
                write!(
                    f,
                    "block {block} refers to a node that is not there, or the tree is too deep"
                )
            }
        }
    }
}

impl<E: fmt::Debug + fmt::Display> core::error::Error for TraceError<E> {}
