//! What goes where in one block.
//!
//! Nodes are added one at a time, parents before children; the layout knows at every moment how
//! many bytes the block takes, with a reference for each child that is not here (yet).

use std::ops::Range;

use kiloray_core::block::format::{
    BlockHeader, Node as StoredNode, RECORD_PRIMITIVES, RECORD_SPHERES, Record, Ref,
};
use kiloray_core::block::octahedral;

use super::surfaces::{GROUP_SPHERE, Surfaces};
use super::tree::Node;

/// Padding before the records of a block, at most.
pub(crate) const PADDING_MAX: usize = size_of::<Record>() - size_of::<u32>();
/// Vertices that the byte indices of a record reach.
const WINDOW: usize = 256;

/// What a layout is made from.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Source<'a> {
    pub(crate) nodes: &'a [Node],
    pub(crate) surfaces: &'a Surfaces,
    pub(crate) block_bytes: usize,
}

/// One block that fills up.
#[derive(Debug, Default)]
pub(crate) struct Layout {
    /// Nodes of the tree, by index in the block.
    pub(crate) nodes: Vec<u32>,
    /// The first record of each leaf, in the order of nodes and slots.
    pub(crate) leaves: Vec<(u16, u16)>,
    pub(crate) records: Vec<Record>,
    /// Merged vertices, by index in the block.
    pub(crate) vertices: Vec<u32>,
    /// Children that are not here: each takes a reference.
    pub(crate) outside: usize,
    pub(crate) normals: bool,
    places: Places,
}

/// Where a layout can go back to.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Mark {
    nodes: usize,
    leaves: usize,
    records: usize,
    vertices: usize,
    outside: usize,
    normals: bool,
    undo: usize,
}

impl Layout {
    /// Bytes of the block so far.
    pub(crate) fn bytes(&self) -> usize {
        (self.records_at() + self.records.len()) * size_of::<Record>()
            + self.nodes.len() * size_of::<StoredNode>()
    }

    /// Where its records begin, in records.
    pub(crate) fn records_at(&self) -> usize {
        let vertex = if self.normals { 16 } else { 12 };
        let before = size_of::<BlockHeader>()
            + self.vertices.len() * vertex
            + self.outside * size_of::<Ref>();
        before.div_ceil(size_of::<Record>())
    }

    pub(crate) fn mark(&self) -> Mark {
        Mark {
            nodes: self.nodes.len(),
            leaves: self.leaves.len(),
            records: self.records.len(),
            vertices: self.vertices.len(),
            outside: self.outside,
            normals: self.normals,
            undo: self.places.undo.len(),
        }
    }

    pub(crate) fn go_back(&mut self, mark: Mark) {
        self.nodes.truncate(mark.nodes);
        self.leaves.truncate(mark.leaves);
        self.records.truncate(mark.records);
        self.vertices.truncate(mark.vertices);
        self.outside = mark.outside;
        self.normals = mark.normals;
        self.places.go_back(mark.undo);
    }

    pub(crate) fn clear(&mut self) {
        self.nodes.clear();
        self.leaves.clear();
        self.records.clear();
        self.vertices.clear();
        self.outside = 0;
        self.normals = false;
        self.places.clear();
    }

    /// Adds a node and its leaves. `inside` says that its parent is in this block. `false`, and
    /// nothing is changed, if the block would be too long.
    pub(crate) fn try_add(&mut self, source: Source<'_>, index: u32, inside: bool) -> bool {
        let mark = self.mark();
        let node = &source.nodes[index as usize];
        self.nodes.push(index);
        if inside {
            self.outside -= 1;
        }
        self.outside += node.nodes().count();
        for (_, first, count) in node.leaves() {
            self.leaf(source.surfaces, first as usize..(first + count) as usize);
        }
        let fits = self.bytes() <= source.block_bytes;
        if !fits {
            self.go_back(mark);
        }
        fits
    }

    fn leaf(&mut self, surfaces: &Surfaces, range: Range<usize>) {
        let first = self.records.len();
        let mut at = range.start;
        for group in surfaces.items[range].chunk_by(|a, b| a.group == b.group) {
            for part in group.chunks(RECORD_PRIMITIVES) {
                self.record(surfaces, part[0].group, &surfaces.corners[at..at + part.len()]);
                at += part.len();
            }
        }
        self.leaves.push((first as u16, (self.records.len() - first) as u16));
    }

