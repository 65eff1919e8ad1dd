//! The top of a tree, expanded in memory.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use kiloray_core::block::format::{BlockHeader, Child, Node, RECORD_SPHERES, Ref};
use kiloray_core::block::{
    BlockView, Expanded, ExpandedChild, ExpandedNode, ExpandedTop, KiloView,
};
use memmap2::MmapMut;

/// Of so many bytes of blocks, one node is expanded: two fifths of the memory that blocks take.
const BLOCK_BYTES_PER_NODE: usize = 640;
/// So many nodes at least: all of a small scene.
const NODES_MIN: usize = 64;
/// So many nodes at most: 64 MiB.
const NODES_MAX: usize = 1 << 18;

/// The upper part of the tree of a file as [`ExpandedTop`]: the nodes with the greatest boxes, which most rays visit, in two fifths of the memory that
/// its blocks take. Where the system has large pages they lie in such: each node that a ray visits lies in another page.
///
/// It is empty where the system has no memory for it: rays are traced without it, slower.
#[derive(Debug, Default)]
pub struct Top {
    /// The nodes, and perhaps what fills the last page.
    pages: Option<MmapMut>,
    nodes: usize,
    refs: Vec<Ref>,
}

/// A large page \[bytes\].
const LARGE_PAGE: usize = 2 << 20;

impl Top {
    /// The top of a file, whose blocks must have been checked.
    #[must_use]
    pub fn new(file: &KiloView<'_>) -> Self {
        let bytes = file.limits().block_bytes.saturating_mul(file.blocks() as usize);
        let chosen = choose(file, (bytes / BLOCK_BYTES_PER_NODE).clamp(NODES_MIN, NODES_MAX));
        let places = numbered(&chosen);
        let mut numbers = vec![0; chosen.len()];
        for (&index, number) in places.iter().zip(0..) {
            if let Some(index) = index {
                numbers[index] = number;
            }
        }
        let Some(mut pages) = pages(places.len() * size_of::<ExpandedNode>()) else {
            return Self::default();
        };
        let mut refs = Vec::new();
        let nodes: &mut [ExpandedNode] = bytemuck::cast_slice_mut(&mut pages);
        for (to, &index) in nodes.iter_mut().zip(&places) {
            let stored = index.and_then(|index| {
                let Chosen { block, node, below } = chosen[index];
                Some((block, node_of(file, block, node)?, below))
            });
            let Some((block, (view, node), below)) = stored else {
                *to = ExpandedNode::NONE;
                continue;
            };
            let child =
                std::array::from_fn(|slot| match (below[slot], Child::decode(node.child[slot])) {
                    (Some(index), _) => ExpandedChild::Node(numbers[index]),
                    (None, Child::Empty) => ExpandedChild::Empty,
                    (None, Child::Leaf { at, count }) if block < ExpandedChild::LEAF_BLOCKS => {
                        let lines = lines(&view, at, count);
                        ExpandedChild::Leaf { block, at, count, lines }
                    }
                    (None, child) => {
                        let to = inside(&view, child)
                            .map_or((block, child), |(block, node)| (block, Child::Node(node)));
                        refs.push(Ref { block: to.0, node: to.1.encode(), _zero: 0 });
                        ExpandedChild::Ref(refs.len() as u32 - 1)
                    }
                });
            *to = ExpandedNode::of(&view, node, child);
        }
        Self { pages: Some(pages), nodes: places.len(), refs }
    }

    /// The file with its top.
    #[must_use]
    pub fn over<'a>(&'a self, file: KiloView<'a>) -> Expanded<'a> {
        Expanded { file, top: self.view() }
    }

    /// What it takes \[bytes\].
    #[must_use]
    pub fn bytes(&self) -> usize {
        self.view().bytes()
    }

    fn view(&self) -> ExpandedTop<'_> {
        let nodes = bytemuck::cast_slice(self.pages.as_deref().unwrap_or_default());
        ExpandedTop::new(nodes.get(..self.nodes).unwrap_or_default(), &self.refs)
    }
}

/// Memory of its own for so many bytes, if the system has it.
fn pages(bytes: usize) -> Option<MmapMut> {
    // Only whole pages are large.
    let bytes = if bytes < LARGE_PAGE { bytes } else { bytes.next_multiple_of(LARGE_PAGE) };
    let pages = MmapMut::map_anon(bytes).ok()?;
    // A system without large pages does without.
    #[cfg(target_os = "linux")]
    let _ = pages.advise(memmap2::Advice::HugePage);
    Some(pages)
}

