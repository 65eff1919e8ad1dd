//! A writer of blocks for tests: eight children by medians, blocks filled breadth first. Small and slow; the
//! scene compiler is another.

use std::vec::Vec;

use glam::Vec3;

use crate::block::checksum;
use crate::block::format::{
    BlockHeader, Child, FLAG_NORMALS, Node, RECORD_PRIMITIVES, RECORD_SPHERES, Record, Ref,
    order_of,
};
use crate::geometry::{Aabb, Primitive};

/// A primitive with its material.
pub(crate) type Item = (Primitive, u16);

/// Blocks of one size, behind each other, aligned.
#[derive(Debug, Clone)]
pub(crate) struct Blocks {
    words: Vec<[u128; 64]>,
    pub(crate) block_bytes: usize,
}

impl Blocks {
    pub(crate) fn count(&self) -> u32 {
        (self.words.len() * 1024 / self.block_bytes) as u32
    }

    pub(crate) fn get(&self, block: u32) -> Option<&[u8]> {
        let at = block as usize * self.block_bytes;
        let bytes: &[u8] = bytemuck::cast_slice(&self.words);
        bytes.get(at..at + self.block_bytes)
    }

    pub(crate) fn get_mut(&mut self, block: u32) -> &mut [u8] {
        let at = block as usize * self.block_bytes;
        let bytes: &mut [u8] = bytemuck::cast_slice_mut(&mut self.words);
        &mut bytes[at..at + self.block_bytes]
    }

    /// Makes the checksum of a block right again.
    pub(crate) fn seal(&mut self, block: u32) {
        let bytes = self.get_mut(block);
        let crc = checksum(&bytes[4..]);
        bytes[..4].copy_from_slice(&crc.to_le_bytes());
    }
}

enum Tree {
    Leaf(Vec<Item>),
    Node { axes: [u8; 3], slots: [Option<std::boxed::Box<Tree>>; 8] },
}

pub(crate) fn bounds(item: &Item) -> Aabb {
    match item.0 {
        Primitive::Triangle { vertices, .. } => Aabb::of_triangle(vertices),
        Primitive::Sphere { center, radius, .. } => Aabb::of_sphere(center, radius),
    }
}

impl Tree {
    fn bounds(&self) -> Aabb {
        match self {
            Self::Leaf(items) => items.iter().map(bounds).fold(Aabb::EMPTY, Aabb::union),
            Self::Node { slots, .. } => {
                slots.iter().flatten().map(|t| t.bounds()).fold(Aabb::EMPTY, Aabb::union)
            }
        }
    }

    /// `leaf`: most items of a leaf; such a leaf never needs more than four records.
    fn build(items: Vec<Item>, leaf: usize) -> Self {
        if items.len() <= leaf {
            return Self::Leaf(items);
        }
        let mut axes = [0; 3];
        let mut parts = std::vec![items];
        for axis in &mut axes {
            let longest = longest(&parts);
            *axis = longest as u8;
            parts = parts.into_iter().flat_map(|part| halves(part, longest)).collect();
        }
        let mut slots = [const { None }; 8];
        for (slot, part) in slots.iter_mut().zip(parts) {
            if !part.is_empty() {
                *slot = Some(std::boxed::Box::new(Self::build(part, leaf)));
            }
        }
        Self::Node { axes, slots }
    }
}

fn longest(parts: &[Vec<Item>]) -> usize {
    let whole = parts.iter().flatten().map(bounds).fold(Aabb::EMPTY, Aabb::union);
    let e = (whole.max - whole.min).to_array();
    let mut best = 0;
    for axis in 1..3 {
        // Halved parts make the next axis come first.
        if e[axis] > e[best] {
            best = axis;
        }
    }
    let cuts = parts.len().trailing_zeros() as usize;
    (best + cuts) % 3
}

fn halves(mut part: Vec<Item>, axis: usize) -> [Vec<Item>; 2] {
    part.sort_by(|a, b| {
        bounds(a).center().to_array()[axis].total_cmp(&bounds(b).center().to_array()[axis])
    });
    let upper = part.split_off(part.len().div_ceil(2));
    [part, upper]
}

/// One subtree of a block, under way.
struct Piece<'a> {
    root: &'a Tree,
    /// The block that refers to it, and the reference there.
    from: Option<(usize, usize)>,
}

#[derive(Default)]
struct Draft {
    nodes: Vec<Node>,
    boxes: Vec<[Aabb; 8]>,
    records: Vec<Record>,
    vertices: Vec<[f32; 3]>,
    normals: Vec<u32>,
    refs: Vec<Ref>,
    smooth: bool,
}

impl Draft {
    fn bytes(&self) -> usize {
        64 + size_of::<Node>() * self.nodes.len()
            + 16 * self.records.len()
            + (12 + if self.smooth { 4 } else { 0 }) * self.vertices.len()
            + 8 * self.refs.len()
            + 12
    }

