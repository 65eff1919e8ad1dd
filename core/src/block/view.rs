use bytemuck::{Pod, Zeroable};
use glam::Vec3;

use super::check;
use super::error::BlockError;
use super::format::{BlockHeader, FLAG_NORMALS, Node, Record, Ref};

/// A block, read in place.
///
/// Opening one is a few additions; every access is checked against the length of the bytes, so that
/// no content can make it panic. What [`BlockView::parse`] has accepted, every access finds.
#[derive(Debug, Clone, Copy)]
pub struct BlockView<'a> {
    quads: &'a [Quad],
    header: &'a BlockHeader,
}

/// The vertices of a block, as numbers, for lanes that load them: vertex `i` is words `3 i` to `3 i + 2`.
#[derive(Debug, Clone, Copy)]
pub struct Vertices<'a> {
    words: &'a [f32],
}

impl<'a> Vertices<'a> {
    /// How many could be loaded, whatever lies there: word `3 i + 3` exists as well for each vertex `i` below it. (How many the block has would have to be
    /// read from its header.)
    #[inline(always)]
    #[must_use]
    pub const fn count(&self) -> usize {
        self.words.len().saturating_sub(1) / 3
    }

    /// All words from the first vertex on.
    #[inline(always)]
    #[must_use]
    pub const fn words(&self) -> &'a [f32] {
        self.words
    }
}

/// What a block is checked against.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BlockLimits {
    /// Size of a block \[bytes\].
    pub block_bytes: usize,
    /// Number of blocks in the file.
    pub blocks: u32,
    /// Number of materials in the scene.
    pub materials: u32,
}

/// The checksum of blocks and files: CRC-32 (ISO-HDLC).
#[must_use]
pub fn checksum(bytes: &[u8]) -> u32 {
    #[cfg(feature = "wide-checksum")]
    return crc32fast::hash(bytes);
    #[cfg(not(feature = "wide-checksum"))]
    narrow_checksum(bytes)
}

/// The same by half bytes, with a table of 64 bytes: the least one of crates takes 1 KiB of a board's flash.
#[cfg(any(test, not(feature = "wide-checksum")))]
fn narrow_checksum(bytes: &[u8]) -> u32 {
    /// What half a byte leaves of the polynomial 0xedb88320.
    const TABLE: [u32; 16] = [
        0x0000_0000,
        0x1db7_1064,
        0x3b6e_20c8,
        0x26d9_30ac,
        0x76dc_4190,
        0x6b6b_51f4,
        0x4db2_6158,
        0x5005_713c,
        0xedb8_8320,
        0xf00f_9344,
        0xd6d6_a3e8,
        0xcb61_b38c,
        0x9b64_c2b0,
        0x86d3_d2d4,
        0xa00a_e278,
        0xbdbd_f21c,
    ];
    let half = |crc: u32| (crc >> 4) ^ TABLE.get(crc as usize & 15).copied().unwrap_or(0);
    !bytes.iter().fold(!0, |crc, &byte| half(half(crc ^ u32::from(byte))))
}

/// Sixteen aligned bytes. A block is a slice of them, so that its parts are cast without a check at
/// run time.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C, align(16))]
pub(super) struct Quad([u8; 16]);

pub(crate) static NO_HEADER: BlockHeader = BlockHeader {
    crc: 0,
    block: u32::MAX,
    origin: [0.0; 3],
    scale: [1.0; 3],
    nodes: 0,
    records: 0,
    vertices: 0,
    refs: 0,
    flags: 0,
    height: 0,
    nesting: 0,
    _zero: [0; 9],
};

const HEADER_QUADS: usize = size_of::<BlockHeader>() / size_of::<Quad>();
const HEADER_WORDS: usize = size_of::<BlockHeader>() / size_of::<u32>();
const NODE_QUADS: usize = size_of::<Node>() / size_of::<Quad>();

