use core::fmt;

use crate::block::format::DEPTH_MAX;
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
    /// The node to enter, unless it returns to its deepest live level.
    pub(super) node: u16,
    /// The level of that node.
    pub(super) depth: u8,
    /// It enters a node; otherwise it returns.
    pub(super) enter: bool,
    /// Nodes that it may still visit.
    pub(super) steps: u32,
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
    /// The block and the node that this level is.
    pub(super) block: u32,
    pub(super) node: u16,
    /// Slot `k ^ flip` is visited `k`th.
    pub(super) flip: u8,
    /// Bit `k`: still to be visited.
    pub(super) pending: u8,
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
        const LEVEL: Level =
            Level { near: [0.0; 8], child: [0; 8], block: 0, node: 0, flip: 0, pending: 0 };
        Self {
            run: Run {
                ray: PreparedRay::NONE,
                at: Place { block: 0, node: 0, depth: 0, enter: false, steps: 0 },
            },
            best: None,
            levels: Levels { live: 0, level: [LEVEL; DEPTH_MAX] },
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
        let ray = PreparedRay::new(ray);
        let enter = !ray.is_none();
        Self { ray, at: Place { block: 0, node: 0, depth: 0, enter, steps: STEPS_MAX } }
    }
}

impl Levels {
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
