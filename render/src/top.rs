//! The top of a tree, expanded in memory.

use kiloray_core::block::format::Ref;
use kiloray_core::block::{Expanded, ExpandedNode, ExpandedTop, KiloView};

/// Of so many bytes of blocks, one node is expanded.
const BLOCK_BYTES_PER_NODE: usize = 8 << 10;
/// So many nodes at least: all of a small scene.
const NODES_MIN: usize = 64;
/// So many nodes at most: the memory near the processor holds no more.
const NODES_MAX: usize = 2048;

/// The upper levels of the tree of a file as [`ExpandedTop`]: 4 % of the memory that its blocks take, and at most 624 KiB.
///
/// A ray then enters half as many blocks.
#[derive(Debug, Clone, Default)]
pub struct Top {
    nodes: Vec<ExpandedNode>,
    refs: Vec<Ref>,
}

impl Top {
    /// The top of a file, whose blocks must have been checked.
    #[must_use]
    pub fn new(file: &KiloView<'_>) -> Self {
        let bytes = file.limits().block_bytes.saturating_mul(file.blocks() as usize);
        let nodes = (bytes / BLOCK_BYTES_PER_NODE).clamp(NODES_MIN, NODES_MAX);
        let mut source = *file;
        let mut top = Self {
            nodes: vec![bytemuck::Zeroable::zeroed(); nodes],
            refs: vec![bytemuck::Zeroable::zeroed(); ExpandedTop::refs_of(nodes)],
        };
        // A file without blocks has none.
        let grown = ExpandedTop::grow(&mut source, &mut top.nodes, &mut top.refs);
        let (nodes, refs) = grown.map_or((0, 0), |grown| (grown.nodes().len(), grown.refs().len()));
        top.nodes.truncate(nodes);
        top.refs.truncate(refs);
        top
    }

    /// The file with its top.
    #[must_use]
    pub fn over<'a>(&'a self, file: KiloView<'a>) -> Expanded<'a> {
        Expanded { file, top: ExpandedTop::new(&self.nodes, &self.refs) }
    }

    /// What it takes \[bytes\].
    #[must_use]
    pub fn bytes(&self) -> usize {
        ExpandedTop::new(&self.nodes, &self.refs).bytes()
    }
}