    /// What a leaf adds at most: no vertex is shared.
    fn leaf_bytes(&self, items: usize) -> usize {
        16 * items + 16 * 3 * items
    }

    fn leaf(&mut self, items: &[Item]) -> Child {
        let at = self.records.len() as u16;
        let mut rest = items.to_vec();
        rest.sort_by_key(|i| (i.1, matches!(i.0, Primitive::Sphere { .. })));
        let mut rest = rest.as_slice();
        while let Some(head) = rest.first() {
            let alike = |i: &&Item| {
                i.1 == head.1
                    && matches!(i.0, Primitive::Sphere { .. })
                        == matches!(head.0, Primitive::Sphere { .. })
            };
            let count = rest.iter().take_while(alike).count().min(RECORD_PRIMITIVES);
            self.record(&rest[..count]);
            rest = &rest[count..];
        }
        // From the first record on, for now.
        Child::Leaf { at, count: self.records.len() as u16 - at }
    }

    fn record(&mut self, items: &[Item]) {
        let base = self.vertices.len() as u16;
        let mut record = Record { index: [[0; 3]; 4], base, material: items[0].1 };
        for (index, item) in record.index.iter_mut().zip(items) {
            let at = (self.vertices.len() as u16 - base) as u8;
            match item.0 {
                Primitive::Triangle { vertices, normals } => {
                    *index = [at, at + 1, at + 2];
                    self.vertices.extend(vertices.map(|v| v.to_array()));
                    self.normals.extend(normals.unwrap_or([crate::block::octahedral::NONE; 3]));
                }
                Primitive::Sphere { center, radius, inward } => {
                    *index = [at, at + 1, at];
                    self.vertices.push(center.to_array());
                    self.vertices.push([radius, f32::from(u8::from(inward)), 0.0]);
                    self.normals.extend([crate::block::octahedral::NONE; 2]);
                    record.base |= RECORD_SPHERES;
                }
            }
        }
        self.records.push(record);
    }
}

/// Writes a scene into blocks. `leaf` is the most items of a leaf, 1 to 4; `nodes_max` the most
/// nodes of a block, to make many.
pub(crate) fn write(items: &[Item], block_bytes: usize, leaf: usize, nodes_max: usize) -> Blocks {
    let smooth = items.iter().any(|i| matches!(i.0, Primitive::Triangle { normals: Some(_), .. }));
    let root = match Tree::build(items.to_vec(), leaf) {
        leaf @ Tree::Leaf(_) => {
            let mut slots = [const { None }; 8];
            slots[5] = Some(std::boxed::Box::new(leaf));
            Tree::Node { axes: [0, 1, 2], slots }
        }
        node @ Tree::Node { .. } => node,
    };
    let mut drafts: Vec<Draft> = std::vec![];
    let mut pieces = std::collections::VecDeque::from([Piece { root: &root, from: None }]);
    while let Some(piece) = pieces.pop_front() {
        let new = match (drafts.last(), piece.from) {
            (Some(last), Some((parent, _))) => {
                parent + 1 >= drafts.len()
                    || last.nodes.len() >= nodes_max
                    || last.bytes() + size_of::<Node>() + 8 * 8 + 8 * last.leaf_bytes(leaf)
                        > block_bytes
            }
            _ => true,
        };
        if new {
            drafts.push(Draft { smooth, ..Draft::default() });
        }
        let block = drafts.len() - 1;
        let node = drafts[block].nodes.len() as u16;
        if let Some((parent, index)) = piece.from {
            drafts[parent].refs[index] = Ref { block: block as u32, node, _zero: 0 };
        }
        fill(&mut drafts[block], block, piece.root, (block_bytes, leaf, nodes_max), &mut pieces);
    }
    let mut blocks =
        Blocks { words: std::vec![[0; 64]; drafts.len() * block_bytes / 1024], block_bytes };
    let mut nesting = std::vec![1_u16; drafts.len()];
    for (i, draft) in drafts.iter().enumerate().rev() {
        for r in &draft.refs {
            nesting[i] = nesting[i].max(nesting[r.block as usize] + 1);
        }
        encode(draft, i as u32, nesting[i], blocks.get_mut(i as u32));
        blocks.seal(i as u32);
    }
    blocks
}

