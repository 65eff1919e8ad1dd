//! The layout of a block and of a `.kilo` file. Little-endian throughout.
//!
//! # A block
//!
//! A block has the size that the file names: a power of two from 1 to 64 KiB. Offsets in bytes:
//!
//! | part | length | begins at |
//! | --- | --- | --- |
//! | [`BlockHeader`] | 64 | 0 |
//! | vertices, three `f32` each | 12 × `vertices` | 64 |
//! | shading normals, a [code](super::octahedral) for each vertex; only with [`FLAG_NORMALS`] | 4 × `vertices` | behind the vertices |
//! | [`Ref`]s | 8 × `refs` | behind the normals |
//! | [`Record`]s | 16 × `records` | behind the references, the next multiple of 16 |
//! | [`Node`]s, the last first | 128 × `nodes` | so that they end with the block |
//!
//! What lies between the parts is zero. So a node, the records of a leaf and a vertex are found by index, and the header is read for none of them; and sixteen bytes
//! can be read at any vertex.
//!
//! # The frame of a block
//!
//! Node boxes are 16-bit integers `q` in the block's own frame: the coordinate is
//! `origin + scale * q`, per axis, with `scale` a power of two. Lower bounds are rounded down,
//! upper bounds up, so that the box holds the *own* boxes of all primitives below it
//! (`geometry::Aabb::of_triangle`, `of_sphere`). A slot that is empty has the inverted box
//! `lo = 65535, hi = 0`. The compiler chooses `origin` a multiple of `scale`, and `scale` at least
//! 2⁻²² of the greatest coordinate, so that `origin + scale * q` is exact in f32.
//!
//! # Slots
//!
//! A [`Node`] has up to eight slots, in any order, and says in which order rays visit them: `order[i]` is for rays that descend the axes of
//! the bits of `i` (bit 0 x, bit 1 y) and not z; bits `3 k` to `3 k + 2` are the slot that is visited `k`th, and bits 24 to 31 zero. Rays
//! of the opposite signs visit them in the opposite order, so four words serve eight octants of directions. An order may be any permutation:
//! the compiler's is front to back.
//!
//! A child is 16 bits:
//!
//! | bits | meaning |
//! | --- | --- |
//! | 15 | zero |
//! | 14 = 1 | leaf: bits 0–11 where its records begin, in records (16 bytes) from the begin of the block; bits 12–13 their number less one |
//! | 14 = 0, 13–12 = 00 | node of this block: bits 0–11 its index |
//! | 14 = 0, 13–12 = 01 | reference: bits 0–11 the index of a [`Ref`] |
//! | 14 = 0, 13–12 = 11 | empty, bits 0–11 zero |
//!
//! A child node has a greater index than its parent: a block holds no cycle. A reference has a
//! greater block number than the block that holds it: a file holds none either.
//!
//! # Records
//!
//! A [`Record`] is up to four primitives of one material: byte triples of vertex indices, relative to
//! `base`. A triple of three equal bytes is an unused place, and comes last. With [`RECORD_SPHERES`]
//! set in `base` the triple of a sphere is: its centre; a vertex `(radius, 0, 0)`, or
//! `(radius, 1, 0)` for one that faces inward; and any third value, as long as not all three are equal. (The compiler's last zero is
//! negative, and centres have none, so that the two are never one vertex.)
//!
//! # The file
//!
//! [`FileHeader`], then the sections it names, each beginning at a multiple of 64 and apart from the blocks
//! in the order of the header, but for the tree of the lights, which lies behind the views if there is one; the blocks come last and begin at a multiple of the
//! block size (at most 4096). What lies between the last section and the first block is zero, and the file ends with
//! the last block: a changed byte is found anywhere, by a checksum or as a byte that is not zero.

use bytemuck::{Pod, Zeroable};

