//! The same hit from every block size, order, lane width and way of asking, against brute force with
//! the reference test.

pub(crate) mod agree;
pub(crate) mod bundles;
pub(crate) mod frames;
pub(crate) mod scenes;
pub(crate) mod trails;
pub(crate) mod writer;

use std::vec::Vec;

use crate::block::format::{Child, Ref};
use crate::block::{
    BlockLimits, BlockSource, BlockView, ExpandedChild, ExpandedNode, ExpandedTop, NoBlock,
};
use crate::geometry::{Hit, PreparedRay, Primitive, Ray};
use writer::{Blocks, Item};

/// A source of any kind: all that traces is compiled for each type of source, in each of the lanes.
pub(crate) type Source<'a> = &'a mut (dyn BlockSource<Error = NoBlock> + 'a);

/// Any source, as one of that type.
pub(crate) fn erased<'a>(source: &'a mut (dyn BlockSource<Error = NoBlock> + 'a)) -> Source<'a> {
    source
}

/// Who is shown every hit, of one type, for the same reason.
pub(crate) type Visit<'a> = &'a mut (dyn FnMut(&Hit) -> bool + 'a);

/// All blocks, always.
pub(crate) struct Resident<'a>(pub(crate) &'a Blocks);

impl BlockSource for Resident<'_> {
    type Error = NoBlock;
    fn block(&mut self, block: u32) -> Result<BlockView<'_>, NoBlock> {
        self.0.get(block).map(BlockView::trusted).ok_or(NoBlock(block))
    }

    fn holds_all(&self) -> bool {
        true
    }
}

/// All blocks, always, with the top of their tree.
pub(crate) struct Topped<'a>(pub(crate) Resident<'a>, pub(crate) ExpandedTop<'a>);

impl BlockSource for Topped<'_> {
    type Error = NoBlock;
    fn block(&mut self, block: u32) -> Result<BlockView<'_>, NoBlock> {
        self.0.block(block)
    }

    fn holds_all(&self) -> bool {
        self.0.holds_all()
    }

    fn top(&self) -> ExpandedTop<'_> {
        self.1
    }
}

/// The top of a tree: level by level, so many nodes.
pub(crate) struct Grown {
    pub(crate) nodes: Vec<ExpandedNode>,
    pub(crate) refs: Vec<Ref>,
    /// Where the nodes come from: block, and index in it.
    pub(crate) from: Vec<(u32, u16)>,
}

impl Grown {
    pub(crate) fn new(blocks: &Blocks, room: usize) -> Self {
        let mut grown = Self { nodes: std::vec![], refs: std::vec![], from: std::vec![(0, 0)] };
        while let Some(&(block, index)) = grown.from.get(grown.nodes.len()) {
            let view = BlockView::trusted(blocks.get(block).unwrap());
            let node = view.node(index).unwrap();
            let child = node.child.map(|bits| {
                let (block, child) = match Child::decode(bits) {
                    Child::Empty => return ExpandedChild::Empty,
                    Child::Ref(index) => {
                        let to = view.reference(index).unwrap();
                        (to.block, Child::Node(to.node))
                    }
                    child => (block, child),
                };
                match child {
                    Child::Node(node) if grown.from.len() < room => {
                        grown.from.push((block, node));
                        ExpandedChild::Node(grown.from.len() as u32 - 1)
                    }
                    // Some leaves by reference, as those of blocks with great numbers are.
                    Child::Leaf { at, count } if at % 3 > 0 => {
                        ExpandedChild::Leaf { block, at, count, lines: at as u8 }
                    }
                    child => {
                        grown.refs.push(Ref { block, node: child.encode(), _zero: 0 });
                        ExpandedChild::Ref(grown.refs.len() as u32 - 1)
                    }
                }
            });
            grown.nodes.push(ExpandedNode::of(&view, node, child));
        }
        grown
    }

    pub(crate) fn top(&self) -> ExpandedTop<'_> {
        ExpandedTop::new(&self.nodes, &self.refs)
    }
}

/// One frame: every block that is asked for replaces the one before.
pub(crate) struct OneFrame<'a> {
    blocks: &'a Blocks,
    frame: Vec<[u128; 64]>,
    held: Option<u32>,
    pub(crate) fetches: usize,
}

impl<'a> OneFrame<'a> {
    pub(crate) fn new(blocks: &'a Blocks) -> Self {
        let frame = std::vec![[0; 64]; blocks.block_bytes / 1024];
        Self { blocks, frame, held: None, fetches: 0 }
    }
}

impl BlockSource for OneFrame<'_> {
    type Error = NoBlock;
    fn block(&mut self, block: u32) -> Result<BlockView<'_>, NoBlock> {
        let frame: &mut [u8] = bytemuck::cast_slice_mut(&mut self.frame);
        if self.held != Some(block) {
            frame.copy_from_slice(self.blocks.get(block).ok_or(NoBlock(block))?);
            self.held = Some(block);
            self.fetches += 1;
        }
        Ok(BlockView::trusted(frame))
    }
}

pub(crate) fn limits(blocks: &Blocks) -> BlockLimits {
    BlockLimits {
        block_bytes: blocks.block_bytes,
        blocks: blocks.count(),
        materials: u32::from(u16::MAX),
    }
}

/// Every block passes the reader's checks.
pub(crate) fn check(blocks: &Blocks) {
    for block in 0..blocks.count() {
        let bytes = blocks.get(block).unwrap();
        let view = BlockView::parse(bytes, block, &limits(blocks)).unwrap();
        assert_eq!(view.number(), block);
    }
}

/// The hit of one primitive, by the definition.
pub(crate) fn hit_of(ray: &PreparedRay, item: &Item) -> Option<Hit> {
    let (t, b1, b2) = match item.0 {
        Primitive::Triangle { vertices, .. } => {
            ray.triangle(vertices).map(|h| (h.t, h.b1, h.b2))?
        }
        Primitive::Sphere { center, radius, .. } => (ray.sphere(center, radius)?, 0.0, 0.0),
    };
    Some(Hit { t, b1, b2, material: item.1, primitive: item.0, block: 0 })
}

/// All hits of a ray, the closest first.
pub(crate) fn brute(items: &[Item], ray: &Ray) -> Vec<Hit> {
    let prepared = PreparedRay::new(ray);
    let mut hits: Vec<Hit> = items.iter().filter_map(|i| hit_of(&prepared, i)).collect();
    sort(&mut hits);
    hits
}

/// All hits that are shown, the closest first, beside what is answered.
pub(crate) fn shown<T>(ask: impl FnOnce(Visit<'_>) -> T) -> (T, Vec<Hit>) {
    let mut hits = Vec::new();
    let answer = ask(&mut |hit| {
        hits.push(*hit);
        false
    });
    sort(&mut hits);
    (answer, hits)
}

/// The closest first.
fn sort(hits: &mut [Hit]) {
    hits.sort_by(|a, b| b.is_closer_than(a).cmp(&a.is_closer_than(b)));
}