impl<'a> BlockView<'a> {
    /// Opens bytes of unknown origin as block number `block`, and checks everything in them.
    ///
    /// `bytes` is the whole block and begins at a multiple of 16. Costs a pass over the bytes for
    /// the checksum and one over the content, and half a KiB of stack.
    ///
    /// # Errors
    /// [`BlockError`] names the first thing found wrong.
    #[cfg_attr(feature = "bundles", inline(always))]
    pub fn parse(bytes: &'a [u8], block: u32, limits: &BlockLimits) -> Result<Self, BlockError> {
        check::length(bytes, limits)?;
        let quads: &[Quad] = bytemuck::try_cast_slice(bytes).map_err(|_| BlockError::Alignment)?;
        let view = Self::open(quads);
        if checksum(bytes.get(4..).unwrap_or_default()) != view.header.crc {
            return Err(BlockError::Checksum);
        }
        check::content(&view, block, limits)?;
        Ok(view)
    }

    /// Opens bytes that [`BlockView::parse`] has accepted before. Costs a few additions.
    ///
    /// Other bytes are no danger: they give a block that may lack parts.
    #[inline(always)]
    #[must_use]
    pub fn trusted(bytes: &'a [u8]) -> Self {
        Self::open(bytemuck::try_cast_slice(bytes).unwrap_or_default())
    }

    #[inline(always)]
    pub(super) fn open(quads: &'a [Quad]) -> Self {
        let header: &BlockHeader = match quads.first_chunk::<HEADER_QUADS>() {
            Some(head) => bytemuck::cast_ref(head),
            None => &NO_HEADER,
        };
        Self { quads, header }
    }

