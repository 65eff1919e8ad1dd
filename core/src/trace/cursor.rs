use core::fmt;

use super::code::{EMPTY, INDEX};
use super::group::Crossings;
use super::stack::{Entry, Height, Stack};
use super::trail::Trail;
use crate::block::format::{DEPTH_MAX, Ref};
use crate::geometry::{Hit, PreparedRay};

/// The whole state of a traversal: where it is, what is still to be visited, and the best hit so far.
///
/// About 2.3 KiB, of which a traversal touches a part as deep as it goes. One is made once and used for ray after ray.
/// When its source stops a traversal, the cursor has the [`Trail`] by which it goes on, with this cursor or with any other.
#[derive(Debug, Clone)]
pub struct Cursor {
    /// The ray. Its end is up to date only where it is looked for.
    pub(super) ray: PreparedRay,
    pub(super) trail: Trail,
    pub(super) best: Option<Hit>,
    pub(super) stack: Stack,
    pub(super) visited: Visited,
    /// Where lanes put what they find in a record. It means nothing from one to the next, and is not made anew for each ray.
    pub(super) crossings: Crossings,
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
    /// The child it visits there; an empty one: back to the next that waits.
    pub(super) entry: Entry,
    /// Nodes that it may still visit.
    pub(super) nodes: u32,
    /// Leaves that it has visited.
    pub(super) leaves: u32,
}

impl Place {
    /// The root.
    pub(super) const ROOT: Self =
        Self { block: 0, entry: Entry::ROOT, nodes: NODES_MAX, leaves: 0 };

    /// The bits of the child.
    #[inline(always)]
    pub(super) const fn child(&self) -> u16 {
        self.entry.child()
    }

    /// Counts a node. `true`: no sound tree has so many.
    #[inline(always)]
    pub(super) fn too_many(&mut self) -> bool {
        let (nodes, too_many) = self.nodes.overflowing_sub(1);
        self.nodes = nodes;
        too_many
    }

    /// Counts a node. `true`: no sound tree has so many, or is so deep.
    #[inline(always)]
    pub(super) fn spent(&mut self) -> bool {
        self.too_many() || usize::from(self.entry.level()) >= DEPTH_MAX
    }

    /// How many nodes it has visited.
    pub(super) fn nodes_visited(&self) -> u64 {
        NODES_MAX.wrapping_sub(self.nodes).into()
    }

    /// Counts a leaf.
    #[inline(always)]
    pub(super) fn tests(&mut self) {
        self.leaves = self.leaves.wrapping_add(1);
    }

    /// Goes through a reference.
    #[inline(always)]
    pub(super) fn enter(&mut self, to: Ref) {
        self.block = to.block;
        self.entry = self.entry.with_child(to.node & INDEX);
    }

    /// Here is nothing.
    #[inline(always)]
    pub(super) fn is_empty(&mut self) {
        self.entry = self.entry.with_child(EMPTY);
    }

    /// Goes back to the root.
    #[inline(always)]
    pub(super) fn leave(&mut self) {
        *self = Self { nodes: self.nodes, leaves: self.leaves, ..Self::ROOT };
    }
}

/// More nodes than this no ray visits in a tree that makes sense: 2²⁴. It bounds the time on a file
/// whose blocks refer to the same nodes again and again.
const NODES_MAX: u32 = 1 << 24;

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
        let visited = Visited { nodes: 0, leaves: 0, blocks: 0 };
        let crossings = Crossings::NONE;
        let ray = PreparedRay::NONE;
        Self { ray, trail: Trail::START, best: None, stack: Stack::new(), visited, crossings }
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
        self.visited
    }

    /// What was visited; counts from zero again.
    pub fn take_visited(&mut self) -> Visited {
        core::mem::take(&mut self.visited)
    }

    /// Counts what was visited on the way to a place.
    #[inline(always)]
    pub(super) fn count(&mut self, at: &Place) {
        let visited = &mut self.visited;
        visited.nodes = visited.nodes.wrapping_add(at.nodes_visited());
        visited.leaves = visited.leaves.wrapping_add(at.leaves.into());
    }

    /// Keeps where to go on.
    #[cold]
    #[inline(never)]
    pub(super) fn stop(&mut self, at: Place, height: Height, collapsed: u32, t_max: f32) {
        let left = collapsed | self.stack.reached(&height, t_max);
        self.trail = Trail::new(&at, self.stack.taken().iter().copied(), left);
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
