//! The bytes of blocks.

use bytemuck::{bytes_of, cast_slice};
use kiloray_core::block::checksum;
use kiloray_core::block::format::{
    BlockHeader, Child, FLAG_NORMALS, Node as StoredNode, Record, Ref,
};
use rayon::prelude::*;

use super::bounds::Bounds;
use super::layout::{Layout, Source};
use super::pack::Blocks;
use super::surfaces::position;
use super::tree::{Kid, Node};

/// Levels and blocks below each node, itself included.
#[derive(Debug, Clone, Copy, Default)]
struct Below {
    height: u16,
    nesting: u16,
}

/// What the blocks hold in all.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct Totals {
    pub(crate) records: u64,
    pub(crate) vertices: u64,
    pub(crate) refs: u64,
    pub(crate) height: u16,
    pub(crate) nesting: u16,
}

impl Totals {
    fn with(self, other: Self) -> Self {
        Self {
            records: self.records + other.records,
            vertices: self.vertices + other.vertices,
            refs: self.refs + other.refs,
            height: self.height.max(other.height),
            nesting: self.nesting.max(other.nesting),
        }
    }
}

/// Writes all blocks into `bytes`, which is zero and as long as they are.
pub(crate) fn emit(
    source: Source<'_>,
    parents: &[u32],
    blocks: &Blocks,
    bytes: &mut [u8],
) -> Totals {
    let below = below(source.nodes, blocks);
    bytes
        .par_chunks_mut(source.block_bytes)
        .zip(&blocks.nodes)
        .enumerate()
        .map_init(Layout::default, |layout, (number, (bytes, nodes))| {
            layout.clear();
            for (i, &node) in nodes.iter().enumerate() {
                let parent = blocks.places.get(parents[node as usize] as usize);
                let inside = parent.is_some_and(|place| place.0 as usize == number);
                let fits = layout.try_add(source, node, inside);
                debug_assert!(fits && i + 1 == layout.nodes.len(), "it fitted when it was packed");
            }
            block(source, blocks, &below, number as u32, layout, bytes)
        })
        .reduce(Totals::default, Totals::with)
}

fn below(nodes: &[Node], blocks: &Blocks) -> Vec<Below> {
    let mut below = vec![Below::default(); nodes.len()];
    for (index, node) in nodes.iter().enumerate().rev() {
        let mut here = Below { height: 1, nesting: 1 };
        for (_, kid) in node.nodes() {
            let other = u16::from(blocks.places[kid as usize].0 != blocks.places[index].0);
            let kid = below[kid as usize];
            here.height = here.height.max(kid.height + 1);
            here.nesting = here.nesting.max(kid.nesting + other);
        }
        below[index] = here;
    }
    below
}

