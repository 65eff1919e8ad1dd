//! The top of the tree a second time, expanded: for machines that have the memory, and all blocks at hand.

use bytemuck::{Pod, Zeroable};

use super::file::KiloView;
use super::format::{BlockHeader, Child, Node, Ref};
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
    /// What is below, by slot: see [`ExpandedTop`].
    pub child: [u16; 8],
    /// The block of the node that it is made of.
    pub block: u32,
    /// The index of that node in its block.
    pub node: u16,
    /// The axis bits of that node's first six children, slot 0 lowest.
    pub axes: u8,
    /// Zero.
    pub _zero: [u8; 41],
}

/// The upper levels of the tree, decoded once for all rays: most nodes that a ray visits lie there, and most blocks that it would enter
/// on its way.
///
/// Node 0 is the root. A child of a node is
///
/// | bits | meaning |
/// | --- | --- |
/// | below 3000 (hexadecimal) | a node of the top, by index |
/// | 15 = 1 | a [`Ref`] by bits 0–14; its `node` holds the bits of a [`Child`] of its block, a node or a leaf |
/// | others | empty |
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

/// In the child of an [`ExpandedNode`]: it is a reference.
const REF: u16 = 1 << 15;
/// References that a node adds at most: it takes the place of one, and may bring eight.
const ADDED: usize = 7;

impl<'a> ExpandedTop<'a> {
    /// None: a traversal begins in the first block.
    pub const NONE: Self = Self { nodes: &[], refs: &[] };
    /// More nodes than this are not used.
    pub const NODES_MAX: usize = (REF as usize - 1) / ADDED;
    /// The frame of its boxes.
    pub const FRAME: BlockHeader = BlockHeader { scale: [1.0; 3], ..NO_HEADER };

    /// The top of nodes and references as they are.
    #[must_use]
    pub const fn new(nodes: &'a [ExpandedNode], refs: &'a [Ref]) -> Self {
        Self { nodes, refs }
    }

    /// So many references so many nodes have at most.
    #[must_use]
    pub const fn refs_of(nodes: usize) -> usize {
        nodes.saturating_mul(ADDED).saturating_add(1)
    }

    /// Decodes the upper levels of the tree of a source, level by level, as many nodes as there is room for.
    ///
    /// # Errors
    /// Those of the source.
    pub fn grow<S: BlockSource>(
        source: &mut S,
        nodes: &'a mut [ExpandedNode],
        refs: &'a mut [Ref],
    ) -> Result<Self, S::Error> {
        let room = nodes.len().min(refs.len().saturating_sub(1) / ADDED).min(Self::NODES_MAX);
        let mut grown =
            Growing { nodes: nodes.get_mut(..room).unwrap_or_default(), refs, len: (0, 0) };
        let _ = grown.push_node(0, 0);
        let mut index = 0;
        while let Some(&ExpandedNode { block, node, .. }) =
            grown.nodes.get(..grown.len.0).and_then(|nodes| nodes.get(index))
        {
            let view = source.block(block)?;
            let expanded = view.node(node).map(|node| grown.expanded(&view, node));
            if let (Some(place), Some(expanded)) = (grown.nodes.get_mut(index), expanded) {
                *place = ExpandedNode { block, node, ..expanded };
            }
            index += 1;
        }
        let Growing { nodes, refs, len } = grown;
        Ok(Self {
            nodes: nodes.get(..len.0).unwrap_or_default(),
            refs: refs.get(..len.1).unwrap_or_default(),
        })
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

    /// Its references.
    #[must_use]
    pub const fn refs(&self) -> &'a [Ref] {
        self.refs
    }

    /// What it takes \[bytes\].
    #[must_use]
    pub const fn bytes(&self) -> usize {
        size_of_val(self.nodes) + size_of_val(self.refs)
    }

    /// The node that a child is.
    #[inline(always)]
    pub(crate) fn node(&self, child: u16) -> Option<&'a ExpandedNode> {
        self.nodes.get(usize::from(child))
    }

    /// The reference that a child is.
    #[inline(always)]
    pub(crate) fn reference(&self, child: u16) -> Option<Ref> {
        self.refs.get(usize::from(child & !REF)).copied()
    }

    /// Whether a child is a reference.
    #[inline(always)]
    pub(crate) const fn is_ref(child: u16) -> bool {
        child & REF != 0
    }
}

/// A top that is made.
struct Growing<'a> {
    nodes: &'a mut [ExpandedNode],
    refs: &'a mut [Ref],
    /// How many there are of both.
    len: (usize, usize),
}

impl Growing<'_> {
    /// A node of a block in scene coordinates, its children queued as nodes of the top while there is room.
    fn expanded(&mut self, view: &BlockView<'_>, node: &Node) -> ExpandedNode {
        let BlockHeader { origin, scale, .. } = *view.header();
        let mut to = ExpandedNode { axes: node.axis_code(), ..ExpandedNode::zeroed() };
        for (to, from) in [(&mut to.lo, &node.lo), (&mut to.hi, &node.hi)] {
            for (((to, from), origin), scale) in to.iter_mut().zip(from).zip(origin).zip(scale) {
                for (to, &q) in to.iter_mut().zip(from) {
                    // Exact: see `format`.
                    *to = origin + scale * f32::from(q);
                }
            }
        }
        for (to, &bits) in to.child.iter_mut().zip(&node.child) {
            *to = self.child(view, Child::decode(bits));
        }
        to
    }

    fn child(&mut self, view: &BlockView<'_>, child: Child) -> u16 {
        let to = match child {
            Child::Empty => None,
            Child::Leaf { .. } => self.push_ref(view.number(), child),
            Child::Node(node) => self.push(view.number(), node),
            Child::Ref(index) => view.reference(index).and_then(|to| self.push(to.block, to.node)),
        };
        to.unwrap_or(Child::Empty.encode())
    }

    fn push(&mut self, block: u32, node: u16) -> Option<u16> {
        self.push_node(block, node).or_else(|| self.push_ref(block, Child::Node(node)))
    }

    fn push_node(&mut self, block: u32, node: u16) -> Option<u16> {
        let index = self.len.0;
        *self.nodes.get_mut(index)? = ExpandedNode { block, node, ..ExpandedNode::zeroed() };
        self.len.0 += 1;
        Some(index as u16)
    }

    fn push_ref(&mut self, block: u32, child: Child) -> Option<u16> {
        let index = self.len.1;
        *self.refs.get_mut(index)? = Ref { block, node: child.encode(), _zero: 0 };
        self.len.1 += 1;
        Some(REF | index as u16)
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
const _: () = assert!(ExpandedTop::NODES_MAX <= Child::Empty.encode() as usize);