    /// The first 64 bytes.
    #[inline(always)]
    #[must_use]
    pub fn header(&self) -> &'a BlockHeader {
        self.header
    }

    /// The number of the block in its file.
    #[inline(always)]
    #[must_use]
    pub fn number(&self) -> u32 {
        self.header.block
    }

    /// The node with this index.
    #[inline(always)]
    #[must_use]
    pub fn node(&self, index: u16) -> Option<&'a Node> {
        let end = self.quads.len().checked_sub(NODE_QUADS * usize::from(index))?;
        let quads = self.quads.get(..end)?.last_chunk::<NODE_QUADS>()?;
        Some(bytemuck::cast_ref(quads))
    }

    /// All nodes, by index.
    #[must_use]
    pub fn nodes(&self) -> impl DoubleEndedIterator<Item = &'a Node> + ExactSizeIterator + use<'a> {
        let nodes: &[Node] =
            bytemuck::cast_slice(self.quads.get(self.nodes_at()..).unwrap_or_default());
        nodes.iter().rev()
    }

    /// So many records that begin here, in records from the begin of the block; none if they are not all there.
    #[inline(always)]
    #[must_use]
    pub fn leaf(&self, at: u16, count: u16) -> &'a [Record] {
        let from = usize::from(at);
        bytemuck::cast_slice(self.quads.get(from..from + usize::from(count)).unwrap_or_default())
    }

    /// Whether it has these records.
    pub(crate) fn has_records(&self, at: u16, count: u16) -> bool {
        let first = at.wrapping_sub(self.records_at() as u16);
        first.saturating_add(count) <= self.header.records
    }

    /// All records.
    #[must_use]
    pub fn records(&self) -> &'a [Record] {
        self.leaf(self.records_at() as u16, self.header.records)
    }

    /// The words of the block from one on, so many; none if they are not all there.
    #[inline(always)]
    fn words(&self, at: usize, len: usize) -> &'a [u32] {
        let words: &[u32] = bytemuck::cast_slice(self.quads);
        words.get(at..at + len).unwrap_or_default()
    }

    /// All words from the first vertex to the end of the block, as `f32`: vertex `i` is words `3 i` to `3 i + 2`.
    #[inline(always)]
    fn vertex_words(&self) -> &'a [f32] {
        bytemuck::cast_slice(self.quads.get(HEADER_QUADS..).unwrap_or_default())
    }

    /// All vertices, to be loaded as numbers.
    #[inline(always)]
    #[must_use]
    pub fn vertex_numbers(&self) -> Vertices<'a> {
        Vertices { words: self.vertex_words() }
    }

    /// All vertices.
    #[must_use]
    pub fn vertices(&self) -> &'a [[f32; 3]] {
        let words = self.words(HEADER_WORDS, 3 * usize::from(self.header.vertices));
        bytemuck::cast_slice(words.as_chunks::<3>().0)
    }

    /// The vertex with this index.
    #[inline(always)]
    #[must_use]
    pub fn vertex(&self, index: usize) -> Option<Vec3> {
        let words = self.vertex_words().get(index * 3..)?.first_chunk::<3>()?;
        Some(Vec3::from_array(*words))
    }

    /// The [codes](super::octahedral) of the shading normals, by vertex; empty without normals.
    #[must_use]
    pub fn normals(&self) -> &'a [u32] {
        self.words(self.normals_at(), self.normal_count())
    }

    /// The code of the shading normal at a vertex.
    #[must_use]
    pub fn normal(&self, vertex: usize) -> Option<u32> {
        self.normals().get(vertex).copied()
    }

    /// All references to other blocks.
    #[must_use]
    pub fn refs(&self) -> &'a [Ref] {
        let words = self.words(self.refs_at(), 2 * usize::from(self.header.refs));
        bytemuck::cast_slice(words.as_chunks::<2>().0)
    }

    /// The reference with this index.
    #[inline(always)]
    #[must_use]
    pub fn reference(&self, index: u16) -> Option<Ref> {
        let [block, node] =
            *self.words(self.refs_at() + 2 * usize::from(index), 2).first_chunk::<2>()?;
        Some(Ref { block, node: node as u16, _zero: 0 })
    }

    #[inline(always)]
    fn normal_count(&self) -> usize {
        usize::from(self.header.flags & FLAG_NORMALS) * usize::from(self.header.vertices)
    }

    /// Where the normals begin, in words.
    #[inline(always)]
    fn normals_at(&self) -> usize {
        HEADER_WORDS + 3 * usize::from(self.header.vertices)
    }

    /// Where the references begin, in words.
    #[inline(always)]
    fn refs_at(&self) -> usize {
        self.normals_at() + self.normal_count()
    }

    /// Where they end, in words.
    #[inline(always)]
    fn refs_end(&self) -> usize {
        self.refs_at() + 2 * usize::from(self.header.refs)
    }

    /// Where the records begin, in records.
    #[cfg_attr(not(feature = "bundles"), inline(never))]
    pub(super) fn records_at(&self) -> usize {
        self.refs_end().div_ceil(4)
    }

    /// Where the nodes begin, in quads; behind the end if they are longer than the block.
    fn nodes_at(&self) -> usize {
        self.quads.len().wrapping_sub(NODE_QUADS * usize::from(self.header.nodes))
    }

    /// The words that are to be zero: those between references and records, and those between records and nodes. `None` if the parts are longer than the
    /// block.
    pub(super) fn padding(&self) -> Option<(&'a [u32], &'a [u32])> {
        let (end, at) = (self.refs_end(), self.records_at());
        let between = self.quads.get(at + usize::from(self.header.records)..self.nodes_at())?;
        Some((self.words(end, 4 * at - end), bytemuck::cast_slice(between)))
    }
}

#[cfg(test)]
mod tests {
    use super::{checksum, narrow_checksum};

    #[test]
    fn the_checksum_is_that_of_its_catalogue() {
        // CRC-32/ISO-HDLC, "check" (Williams 1993).
        assert_eq!(checksum(b"123456789"), 0xcbf4_3926);
        let bytes: std::vec::Vec<u8> = (0..4096_u32).map(|i| ((i * i) >> 3) as u8).collect();
        for len in [0, 1, 9, 255, 4096] {
            assert_eq!(narrow_checksum(&bytes[..len]), checksum(&bytes[..len]));
        }
    }
}