/// The first four bytes of a file.
pub const MAGIC: [u8; 4] = *b"KILO";
/// The version of this layout. A reader refuses any other.
pub const VERSION: u32 = 4;
/// Least size of a block.
pub const BLOCK_BYTES_MIN: usize = 1 << 10;
/// Greatest size of a block.
pub const BLOCK_BYTES_MAX: usize = 1 << 16;
/// Greatest depth of the tree in nodes, over all blocks: bounds every traversal stack.
pub const DEPTH_MAX: usize = 32;
/// In [`BlockHeader::flags`]: the block has shading normals.
pub const FLAG_NORMALS: u16 = 1;
/// In [`Record::base`]: the primitives are spheres; the other 15 bits are the base.
pub const RECORD_SPHERES: u16 = 0x8000;
/// Primitives in a record.
pub const RECORD_PRIMITIVES: usize = 4;
/// Records in a leaf, at most.
pub const LEAF_RECORDS_MAX: usize = 4;

/// The first 64 bytes of a block.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct BlockHeader {
    /// CRC-32 (ISO-HDLC) of all bytes of the block behind this field.
    pub crc: u32,
    /// The number of this block in its file.
    pub block: u32,
    /// Origin of the frame, scene coordinates.
    pub origin: [f32; 3],
    /// Size of one step of the frame: a power of two, from 2⁻⁸⁰ to 2¹.
    pub scale: [f32; 3],
    /// Number of [`Node`]s; at least 1.
    pub nodes: u16,
    /// Number of [`Record`]s, at most 4096.
    pub records: u16,
    /// Number of vertices.
    pub vertices: u16,
    /// Number of [`Ref`]s, at most 4096.
    pub refs: u16,
    /// [`FLAG_NORMALS`]; other bits are zero.
    pub flags: u16,
    /// Levels of nodes from the deepest root of the tree to the deepest leaf at or below this
    /// block: bounds what a traversal that enters here can stack. At most [`DEPTH_MAX`].
    pub height: u16,
    /// Greatest number of blocks on a path from this block to a leaf, this one included.
    pub nesting: u16,
    /// Zero.
    pub _zero: [u16; 9],
}

/// An inner node: up to eight children.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct Node {
    /// Lower bounds, by axis, by slot.
    pub lo: [[u16; 8]; 3],
    /// Upper bounds, by axis, by slot.
    pub hi: [[u16; 8]; 3],
    /// What is below, by slot.
    pub child: [u16; 8],
    /// In which order slots are visited: see [the slots of a node](self#slots).
    pub order: [u32; 4],
}

/// Up to four primitives of one material.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct Record {
    /// Vertex indices, relative to `base`.
    pub index: [[u8; 3]; RECORD_PRIMITIVES],
    /// Index of a vertex; [`RECORD_SPHERES`] marks spheres.
    pub base: u16,
    /// Index into the scene's material table.
    pub material: u16,
}

/// A node of another block.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct Ref {
    /// The number of the block.
    pub block: u32,
    /// The index of the node in it.
    pub node: u16,
    /// Zero.
    pub _zero: u16,
}

/// A child of a node, decoded.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Child {
    /// Nothing.
    Empty,
    /// A node of this block, by index.
    Node(u16),
    /// Records of this block.
    Leaf {
        /// Where the first begins, in records from the begin of the block.
        at: u16,
        /// How many: 1 to 4.
        count: u16,
    },
    /// A node of another block: index into the references.
    Ref(u16),
}

impl Child {
    /// The bits of no child.
    pub const EMPTY: u16 = Self::Empty.encode();

    /// Decodes 16 bits; bit 15 is ignored, and what is undefined is empty.
    #[inline(always)]
    #[must_use]
    pub const fn decode(bits: u16) -> Self {
        let index = bits & 0x0fff;
        if bits & 0x4000 != 0 {
            Self::Leaf { at: index, count: (bits >> 12 & 3) + 1 }
        } else {
            match bits >> 12 & 3 {
                0 => Self::Node(index),
                1 => Self::Ref(index),
                _ => Self::Empty,
            }
        }
    }

    /// The 16 bits.
    #[must_use]
    pub const fn encode(self) -> u16 {
        match self {
            Self::Empty => 0x3000,
            Self::Node(index) => index & 0x0fff,
            Self::Ref(index) => 0x1000 | index & 0x0fff,
            Self::Leaf { at, count } => 0x4000 | (count.wrapping_sub(1) & 3) << 12 | at & 0x0fff,
        }
    }
}

