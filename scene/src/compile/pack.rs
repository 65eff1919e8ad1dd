//! Treelets into blocks.
//!
//! Depth first; each treelet goes where it leaves the least room among a few blocks that are still
//! open, none of them before its parent's: references point to greater numbers. Beside its parent a
//! treelet needs no reference at all.

use super::cut::Treelets;
use super::layout::{Layout, Source};

/// Blocks that are kept open: 16 fill to .886, 32 to .91, 64 to .925 (a million triangles, 4 KiB).
const OPEN_MAX: usize = 64;
/// Blocks that are tried although the treelet may not fit.
const TIGHT_MAX: usize = 4;
/// The block of a node that has none yet.
const NOWHERE: u32 = u32::MAX;

/// Which nodes each block has.
#[derive(Debug, Default)]
pub(crate) struct Blocks {
    /// Nodes of block after block, in the order of the block.
    pub(crate) nodes: Vec<Vec<u32>>,
    /// For each node of the tree, its block and its index in it.
    pub(crate) places: Vec<(u32, u16)>,
    /// Bytes in use.
    pub(crate) used: u64,
}

struct Open {
    number: u32,
    layout: Layout,
}

struct Packer<'a> {
    source: Source<'a>,
    parents: &'a [u32],
    open: Vec<Open>,
    spare: Vec<Layout>,
    blocks: Blocks,
}

/// Packs the treelets. `parents` are those of the nodes.
pub(crate) fn pack(source: Source<'_>, parents: &[u32], treelets: &Treelets) -> Blocks {
    let places = vec![(NOWHERE, 0); source.nodes.len()];
    let blocks = Blocks { places, ..Blocks::default() };
    let mut packer = Packer { source, parents, open: Vec::new(), spare: Vec::new(), blocks };
    let mut begin = 0;
    for treelet in &treelets.all {
        let end = treelet.end as usize;
        packer.place(&treelets.nodes[begin..end], treelet.bytes as usize);
        begin = end;
    }
    while !packer.open.is_empty() {
        packer.close(0);
    }
    packer.blocks
}

impl Packer<'_> {
    /// Places the nodes of a treelet, which takes so many bytes alone; its root is the first.
    fn place(&mut self, nodes: &[u32], bytes: usize) {
        let Some(&root) = nodes.first() else { return };
        let above = self.parents[root as usize];
        let above = self.blocks.places.get(above as usize).map_or(0, |place| place.0);
        // Neighbours share vertices, and the parent's block the reference: somewhat less room may do.
        let least = bytes - bytes / 8;
        let mut tries: Vec<(bool, usize, usize)> = Vec::new();
        for (at, open) in self.open.iter().enumerate() {
            let room = self.source.block_bytes - open.layout.bytes();
            if open.number >= above && room >= least {
                tries.push((open.number != above, room, at));
            }
        }
        tries.sort_unstable();
        // The tightest may fail; the first with room enough will not.
        let enough = tries.iter().position(|&(_, room, _)| room >= bytes);
        let tight = tries.iter().take(TIGHT_MAX).chain(enough.map(|at| &tries[at]));
        for &(_, _, at) in tight {
            if self.fit(at, nodes, above) {
                return;
            }
        }
        let at = self.fresh();
        self.fill(at, nodes, above);
    }

    /// Puts all nodes into an open block, or none.
    fn fit(&mut self, at: usize, nodes: &[u32], above: u32) -> bool {
        let open = &mut self.open[at];
        let mark = open.layout.mark();
        for (i, &node) in nodes.iter().enumerate() {
            let inside = i > 0 || open.number == above && node != 0;
            if !open.layout.try_add(self.source, node, inside) {
                open.layout.go_back(mark);
                return false;
            }
        }
        let number = open.number;
        let first = open.layout.nodes.len() - nodes.len();
        for (i, &node) in nodes.iter().enumerate() {
            self.blocks.places[node as usize] = (number, (first + i) as u16);
        }
        true
    }

    /// Puts the nodes into a new block. What does not fit although the cut thought so (a vertex
    /// had to be stored twice) is placed as treelets of its own.
    fn fill(&mut self, at: usize, nodes: &[u32], above: u32) {
        if self.fit(at, nodes, above) {
            return;
        }
        let number = self.open[at].number;
        let mut left = Vec::new();
        for (i, &node) in nodes.iter().enumerate() {
            let parent = self.parents[node as usize] as usize;
            let here = i == 0 || self.blocks.places[parent].0 == number;
            let layout = &mut self.open[at].layout;
            if here && layout.try_add(self.source, node, i > 0) {
                let index = layout.nodes.len() - 1;
                self.blocks.places[node as usize] = (number, index as u16);
            } else {
                left.push(node);
            }
        }
        debug_assert!(left.len() < nodes.len(), "a node fits a block");
        while let Some(&root) = left.first() {
            let mut part = vec![root];
            left.retain(|&node| {
                let below = part.contains(&self.parents[node as usize]);
                if below {
                    part.push(node);
                }
                !below && node != root
            });
            self.place(&part, self.source.block_bytes);
        }
    }

    fn fresh(&mut self) -> usize {
        if self.open.len() == OPEN_MAX {
            let fullest = (0..self.open.len()).max_by_key(|&at| self.open[at].layout.bytes());
            self.close(fullest.unwrap_or(0));
        }
        let number = self.blocks.nodes.len() as u32;
        self.blocks.nodes.push(Vec::new());
        let layout = self.spare.pop().unwrap_or_default();
        self.open.push(Open { number, layout });
        self.open.len() - 1
    }

    fn close(&mut self, at: usize) {
        let mut open = self.open.swap_remove(at);
        self.blocks.used += open.layout.bytes() as u64;
        self.blocks.nodes[open.number as usize] = open.layout.nodes.as_slice().into();
        open.layout.clear();
        self.spare.push(open.layout);
    }
}