/// Adds a subtree to a block, breadth first, as far as it has room; what has none becomes a piece.
fn fill<'a>(
    draft: &mut Draft,
    block: usize,
    root: &'a Tree,
    (block_bytes, leaf, nodes_max): (usize, usize, usize),
    pieces: &mut std::collections::VecDeque<Piece<'a>>,
) {
    let mut todo = std::collections::VecDeque::from([root]);
    draft.nodes.push(Node::EMPTY);
    draft.boxes.push([Aabb::EMPTY; 8]);
    let mut index = draft.nodes.len() - 1;
    // Room that the nodes already promised may need for references and leaves.
    let room = 8 * (8 + draft.leaf_bytes(leaf));
    while let Some(tree) = todo.pop_front() {
        let Tree::Node { axes, slots } = tree else { unreachable!() };
        let mut node = Node::EMPTY;
        for (slot, child) in slots.iter().enumerate() {
            let Some(child) = child else { continue };
            draft.boxes[index][slot] = child.bounds();
            let code = match &**child {
                Tree::Leaf(items) => draft.leaf(items),
                node @ Tree::Node { .. } => {
                    let open = todo.len() + 2;
                    let more = draft.bytes() + size_of::<Node>() + open * room <= block_bytes
                        && draft.nodes.len() < nodes_max;
                    if more {
                        draft.nodes.push(Node::EMPTY);
                        draft.boxes.push([Aabb::EMPTY; 8]);
                        todo.push_back(node);
                        Child::Node(draft.nodes.len() as u16 - 1)
                    } else {
                        draft.refs.push(Ref { block: 0, node: 0, _zero: 0 });
                        pieces.push_back(Piece {
                            root: node,
                            from: Some((block, draft.refs.len() - 1)),
                        });
                        Child::Ref(draft.refs.len() as u16 - 1)
                    }
                }
            };
            node.child[slot] = code.encode();
        }
        node.order = [0, 1, 2, 3].map(|signs| order(*axes, signs));
        draft.nodes[index] = node;
        index = draft.nodes.len() - todo.len();
    }
}

/// Children front to back for rays that descend the axes of these bits.
fn order([a0, a1, a2]: [u8; 3], signs: u8) -> u32 {
    let descends = |axis: u8| signs >> axis & 1;
    let flip = descends(a0) << 2 | descends(a1) << 1 | descends(a2);
    order_of([0, 1, 2, 3, 4, 5, 6, 7].map(|place: u8| place ^ flip))
}

fn encode(draft: &Draft, block: u32, nesting: u16, bytes: &mut [u8]) {
    assert!(draft.bytes() <= bytes.len(), "{} bytes", draft.bytes());
    let whole = draft.boxes.iter().flatten().copied().fold(Aabb::EMPTY, Aabb::union);
    let axes = [0, 1, 2].map(|a| (whole.min.to_array()[a], whole.max.to_array()[a]));
    let scale = axes.map(|(lo, hi)| {
        let mut scale = 2.0_f32.powi(-80);
        while f64::from(lo) + f64::from(scale) * 65535.0 < f64::from(hi) {
            scale *= 2.0;
        }
        scale
    });
    let mut nodes = draft.nodes.clone();
    for (node, boxes) in nodes.iter_mut().zip(&draft.boxes) {
        for (slot, own) in boxes.iter().enumerate().filter(|(_, b)| !b.is_empty()) {
            for a in 0..3 {
                let (origin, scale) = (f64::from(axes[a].0), f64::from(scale[a]));
                let steps = |v: f32| (f64::from(v) - origin) / scale;
                node.lo[a][slot] = steps(own.min.to_array()[a]).floor() as u16;
                node.hi[a][slot] = steps(own.max.to_array()[a]).ceil() as u16;
                let at = |q: u16| origin + scale * f64::from(q);
                assert!(at(node.lo[a][slot]) <= f64::from(own.min.to_array()[a]));
                assert!(at(node.hi[a][slot]) >= f64::from(own.max.to_array()[a]));
            }
        }
    }
    let header = BlockHeader {
        crc: 0,
        block,
        origin: axes.map(|a| a.0),
        scale,
        nodes: nodes.len() as u16,
        records: draft.records.len() as u16,
        vertices: draft.vertices.len() as u16,
        refs: draft.refs.len() as u16,
        flags: if draft.smooth { FLAG_NORMALS } else { 0 },
        height: crate::block::format::DEPTH_MAX as u16,
        nesting,
        _zero: [0; 9],
    };
    let mut at = 0_usize;
    let mut put = |part: &[u8], align: usize| {
        at = at.next_multiple_of(align);
        bytes[at..at + part.len()].copy_from_slice(part);
        at += part.len();
    };
    put(bytemuck::bytes_of(&header), 4);
    put(bytemuck::cast_slice(&draft.vertices), 4);
    if draft.smooth {
        put(bytemuck::cast_slice(&draft.normals), 4);
    }
    put(bytemuck::cast_slice(&draft.refs), 4);
    put(bytemuck::cast_slice(&draft.records), 16);
    let records_at = (at - size_of_val(draft.records.as_slice())) / 16;
    for (to, node) in bytes.rchunks_exact_mut(size_of::<Node>()).zip(&mut nodes) {
        for child in &mut node.child {
            if let Child::Leaf { at, count } = Child::decode(*child) {
                *child = Child::Leaf { at: at + records_at as u16, count }.encode();
            }
        }
        to.copy_from_slice(bytemuck::bytes_of(node));
    }
}

/// A triangle of three points.
pub(crate) fn triangle(a: [f32; 3], b: [f32; 3], c: [f32; 3], material: u16) -> Item {
    let vertices = [a, b, c].map(Vec3::from_array);
    (Primitive::Triangle { vertices, normals: None }, material)
}
