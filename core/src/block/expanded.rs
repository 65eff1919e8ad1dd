//! The top of the tree a second time, expanded: for machines that have the memory, and all blocks at hand.

use bytemuck::{Pod, Zeroable};

use super::file::KiloView;
use super::format::{BlockHeader, Node, Ref};
use super::source::{BlockSource, NoBlock};
use super::view::{BlockView, NO_HEADER};

/// A [`Node`] with its boxes as f32 in scene coordinates: no frame to be made for a block, no integers to be converted.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[repr(C, align(64))]
pub struct ExpandedNode {
    /// Lower bounds, by axis, by slot.
    pub lo: [[f32; 8]; 3],
    /// Upper bounds, by axis, by slot.
    pub hi: [[f32; 8]; 3],
    /// What is below, by slot: the bits of an [`ExpandedChild`].
    pub child: [u32; 8],
    /// [`Node::order`].
    pub order: [u32; 4],
    /// What `nodes` count from: child `s` of them is node `first + s`.
    pub first: u32,
    /// Slots, by bits, whose child is known from there: what comes next need not wait until it is read.
    pub nodes: u32,
    /// By slot, of a leaf: the line of its block from which on most of its vertices lie. It is where to read ahead, and means nothing else.
    pub lines: [u8; 8],
}

/// A child of an [`ExpandedNode`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ExpandedChild {
    /// Nothing.
    Empty,
    /// A node of the top, by index.
    Node(u32),
    /// A leaf of a block. Its records are found without the block's header, which is read meanwhile.
    Leaf {
        /// The block.
        block: u32,
        /// Where in it the records begin, as in a [`Child`](super::format::Child).
        at: u16,
        /// How many there are: 1 to 4.
        count: u16,
        /// [`ExpandedNode::lines`], or 0.
        lines: u8,
    },
    /// Index into the references of the top. The `node` of such a [`Ref`] holds the bits of a [`Child`](super::format::Child) of its block, a node or a leaf.
    Ref(u32),
}

/// The upper levels of the tree, decoded once for all rays: most nodes that a ray visits lie there, and most blocks that it would enter
/// on its way.
///
/// Node 0 is the root. A child of a node is
///
/// | bits | meaning |
/// | --- | --- |
/// | below 7fffffff (hexadecimal) | [`ExpandedChild::Node`] |
/// | 7fffffff | empty |
/// | 31, 30 = 1, 0 | [`ExpandedChild::Leaf`]: bits 0–11 say where its records begin, 12–13 how many there are but one, 14–29 the block |
/// | 31, 30 = 1, 1 | [`ExpandedChild::Ref`] by bits 0–29 |
///
/// Hits are the same with it and without, for the boxes are: see [`BoxFrame`](crate::trace::BoxFrame).
///
/// # Bounds
/// Any content is harmless. One that is not of the tree may hide hits, or end in an error.
#[derive(Debug, Clone, Copy, Default)]
pub struct ExpandedTop<'a> {
    nodes: &'a [ExpandedNode],
    refs: &'a [Ref],
}

/// In the bits of a child: it is a reference.
const REF: u32 = 0b11 << 30;
/// It is a leaf.
const LEAF: u32 = 0b10 << 30;
/// In the bits of a leaf: where its records begin.
const AT: u16 = 0x0fff;

impl ExpandedChild {
    /// Leaves of blocks from this number on are references.
    pub const LEAF_BLOCKS: u32 = 1 << 16;

    /// Its bits.
    #[must_use]
    pub const fn encode(self) -> u32 {
        match self {
            Self::Empty => ExpandedTop::EMPTY,
            Self::Node(index) => index,
            Self::Leaf { block, at, count, .. } => {
                let bits = at & AT | (count.wrapping_sub(1) & 3) << 12;
                LEAF | (block & (Self::LEAF_BLOCKS - 1)) << 14 | bits as u32
            }
            Self::Ref(index) => REF | index & !REF,
        }
    }
}

impl ExpandedNode {
    /// So many [lines](Self::lines) are read ahead: of a mesh of a million triangles in blocks of 16 KiB they hold five of six that a leaf's vertices lie in.
    pub const LINES: usize = 6;
    /// The length of a line \[bytes\]: that of processors' caches.
    pub const LINE_BYTES: usize = 64;

