use bytemuck::{Pod, Zeroable, bytes_of, cast_slice, cast_slice_mut};
use kiloray_core::block::checksum;
use kiloray_core::block::format::{FileHeader, Section};
use kiloray_core::scene::{Light, LightNode, Material, Needs, View};
use memmap2::MmapMut;

/// A file in memory, at a multiple of 64.
#[derive(Debug)]
pub struct Image {
    memory: Memory,
    /// Length of the file; the memory may be longer.
    len: usize,
    blocks_at: usize,
}

/// Zeroed memory at a multiple of 64.
#[derive(Debug)]
enum Memory {
    Small(Vec<Line>),
    /// In large pages, where the system has them: rays go from block to block, and each lies in another page.
    Large(MmapMut),
}

#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C, align(64))]
struct Line([u8; 64]);

/// A large page \[bytes\].
const LARGE_PAGE: usize = 2 << 20;

impl Memory {
    /// At least so many bytes.
    fn new(len: usize) -> Self {
        let pages = len.checked_next_multiple_of(LARGE_PAGE).filter(|_| len >= LARGE_PAGE);
        let Some(map) = pages.and_then(|pages| MmapMut::map_anon(pages).ok()) else {
            return Self::Small(vec![Line([0; 64]); len.div_ceil(64)]);
        };
        // A system without large pages does without.
        #[cfg(target_os = "linux")]
        let _ = map.advise(memmap2::Advice::HugePage);
        Self::Large(map)
    }

    fn bytes(&self) -> &[u8] {
        match self {
            Self::Small(lines) => cast_slice(lines),
            Self::Large(map) => map,
        }
    }

    fn bytes_mut(&mut self) -> &mut [u8] {
        match self {
            Self::Small(lines) => cast_slice_mut(lines),
            Self::Large(map) => map,
        }
    }
}

/// The tables of a file.
#[derive(Debug, Clone, Copy)]
pub struct Tables<'a> {
    /// Materials.
    pub materials: &'a [Material],
    /// Lights.
    pub lights: &'a [Light],
    /// Views.
    pub views: &'a [View],
    /// The tree of the lights, or nothing.
    pub light_tree: &'a [LightNode],
    /// What the scene needs.
    pub needs: Needs,
}

impl Image {
    /// A file with these tables, and room for the blocks: all zero. Of the header the sizes of
    /// blocks and their number, the frame and the bounds are taken; the rest is filled in.
    #[must_use]
    pub fn new(mut header: FileHeader, tables: Tables<'_>) -> Self {
        let parts = [
            cast_slice(tables.materials),
            cast_slice(tables.lights),
            cast_slice(tables.views),
            cast_slice(tables.light_tree),
            bytes_of(&tables.needs),
        ];
        let Tables { materials, lights, views, light_tree, .. } = tables;
        let lens = [materials.len(), lights.len(), views.len(), light_tree.len(), 1];
        let mut sections = [Section { at: 0, len: 0 }; 5];
        let mut end = size_of::<FileHeader>();
        for ((section, part), len) in sections.iter_mut().zip(parts).zip(lens) {
            let at = end.next_multiple_of(64);
            *section = Section { at: at as u32, len: len as u32 };
            end = at + part.len();
        }
        let [materials, lights, views, tree, needs] = sections;
        [header.materials, header.lights, header.views, header.needs] =
            [materials, lights, views, needs];
        // A tree of nothing is nowhere.
        header.light_tree = if tree.len > 0 { tree } else { Section { at: 0, len: 0 } };
        let block_bytes = header.block_bytes as usize;
        let blocks_at = end.next_multiple_of(block_bytes.clamp(64, 4096));
        let len = blocks_at + block_bytes * header.blocks as usize;
        header.blocks_at = blocks_at as u64;
        header.file_bytes = len as u64;

        let mut image = Self { memory: Memory::new(len), len, blocks_at };
        let bytes = image.memory.bytes_mut();
        for (section, part) in sections.iter().zip(parts) {
            let at = section.at as usize;
            bytes[at..at + part.len()].copy_from_slice(part);
        }
        bytes[..size_of::<FileHeader>()].copy_from_slice(bytes_of(&header));
        header.crc = checksum(&bytes[12..end]);
        bytes[..size_of::<FileHeader>()].copy_from_slice(bytes_of(&header));
        image
    }

    /// Copies a file's bytes.
    #[must_use]
    pub fn copy_of(bytes: &[u8]) -> Self {
        let mut memory = Memory::new(bytes.len());
        memory.bytes_mut()[..bytes.len()].copy_from_slice(bytes);
        Self { memory, len: bytes.len(), blocks_at: bytes.len() }
    }

    /// The bytes of the file.
    #[must_use]
    pub fn bytes(&self) -> &[u8] {
        &self.memory.bytes()[..self.len]
    }

    /// The bytes of the blocks.
    pub(crate) fn blocks_mut(&mut self) -> &mut [u8] {
        &mut self.memory.bytes_mut()[self.blocks_at..self.len]
    }
}
