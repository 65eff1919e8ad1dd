//! The tree in treelets.
//!
//! Aila & Karras 2010, "Architecture considerations for tracing incoherent rays", section 4.1: from
//! the bottom up, each node grows a treelet of which it is the root, by the child of greatest area
//! per byte, and keeps the size at which the areas of all treelet roots at and below it are least.
//! Sizes here are exact: a vertex that the treelet has already costs nothing.

use kiloray_core::block::format::{
    BlockHeader, Node as StoredNode, RECORD_PRIMITIVES, Record, Ref,
};

use super::layout::{PADDING_MAX, Source};

/// The cut: for each node, whether a treelet begins there.
#[derive(Debug)]
pub(crate) struct Treelets {
    /// In the order of their roots.
    pub(crate) all: Vec<Treelet>,
    /// The nodes of treelet after treelet, each in increasing order.
    pub(crate) nodes: Vec<u32>,
}

/// A treelet.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Treelet {
    /// Where its nodes end in [`Treelets::nodes`]; the first is its root.
    pub(crate) end: u32,
    /// Bytes that it takes in a block of its own, header and padding aside.
    pub(crate) bytes: u32,
}

/// What the cut knows of a node.
#[derive(Debug, Clone, Copy, Default)]
struct Known {
    area: f32,
    /// Without vertices.
    bytes: u32,
    /// Of all at and below it, vertices not shared.
    subtree_bytes: u64,
    /// Where its vertices end in the list of all.
    vertices_end: u32,
    /// Least sum of areas of treelet roots at and below it.
    cost: f32,
    /// Nodes of the treelet that has it, less one.
    steps: u32,
}

/// Sizes of all nodes, and the vertices of each without repetition.
fn know(source: Source<'_>) -> (Vec<Known>, Vec<u32>) {
    let mut known = vec![Known::default(); source.nodes.len()];
    let mut vertices = Vec::new();
    for (node, known) in source.nodes.iter().zip(&mut known) {
        let begin = vertices.len();
        let mut records = 0;
        for (_, first, count) in node.leaves() {
            let range = first as usize..(first + count) as usize;
            vertices.extend(source.surfaces.corners[range.clone()].iter().flatten());
            let groups = source.surfaces.items[range].chunk_by(|a, b| a.group == b.group);
            records += groups.map(|group| group.len().div_ceil(RECORD_PRIMITIVES)).sum::<usize>();
        }
        vertices[begin..].sort_unstable();
        let mut len = begin;
        for i in begin..vertices.len() {
            if i == begin || vertices[i] != vertices[len - 1] {
                vertices[len] = vertices[i];
                len += 1;
            }
        }
        vertices.truncate(len);
        known.vertices_end = len as u32;
        known.area = node.area();
        known.bytes = (size_of::<StoredNode>() + records * size_of::<Record>()) as u32;
        known.subtree_bytes =
            u64::from(known.bytes) + ((len - begin) * vertex_bytes(source)) as u64;
    }
    for index in (0..known.len()).rev() {
        let below = source.nodes[index].nodes();
        known[index].subtree_bytes +=
            below.map(|(_, kid)| known[kid as usize].subtree_bytes).sum::<u64>();
    }
    (known, vertices)
}

fn vertex_bytes(source: Source<'_>) -> usize {
    if source.surfaces.normals { 16 } else { 12 }
}

/// What cuts a tree, as often as it is asked to.
pub(crate) struct Cutter<'a> {
    source: Source<'a>,
    known: Vec<Known>,
    /// Of each node without repetition, node after node.
    vertices: Vec<u32>,
    waste: f32,
    /// The generation that last held each vertex.
    seen: Vec<u32>,
    generation: u32,
    /// Nodes below the treelet.
    cut: Vec<u32>,
    /// Nodes of the treelet.
    taken: Vec<u32>,
    /// Bytes that are left in its block.
    left: i64,
}

/// Bytes of a block that treelets can have.
fn room(source: Source<'_>) -> i64 {
    (source.block_bytes - size_of::<BlockHeader>() - PADDING_MAX) as i64
}

/// The part of a block that is left when it has as many treelets of so many bytes as go in.
fn wasted(bytes: i64, room: i64) -> f32 {
    let bytes = bytes.max(1);
    1.0 - (room / bytes * bytes) as f32 / room as f32
}

impl<'a> Cutter<'a> {
    /// Looks at all nodes.
    pub(crate) fn new(source: Source<'a>) -> Self {
        let (known, vertices) = know(source);
        Self {
            source,
            known,
            vertices,
            waste: 0.0,
            seen: vec![0; source.surfaces.vertices.len()],
            generation: 0,
            cut: Vec::new(),
            taken: Vec::new(),
            left: 0,
        }
    }