fn block(
    source: Source<'_>,
    blocks: &Blocks,
    below: &[Below],
    number: u32,
    layout: &Layout,
    bytes: &mut [u8],
) -> Totals {
    let frame = Frame::of(layout.nodes.iter().map(|&node| &source.nodes[node as usize]));
    let mut nodes = Vec::with_capacity(layout.nodes.len());
    let mut refs = Vec::with_capacity(layout.outside);
    let mut leaves = layout.leaves.iter();
    let records_at = layout.records_at() as u16;
    let mut header = BlockHeader {
        crc: 0,
        block: number,
        origin: frame.origin,
        scale: frame.scale,
        nodes: layout.nodes.len() as u16,
        records: layout.records.len() as u16,
        vertices: layout.vertices.len() as u16,
        refs: layout.outside as u16,
        flags: if layout.normals { FLAG_NORMALS } else { 0 },
        height: 0,
        nesting: 0,
        _zero: [0; 9],
    };
    for &index in &layout.nodes {
        let node = &source.nodes[index as usize];
        let mut stored = StoredNode::EMPTY;
        for (slot, &kid) in node.kids.iter().enumerate() {
            let child = match kid {
                Kid::Empty => continue,
                Kid::Node(kid) => match blocks.places[kid as usize] {
                    (block, index) if block == number => Child::Node(index),
                    (block, node) => {
                        refs.push(Ref { block, node, _zero: 0 });
                        Child::Ref(refs.len() as u16 - 1)
                    }
                },
                Kid::Leaf { .. } => {
                    let (first, count) = leaves.next().copied().unwrap_or_default();
                    Child::Leaf { at: records_at + first, count }
                }
            };
            stored.child[slot] = child.encode();
            frame.quantise(&node.bounds[slot], &mut stored, slot);
        }
        stored.order = node.order;
        nodes.push(stored);
        header.height = header.height.max(below[index as usize].height);
        header.nesting = header.nesting.max(below[index as usize].nesting);
    }
    let vertices = layout.vertices.iter().map(|&v| &source.surfaces.vertices[v as usize]);
    let positions: Vec<[f32; 3]> = vertices.clone().map(position).collect();
    let normals: Vec<u32> =
        if layout.normals { vertices.map(|v| v.1).collect() } else { Vec::new() };
    let mut at = size_of::<BlockHeader>();
    let mut put = |part: &[u8], align: usize| {
        at = at.next_multiple_of(align);
        bytes[at..at + part.len()].copy_from_slice(part);
        at += part.len();
    };
    put(cast_slice(&positions), 4);
    put(cast_slice(&normals), 4);
    put(cast_slice(&refs), 4);
    put(cast_slice(&layout.records), size_of::<Record>());
    for (to, node) in bytes.rchunks_exact_mut(size_of::<StoredNode>()).zip(&nodes) {
        to.copy_from_slice(bytes_of(node));
    }
    bytes[..size_of::<BlockHeader>()].copy_from_slice(bytes_of(&header));
    header.crc = checksum(&bytes[4..]);
    bytes[..4].copy_from_slice(&header.crc.to_le_bytes());
    Totals {
        records: layout.records.len() as u64,
        vertices: layout.vertices.len() as u64,
        refs: refs.len() as u64,
        height: header.height,
        nesting: header.nesting,
    }
}

/// The frame of a block.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Frame {
    pub(crate) origin: [f32; 3],
    pub(crate) scale: [f32; 3],
}

impl Frame {
    const STEPS: f64 = 65535.0;
    const EXPONENT_MIN: i32 = -80;

    fn of<'a>(nodes: impl Iterator<Item = &'a Node>) -> Self {
        let mut all = Bounds::EMPTY;
        for bounds in nodes.flat_map(|node| &node.bounds) {
            all.grow(&bounds.0);
        }
        let (lo, hi) = all.ends();
        Self::over(lo, hi)
    }

    /// The finest frame that reaches from `lo` to `hi`.
    ///
    /// The origin is a multiple of the step, and the step at least 2⁻²² of the greatest coordinate:
    /// so `origin + scale * q` is exact in f32 for every `q`, and there is nothing to round.
    pub(crate) fn over(lo: [f32; 3], hi: [f32; 3]) -> Self {
        let mut frame = Self { origin: [0.0; 3], scale: [1.0; 3] };
        for axis in 0..3 {
            let (lo, hi) = (f64::from(lo[axis]), f64::from(hi[axis]));
            let extent = exponent((hi - lo) / Self::STEPS);
            let magnitude = exponent(lo.abs().max(hi.abs()));
            let mut e = extent.max(magnitude - 22).max(Self::EXPONENT_MIN);
            let (origin, step) = loop {
                let step = f64::from_bits(((e + 1023) as u64) << 52);
                let origin = (lo / step).floor();
                if (hi / step).ceil() - origin <= Self::STEPS {
                    break (origin * step, step);
                }
                e += 1;
            };
            frame.origin[axis] = origin as f32;
            frame.scale[axis] = step as f32;
        }
        frame
    }

    /// Rounds a box outward.
    pub(crate) fn quantise(&self, bounds: &Bounds, node: &mut StoredNode, slot: usize) {
        let (lo, hi) = (bounds.lo(), bounds.hi());
        for axis in 0..3 {
            let step = f64::from(self.scale[axis]);
            // Divisions by a power of two are exact; a difference of coordinates need not be.
            let origin = f64::from(self.origin[axis]) / step;
            node.lo[axis][slot] = ((f64::from(lo[axis]) / step).floor() - origin) as u16;
            node.hi[axis][slot] = ((f64::from(hi[axis]) / step).ceil() - origin) as u16;
        }
    }
}

/// The exponent of the least power of two that is not below `v`; very low for 0.
fn exponent(v: f64) -> i32 {
    let bits = v.to_bits();
    let above = i32::from(bits & ((1 << 52) - 1) != 0);
    (bits >> 52 & 0x7ff) as i32 - 1023 + above
}