    /// A node without children.
    pub const NONE: Self = Self {
        lo: [[0.0; 8]; 3],
        hi: [[0.0; 8]; 3],
        child: [ExpandedTop::EMPTY; 8],
        order: [0; 4],
        first: 0,
        nodes: 0,
        lines: [0; 8],
    };

    /// A node of a block in scene coordinates, with the children that it is to have, by slot.
    #[must_use]
    pub fn of(view: &BlockView<'_>, node: &Node, child: [ExpandedChild; 8]) -> Self {
        let BlockHeader { origin, scale, .. } = *view.header();
        let bits = child.map(ExpandedChild::encode);
        let (mut first, mut nodes) = (0, 0);
        for (slot, child) in (0_u32..).zip(child) {
            if let ExpandedChild::Node(index) = child {
                let of_first = index.wrapping_sub(slot);
                if nodes == 0 {
                    first = of_first;
                }
                nodes |= u32::from(of_first == first) << slot;
            }
        }
        let lines = child.map(|child| match child {
            ExpandedChild::Leaf { lines, .. } => lines,
            _ => 0,
        });
        let mut to = Self { child: bits, order: node.order, first, nodes, lines, ..Self::NONE };
        for (to, from) in [(&mut to.lo, &node.lo), (&mut to.hi, &node.hi)] {
            for (((to, from), origin), scale) in to.iter_mut().zip(from).zip(origin).zip(scale) {
                for (to, &q) in to.iter_mut().zip(from) {
                    // Exact: see `format`.
                    *to = origin + scale * f32::from(q);
                }
            }
        }
        to
    }
}

impl<'a> ExpandedTop<'a> {
    /// None: a traversal begins in the first block.
    pub const NONE: Self = Self { nodes: &[], refs: &[] };
    /// The bits of no child.
    pub const EMPTY: u32 = LEAF - 1;
    /// The frame of its boxes.
    pub const FRAME: BlockHeader = BlockHeader { scale: [1.0; 3], ..NO_HEADER };

    /// The top of nodes and references as they are.
    #[must_use]
    pub const fn new(nodes: &'a [ExpandedNode], refs: &'a [Ref]) -> Self {
        Self { nodes, refs }
    }

    /// Whether there is none.
    #[inline(always)]
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.nodes.is_empty()
    }

    /// Its nodes.
    #[must_use]
    pub const fn nodes(&self) -> &'a [ExpandedNode] {
        self.nodes
    }

    /// What it takes \[bytes\].
    #[must_use]
    pub const fn bytes(&self) -> usize {
        size_of_val(self.nodes) + size_of_val(self.refs)
    }

    /// The node that a child is.
    #[inline(always)]
    pub(crate) fn node(&self, child: u32) -> Option<&'a ExpandedNode> {
        self.nodes.get(child as usize)
    }

    /// The block of the leaf that a child is, where its records begin, and how many there are.
    #[inline(always)]
    pub(crate) const fn leaf(child: u32) -> Option<(u32, u16, u16)> {
        if child & REF == LEAF {
            let block = child >> 14 & (ExpandedChild::LEAF_BLOCKS - 1);
            Some((block, child as u16 & AT, (child as u16 >> 12 & 3) + 1))
        } else {
            None
        }
    }

    /// The reference that a child is.
    #[inline(always)]
    pub(crate) fn reference(&self, child: u32) -> Option<Ref> {
        self.refs.get(child.checked_sub(REF)? as usize).copied()
    }
}

/// A file in memory with the top of its tree.
#[derive(Debug, Clone, Copy)]
pub struct Expanded<'a> {
    /// The file.
    pub file: KiloView<'a>,
    /// Of its tree.
    pub top: ExpandedTop<'a>,
}

impl BlockSource for Expanded<'_> {
    type Error = NoBlock;

    #[inline(always)]
    fn block(&mut self, block: u32) -> Result<BlockView<'_>, NoBlock> {
        self.file.block(block)
    }

    #[inline(always)]
    fn holds_all(&self) -> bool {
        true
    }

    #[inline(always)]
    fn top(&self) -> ExpandedTop<'_> {
        self.top
    }
}

const _: () = assert!(size_of::<ExpandedNode>() == 256, "an index is shifted, not multiplied");