impl Node {
    /// A node without children.
    pub const EMPTY: Self = Self {
        lo: [[u16::MAX; 8]; 3],
        hi: [[0; 8]; 3],
        child: [Child::EMPTY; 8],
        order: [order_of([0, 1, 2, 3, 4, 5, 6, 7]); 4],
    };
}

/// The word of [`Node::order`] for slots that are visited in this order.
#[must_use]
pub const fn order_of(slots: [u8; 8]) -> u32 {
    let [a, b, c, d, e, f, g, h] = slots;
    let low =
        (a & 7) as u32 | ((b & 7) as u32) << 3 | ((c & 7) as u32) << 6 | ((d & 7) as u32) << 9;
    let high =
        (e & 7) as u32 | ((f & 7) as u32) << 3 | ((g & 7) as u32) << 6 | ((h & 7) as u32) << 9;
    low | high << 12
}

/// Whether a word of [`Node::order`] names each slot once, and nothing else.
#[inline(always)]
#[must_use]
pub const fn is_order(word: u32) -> bool {
    let mut named = 0_u32;
    let mut rest = word;
    let mut place = 0;
    while place < 8 {
        named |= 1 << (rest & 7);
        rest >>= 3;
        place += 1;
    }
    named == 0xff && rest == 0
}

/// The first bytes of a file.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct FileHeader {
    /// [`MAGIC`].
    pub magic: [u8; 4],
    /// [`VERSION`].
    pub version: u32,
    /// CRC-32 (ISO-HDLC) of the bytes from the next field to the end of the last section (blocks have their own).
    pub crc: u32,
    /// Size of a block.
    pub block_bytes: u32,
    /// Length of the file.
    pub file_bytes: u64,
    /// Number of blocks; at least 1, as a scene without surfaces has a root as well.
    pub blocks: u32,
    /// Index of the root node in block 0 is 0. Primitives in the file, for information.
    pub primitives: u32,
    /// Where the first block begins.
    pub blocks_at: u64,
    /// Where the materials begin, and how many there are ([`crate::scene::Material`]).
    pub materials: Section,
    /// Lights ([`crate::scene::Light`]).
    pub lights: Section,
    /// Views ([`crate::scene::View`]).
    pub views: Section,
    /// What the scene needs, one entry ([`crate::scene::Needs`]).
    pub needs: Section,
    /// From scene coordinates to the input's ([`crate::scene::Frame`]).
    pub frame: crate::scene::Frame,
    /// Lower corner of the scene, scene coordinates.
    pub lo: [f32; 3],
    /// Upper corner.
    pub hi: [f32; 3],
    /// The tree of the lights, between views and needs ([`crate::scene::LightNode`]); zeros if they have none.
    pub light_tree: Section,
    /// Zero.
    pub _zero: [u32; 2],
}

/// A table of the file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct Section {
    /// Offset from the start of the file: a multiple of 64.
    pub at: u32,
    /// Number of entries.
    pub len: u32,
}

const _: () = {
    assert!(size_of::<BlockHeader>() == 64);
    assert!(size_of::<Node>() == 128);
    assert!(size_of::<Record>() == 16);
    assert!(size_of::<Ref>() == 8);
    assert!(size_of::<FileHeader>().is_multiple_of(8));
    assert!(
        cfg!(target_endian = "little"),
        "blocks are read in place: little-endian machines only"
    );
};

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_child_survives_its_code() {
        for i in 0..4096 {
            for child in [Child::Node(i), Child::Ref(i), Child::Empty] {
                assert_eq!(Child::decode(child.encode()), child);
                assert_eq!(Child::decode(child.encode() | 0x8000), child);
            }
            for count in 1..=4 {
                let leaf = Child::Leaf { at: i, count };
                assert_eq!(Child::decode(leaf.encode()), leaf);
            }
        }
    }

    #[test]
    fn an_order_names_each_slot_once() {
        let slots = [3, 1, 7, 0, 2, 6, 5, 4];
        let word = order_of(slots);
        assert!(is_order(word));
        for (place, &slot) in slots.iter().enumerate() {
            assert_eq!(word >> (3 * place) & 7, u32::from(slot));
            // One place names another slot.
            assert!(!is_order(word ^ 1 << (3 * place)));
        }
        assert!(!is_order(word | 1 << 24) && !is_order(0));
    }
}