    fn record(&mut self, surfaces: &Surfaces, group: u32, corners: &[[u32; 3]]) {
        // The vertices of the record without repetition, and where each of its corners is among them.
        let mut ids = [0; 3 * RECORD_PRIMITIVES];
        let mut len = 0;
        let mut corner = [[0; 3]; RECORD_PRIMITIVES];
        for (corners, corner) in corners.iter().zip(&mut corner) {
            for (&id, at) in corners.iter().zip(corner) {
                *at = ids[..len].iter().position(|&other| other == id).unwrap_or_else(|| {
                    ids[len] = id;
                    len += 1;
                    len - 1
                });
            }
        }
        let places = self.window(surfaces, &ids[..len]);
        let base = places[..len].iter().copied().min().unwrap_or(0);
        let mut index = [[0; 3]; RECORD_PRIMITIVES];
        for (index, corner) in index.iter_mut().zip(&corner[..corners.len()]) {
            *index = corner.map(|at| (places[at] - base) as u8);
        }
        let spheres = if group & GROUP_SPHERE != 0 { RECORD_SPHERES } else { 0 };
        self.records.push(Record { index, base: base as u16 | spheres, material: group as u16 });
    }

    /// Puts the vertices within one window: old ones where they are, if that is near enough.
    fn window(&mut self, surfaces: &Surfaces, ids: &[u32]) -> [usize; 3 * RECORD_PRIMITIVES] {
        const NEW: usize = usize::MAX;
        let mut places = [NEW; 3 * RECORD_PRIMITIVES];
        let places_ = &mut places[..ids.len()];
        for (place, &id) in places_.iter_mut().zip(ids) {
            *place = self.places.get(id).map_or(NEW, usize::from);
        }
        loop {
            let new = places_.iter().filter(|&&place| place == NEW).count();
            let old = || places_.iter().copied().filter(|&place| place != NEW);
            let (Some(min), Some(max)) = (old().min(), old().max()) else { break };
            let end = if new > 0 { self.vertices.len() + new } else { max + 1 };
            if end - min <= WINDOW {
                break;
            }
            // Too far apart: the farthest is stored again, at the end.
            for place in places_.iter_mut().filter(|place| **place == min) {
                *place = NEW;
            }
        }
        for (place, &id) in places_.iter_mut().zip(ids) {
            if *place == NEW {
                *place = self.vertices.len();
                self.places.insert(id, *place as u16);
                self.vertices.push(id);
                self.normals |= surfaces.vertices[id as usize].1 != octahedral::NONE;
            }
        }
        places
    }
}

/// The last place of each vertex: a small hash table that can go back.
#[derive(Debug, Default)]
struct Places {
    /// Vertex plus one, and its place.
    slots: Vec<(u32, u16)>,
    /// Slots as they were.
    undo: Vec<(u32, (u32, u16))>,
}

impl Places {
    /// More than twice the vertices that a block can hold, and a power of two.
    const SLOTS_MIN: usize = 256;

    fn find(&self, id: u32) -> usize {
        let mask = self.slots.len() - 1;
        let mut at = (id.wrapping_mul(0x9e37_79b1) >> 8) as usize & mask;
        while self.slots[at].0 != 0 && self.slots[at].0 != id + 1 {
            at = (at + 1) & mask;
        }
        at
    }

    fn get(&self, id: u32) -> Option<u16> {
        if self.slots.is_empty() {
            return None;
        }
        let (found, place) = self.slots[self.find(id)];
        (found != 0).then_some(place)
    }

    fn insert(&mut self, id: u32, place: u16) {
        if (self.undo.len() + 1) * 2 > self.slots.len() {
            self.grow();
        }
        let at = self.find(id);
        self.undo.push((at as u32, self.slots[at]));
        self.slots[at] = (id + 1, place);
    }

    /// Doubles the slots, and makes the log anew: in it, each insertion is known by its vertex.
    fn grow(&mut self) {
        let log: Vec<(u32, u16)> = {
            let mut redo = Vec::with_capacity(self.undo.len());
            for &(at, before) in self.undo.iter().rev() {
                redo.push(self.slots[at as usize]);
                self.slots[at as usize] = before;
            }
            redo.into_iter().rev().collect()
        };
        let len = (self.slots.len() * 2).max(Self::SLOTS_MIN);
        self.slots.clear();
        self.slots.resize(len, (0, 0));
        self.undo.clear();
        for (id, place) in log {
            let at = self.find(id - 1);
            self.undo.push((at as u32, self.slots[at]));
            self.slots[at] = (id, place);
        }
    }

    fn go_back(&mut self, len: usize) {
        while self.undo.len() > len {
            if let Some((at, before)) = self.undo.pop() {
                self.slots[at as usize] = before;
            }
        }
    }

    fn clear(&mut self) {
        self.go_back(0);
    }
}