/// These nodes by number; some numbers are nobody's. The root is 0, and the numbers of a node's children differ as their slots do, so that a child's follows from
/// its slot (a double array: Aoe 1989). Nodes that one ray visits lie near each other: depth first, each node's children together.
fn numbered(chosen: &[Chosen]) -> Vec<Option<usize>> {
    /// What is left free so far back stays so, or more and more of it would be gone through.
    const BACK: usize = 256;
    let root = (!chosen.is_empty()).then_some(0);
    let mut places: Vec<Option<usize>> = root.into_iter().map(Some).collect();
    let mut free = 0;
    let mut stack: Vec<usize> = root.into_iter().collect();
    while let Some(index) = stack.pop() {
        let below = &chosen[index].below;
        let slots = || below.iter().zip(0..).filter_map(|(child, slot)| Some((slot, (*child)?)));
        let Some((least, _)) = slots().next() else { continue };
        free = free.max(places.len().saturating_sub(BACK));
        while places.get(free).is_some_and(Option::is_some) {
            free += 1;
        }
        let mut first = free.saturating_sub(least);
        while slots().any(|(slot, _)| places.get(first + slot).is_some_and(Option::is_some)) {
            first += 1;
        }
        for (slot, child) in slots() {
            places.resize(places.len().max(first + slot + 1), None);
            places[first + slot] = Some(child);
        }
        stack.extend(below.iter().rev().flatten());
    }
    places
}

/// A node that is expanded.
struct Chosen {
    block: u32,
    node: u16,
    /// Its children that are expanded as well, by slot.
    below: [Option<usize>; 8],
}

/// A node that may be.
struct Candidate {
    /// Half the surface of its box.
    area: f32,
    block: u32,
    node: u16,
    /// The one above it, among the chosen, and the slot there.
    above: Option<(usize, usize)>,
}

/// The greatest first; of equal ones, that of the first block.
impl Ord for Candidate {
    fn cmp(&self, other: &Self) -> Ordering {
        let place = |c: &Self| (c.block, c.node);
        self.area.total_cmp(&other.area).then_with(|| place(other).cmp(&place(self)))
    }
}

impl PartialOrd for Candidate {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Candidate {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Candidate {}

/// The nodes with the greatest boxes, a node before those below it, at most so many.
fn choose(file: &KiloView<'_>, room: usize) -> Vec<Chosen> {
    let mut chosen: Vec<Chosen> = Vec::with_capacity(room.min(file.blocks() as usize * 64));
    let root = Candidate { area: f32::INFINITY, block: 0, node: 0, above: None };
    let mut candidates = BinaryHeap::from([root]);
    while chosen.len() < room {
        let Some(Candidate { block, node, above, .. }) = candidates.pop() else { break };
        let Some((view, stored)) = node_of(file, block, node) else { continue };
        let index = chosen.len();
        if let Some((above, slot)) = above {
            chosen[above].below[slot] = Some(index);
        }
        chosen.push(Chosen { block, node, below: [None; 8] });
        for (slot, &bits) in stored.child.iter().enumerate() {
            if let Some((block, node)) = inside(&view, Child::decode(bits)) {
                let area = area(&view, stored, slot);
                candidates.push(Candidate { area, block, node, above: Some((index, slot)) });
            }
        }
    }
    chosen
}

/// A node of a file.
fn node_of<'a>(file: &KiloView<'a>, block: u32, node: u16) -> Option<(BlockView<'a>, &'a Node)> {
    let view = file.trusted_block(block)?;
    Some((view, view.node(node)?))
}

/// The block and index of the node that a child is.
fn inside(view: &BlockView<'_>, child: Child) -> Option<(u32, u16)> {
    match child {
        Child::Node(node) => Some((view.number(), node)),
        Child::Ref(index) => view.reference(index).map(|to| (to.block, to.node)),
        Child::Leaf { .. } | Child::Empty => None,
    }
}

/// Where the vertices of a leaf lie, as [`ExpandedNode::lines`] has it: the line from which on most are read. 0 if that does not fit in.
fn lines(view: &BlockView<'_>, at: u16, count: u16) -> u8 {
    const VERTEX: usize = size_of::<[f32; 3]>();
    let mut lines = Vec::with_capacity(64);
    for record in view.leaf(at, count) {
        let base = record.base & !RECORD_SPHERES;
        for &index in record.index.iter().filter(|[a, b, c]| a != b || b != c).flatten() {
            let begin = size_of::<BlockHeader>() + VERTEX * usize::from(base + u16::from(index));
            lines.extend([begin, begin + VERTEX - 1].map(|byte| byte / ExpandedNode::LINE_BYTES));
        }
    }
    lines.sort_unstable();
    lines.dedup();
    let read = |from: usize| {
        let ahead = lines[from..].iter();
        ahead.take_while(|&&line| line < lines[from] + ExpandedNode::LINES).count()
    };
    // The first of equal ones.
    let best = (0..lines.len()).rev().max_by_key(|&from| read(from));
    best.and_then(|from| u8::try_from(lines[from]).ok()).unwrap_or(0)
}

/// Half the surface of a slot's box.
fn area(view: &BlockView<'_>, node: &Node, slot: usize) -> f32 {
    let extent = |axis: usize| {
        let steps = node.hi[axis][slot].saturating_sub(node.lo[axis][slot]);
        view.header().scale[axis] * f32::from(steps)
    };
    let (x, y, z) = (extent(0), extent(1), extent(2));
    x * y + y * z + z * x
}