    /// Cuts the tree. A root's area counts more by `waste` times the part of a block that treelets of its size leave empty. `done` hears how
    /// many nodes have been seen.
    pub(crate) fn cut(&mut self, waste: f32, done: &mut dyn FnMut(u64)) -> Treelets {
        self.waste = waste;
        let count = self.known.len();
        for index in (0..count).rev() {
            let (cost, steps) = self.grow(index as u32, u32::MAX);
            let known = &mut self.known[index];
            (known.cost, known.steps) = (cost, steps);
            if index % (1 << 12) == 0 {
                done((count - index) as u64);
            }
        }
        let mut treelets = Treelets { all: Vec::new(), nodes: Vec::new() };
        let mut is_root = vec![false; count];
        if let Some(root) = is_root.first_mut() {
            *root = true;
        }
        for index in 0..count {
            if is_root[index] {
                self.grow(index as u32, self.known[index].steps);
                self.taken.sort_unstable();
                treelets.nodes.extend_from_slice(&self.taken);
                let bytes = (room(self.source) - self.left) as u32;
                treelets.all.push(Treelet { end: treelets.nodes.len() as u32, bytes });
                for below in &self.cut {
                    is_root[*below as usize] = true;
                }
            }
        }
        treelets
    }

    /// Grows a treelet by at most `steps_max` nodes; returns the least cost and after how many
    /// steps it was. `taken` and `cut` are the last ones.
    fn grow(&mut self, root: u32, steps_max: u32) -> (f32, u32) {
        self.generation += 1;
        self.cut.clear();
        self.taken.clear();
        self.left = room(self.source);
        let mut below = self.take(root, 0.0);
        let area = self.known[root as usize].area;
        let (room, waste) = (room(self.source), self.waste);
        let price = |left: i64| area * (1.0 + waste * wasted(room - left, room));
        let mut best = (price(self.left) + below, 0);
        let mut steps = 0;
        while steps < steps_max {
            let Some(at) = self.choose() else { break };
            let next = self.cut.swap_remove(at);
            below = self.take(next, below - self.known[next as usize].cost);
            self.left += size_of::<Ref>() as i64;
            steps += 1;
            let cost = price(self.left) + below;
            if cost <= best.0 {
                best = (cost, steps);
            }
        }
        best
    }

    /// The member of the cut with the most area per byte, of those that fit.
    fn choose(&self) -> Option<usize> {
        let left = self.left;
        let mut best = None;
        for (at, &node) in self.cut.iter().enumerate() {
            let of = &self.known[node as usize];
            if i64::from(of.bytes) > left {
                continue;
            }
            let price = (of.subtree_bytes as i64).min(left).max(1) as f32;
            let score = of.area / price;
            if best.is_none_or(|(least, _)| score > least) && self.bytes(node) <= left {
                best = Some((score, at));
            }
        }
        best.map(|(_, at)| at)
    }

    /// Bytes that a node would add; the reference to it is saved.
    fn bytes(&self, node: u32) -> i64 {
        let fresh = self.vertices_of(node);
        let fresh = fresh.iter().filter(|&&v| self.seen[v as usize] != self.generation).count();
        let below = self.source.nodes[node as usize].nodes().count();
        let bytes = i64::from(self.known[node as usize].bytes)
            + (fresh * vertex_bytes(self.source)) as i64
            + (below * size_of::<Ref>()) as i64;
        bytes - if self.taken.is_empty() { 0 } else { size_of::<Ref>() as i64 }
    }

    /// Moves a node into the treelet; returns the cost of the cut, from what it was without it.
    fn take(&mut self, node: u32, mut below: f32) -> f32 {
        for i in self.range(node) {
            let seen = &mut self.seen[self.vertices[i] as usize];
            if *seen != self.generation {
                *seen = self.generation;
                self.left -= vertex_bytes(self.source) as i64;
            }
        }
        self.left -= i64::from(self.known[node as usize].bytes);
        for (_, kid) in self.source.nodes[node as usize].nodes() {
            self.left -= size_of::<Ref>() as i64;
            self.cut.push(kid);
            below += self.known[kid as usize].cost;
        }
        self.taken.push(node);
        below
    }

    fn range(&self, node: u32) -> std::ops::Range<usize> {
        let node = node as usize;
        let begin = if node == 0 { 0 } else { self.known[node - 1].vertices_end as usize };
        begin..self.known[node].vertices_end as usize
    }

    fn vertices_of(&self, node: u32) -> &[u32] {
        &self.vertices[self.range(node)]
    }
}
