use core::fmt;

use bytemuck::Pod;

use super::error::BlockError;
use super::format::{BLOCK_BYTES_MAX, BLOCK_BYTES_MIN, FileHeader, MAGIC, Section, VERSION};
use super::tables;
use super::view::{BlockLimits, BlockView, Quad, checksum};
#[cfg(feature = "many-lights")]
use crate::scene::LightNode;
use crate::scene::{Light, Material, Needs, View};

/// A `.kilo` file in memory: mapped, or in flash.
///
/// Opening it checks the header and the tables. Blocks are checked one by one
/// ([`KiloView::check_block`]) or all at once ([`KiloView::check_blocks`]) before they are traced.
#[derive(Debug, Clone, Copy)]
pub struct KiloView<'a> {
    header: &'a FileHeader,
    materials: &'a [Material],
    lights: &'a [Light],
    views: &'a [View],
    #[cfg(feature = "many-lights")]
    light_tree: &'a [LightNode],
    needs: &'a Needs,
    blocks: &'a [Quad],
    block_quads: usize,
    /// Its logarithm.
    block_shift: u32,
}

/// Why a file is refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum FileError {
    /// The bytes do not begin at a multiple of 16 in memory.
    Alignment,
    /// It does not begin as a `.kilo` file does.
    Magic,
    /// Another version of the layout.
    Version {
        /// The file's.
        found: u32,
    },
    /// Fewer bytes than the header says.
    Truncated {
        /// Bytes that should be there.
        expected: u64,
        /// Bytes that are.
        found: u64,
    },
    /// More bytes than the header says.
    Longer {
        /// Bytes that should be there.
        expected: u64,
        /// Bytes that are.
        found: u64,
    },
    /// Between the tables and the first block there is something.
    Padding,
    /// The checksum of header and tables does not match.
    Checksum,
    /// A size, offset or count in the header that cannot be.
    Header,
    /// An entry of a table with an unknown kind, an index out of range or a number that makes no sense.
    Table {
        /// Which table.
        table: Table,
        /// Index of the entry.
        entry: u32,
    },
    /// The scene needs what this build leaves out.
    LeftOut {
        /// Bits of [`Needs`].
        needs: u32,
    },
    /// A block is refused.
    Block {
        /// Its number.
        block: u32,
        /// Why.
        error: BlockError,
    },
}

/// A table of the file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Table {
    /// Materials.
    Materials,
    /// Lights.
    Lights,
    /// Views.
    Views,
    /// The tree of the lights.
    #[cfg(feature = "many-lights")]
    LightTree,
    /// What the scene needs.
    Needs,
}

impl<'a> KiloView<'a> {
    /// Opens a file, and checks all of it but the blocks.
    ///
    /// `bytes` begins at a multiple of 16, and is the file, no more and no less.
    ///
    /// # Errors
    /// [`FileError`] names the first thing found wrong.
    pub fn parse(bytes: &'a [u8]) -> Result<Self, FileError> {
        let header = header(bytes)?;
        let (expected, found) = (header.file_bytes, bytes.len() as u64);
        if found < expected {
            return Err(FileError::Truncated { expected, found });
        }
        if found > expected {
            return Err(FileError::Longer { expected, found });
        }
        let (file, end) = Self::open_head(bytes, header)?;
        Ok(Self { blocks: blocks(bytes, header, end)?, ..file })
    }

    /// Opens the part of a file before its blocks: the header and the tables, checked as [`KiloView::parse`] does. It knows how many blocks there are, and
    /// has none of them.
    ///
    /// # Errors
    /// As [`KiloView::parse`].
    pub fn parse_head(bytes: &'a [u8]) -> Result<Self, FileError> {
        Self::open_head(bytes, header(bytes)?).map(|(file, _)| file)
    }

    /// Length of the part before the blocks \[bytes\]: that of [`KiloView::parse_head`].
    #[must_use]
    pub fn head_bytes(&self) -> usize {
        // The last table, of one entry.
        (self.header.needs.at as usize).saturating_add(size_of::<Needs>())
    }

    /// What lies before the blocks, and where it ends.
    fn open_head(bytes: &'a [u8], header: &'a FileHeader) -> Result<(Self, usize), FileError> {
        let mut end = size_of::<FileHeader>();
        let materials = section(bytes, header.materials, &mut end)?;
        let lights = section(bytes, header.lights, &mut end)?;
        let views = section(bytes, header.views, &mut end)?;
        #[cfg(feature = "many-lights")]
        let light_tree = match header.light_tree {
            Section { at: 0, len: 0 } => &[],
            there => section(bytes, there, &mut end)?,
        };
        let needs = section(bytes, header.needs, &mut end)?;
        if bytes.get(12..end).map(checksum) != Some(header.crc) {
            return Err(FileError::Checksum);
        }
        tables::check(materials, lights, views, needs)?;
        #[cfg(feature = "many-lights")]
        tables::check_tree(light_tree, lights.len())?;
        let [needs] = needs else { return Err(FileError::Header) };
        // There is a root, even of nothing.
        if header.blocks == 0 || !tables::header_is_sound(header) {
            return Err(FileError::Header);
        }
        #[cfg(feature = "many-lights")]
        if light_tree.is_empty() == needs.any(Needs::MANY_LIGHTS) {
            return Err(FileError::Header);
        }
        let left_out = needs.bits & Needs::LEFT_OUT;
        if left_out != 0 {
            return Err(FileError::LeftOut { needs: left_out });
        }
        let block_quads = header.block_bytes as usize / size_of::<Quad>();
        let block_shift = block_quads.trailing_zeros() & 31;
        let file = Self {
            header,
            materials,
            lights,
            views,
            #[cfg(feature = "many-lights")]
            light_tree,
            needs,
            blocks: &[],
            block_quads,
            block_shift,
        };
        Ok((file, end))
    }

    /// The first bytes.
    #[must_use]
    pub fn header(&self) -> &'a FileHeader {
        self.header
    }

    /// The materials.
    #[must_use]
    pub fn materials(&self) -> &'a [Material] {
        self.materials
    }

    /// The lights.
    #[must_use]
    pub fn lights(&self) -> &'a [Light] {
        self.lights
    }

    /// The tree of the lights; empty if they are few enough to look at each.
    #[cfg(feature = "many-lights")]
    #[must_use]
    pub fn light_tree(&self) -> &'a [LightNode] {
        self.light_tree
    }

    /// The views; the first is the default.
    #[must_use]
    pub fn views(&self) -> &'a [View] {
        self.views
    }

    /// What the scene needs.
    #[must_use]
    pub fn needs(&self) -> &'a Needs {
        self.needs
    }

    /// Number of blocks.
    #[inline(always)]
    #[must_use]
    pub fn blocks(&self) -> u32 {
        self.header.blocks
    }

    /// What a block of this file is checked against.
    #[must_use]
    pub fn limits(&self) -> BlockLimits {
        BlockLimits {
            block_bytes: self.header.block_bytes as usize,
            blocks: self.header.blocks,
            materials: self.materials.len() as u32,
        }
    }

    /// All blocks, back to back.
    #[must_use]
    pub fn block_section(&self) -> &'a [u8] {
        bytemuck::cast_slice(self.blocks)
    }

    /// The bytes of a block; `None` beyond the last.
    #[must_use]
    pub fn block_bytes(&self, block: u32) -> Option<&'a [u8]> {
        self.block_quads(block).map(bytemuck::cast_slice)
    }

    /// A block of unknown origin.
    ///
    /// # Errors
    /// [`FileError::Block`] if there is no such block or it is refused.
    pub fn check_block(&self, block: u32) -> Result<BlockView<'a>, FileError> {
        self.block_bytes(block)
            .ok_or(BlockError::Length)
            .and_then(|bytes| BlockView::parse(bytes, block, &self.limits()))
            .map_err(|error| FileError::Block { block, error })
    }

    /// Checks all blocks, and that references lead to nodes that exist. A pass over the file.
    ///
    /// # Errors
    /// As [`KiloView::check_block`].
    pub fn check_blocks(&self) -> Result<(), FileError> {
        for block in 0..self.blocks() {
            self.check_refs(&self.check_block(block)?)?;
        }
        Ok(())
    }

    /// References of a checked block lead to nodes.
    ///
    /// # Errors
    /// [`FileError::Block`] with the reference.
    pub fn check_refs(&self, view: &BlockView<'_>) -> Result<(), FileError> {
        let own = view.header();
        for (index, r) in (0u16..).zip(view.refs()) {
            let fits =
                self.trusted_block(r.block).is_some_and(|child| r.node < child.header().nodes);
            if !fits {
                let error = BlockError::Ref { index };
                return Err(FileError::Block { block: own.block, error });
            }
        }
        Ok(())
    }

    /// A block that was checked before.
    #[inline(always)]
    #[must_use]
    pub fn trusted_block(&self, block: u32) -> Option<BlockView<'a>> {
        self.block_quads(block).map(BlockView::open)
    }

    #[inline(always)]
    fn block_quads(&self, block: u32) -> Option<&'a [Quad]> {
        // The size is a power of two; all that is done in the block would wait for a product.
        let at = usize::try_from(u64::from(block) << self.block_shift).ok()?;
        self.blocks.get(at..)?.get(..self.block_quads)
    }
}

/// The header, of this version.
fn header(bytes: &[u8]) -> Result<&FileHeader, FileError> {
    let head = bytes.get(..size_of::<FileHeader>());
    let header: &FileHeader = match head {
        _ if bytes.get(..4) != Some(&MAGIC) => return Err(FileError::Magic),
        _ if bytes.as_ptr().align_offset(16) != 0 => return Err(FileError::Alignment),
        Some(head) => bytemuck::try_from_bytes(head).map_err(|_| FileError::Alignment)?,
        None => {
            let expected = size_of::<FileHeader>() as u64;
            return Err(FileError::Truncated { expected, found: bytes.len() as u64 });
        }
    };
    if header.version != VERSION {
        return Err(FileError::Version { found: header.version });
    }
    Ok(header)
}

/// A table; moves `end` to behind it.
fn section<'a, T: Pod>(
    bytes: &'a [u8],
    section: Section,
    end: &mut usize,
) -> Result<&'a [T], FileError> {
    let at = section.at as usize;
    let len = (section.len as usize).checked_mul(size_of::<T>()).ok_or(FileError::Header)?;
    let behind = at.checked_add(len).ok_or(FileError::Header)?;
    if !at.is_multiple_of(64) || at < *end {
        return Err(FileError::Header);
    }
    *end = behind;
    let part = bytes.get(at..behind).ok_or(FileError::Header)?;
    bytemuck::try_cast_slice(part).map_err(|_| FileError::Alignment)
}

/// The blocks, which lie behind byte `end`.
fn blocks<'a>(bytes: &'a [u8], header: &FileHeader, end: usize) -> Result<&'a [Quad], FileError> {
    let size = header.block_bytes as usize;
    if !size.is_power_of_two() || !(BLOCK_BYTES_MIN..=BLOCK_BYTES_MAX).contains(&size) {
        return Err(FileError::Header);
    }
    let at = usize::try_from(header.blocks_at).map_err(|_| FileError::Header)?;
    let len = size.checked_mul(header.blocks as usize).ok_or(FileError::Header)?;
    if !at.is_multiple_of(size.min(4096)) || at < end || at.checked_add(len) != Some(bytes.len()) {
        return Err(FileError::Header);
    }
    let (before, part) = bytes.split_at_checked(at).ok_or(FileError::Header)?;
    if before.get(end..).is_none_or(|padding| padding.iter().any(|&byte| byte != 0)) {
        return Err(FileError::Padding);
    }
    bytemuck::try_cast_slice(part).map_err(|_| FileError::Alignment)
}

impl fmt::Display for FileError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Alignment => f.write_str("the file is not aligned to 16 bytes in memory"),
            Self::Magic => f.write_str("this is not a .kilo file"),
            Self::Version { found } => {
                write!(f, "the file has layout {found}, this program reads {VERSION}")
            }
            Self::Truncated { expected, found } => {
                write!(f, "the file ends after {found} of {expected} bytes")
            }
            Self::Longer { expected, found } => {
                write!(f, "the file has {found} bytes where its header says {expected}")
            }
            Self::Padding => f.write_str("what lies between the tables and the blocks is not zero"),
            Self::Checksum => f.write_str("the checksum of the tables does not match"),
            Self::Header => f.write_str("the header holds a size or offset that cannot be"),
            Self::Table { table, entry } => {
                let name = match table {
                    Table::Materials => "material",
                    Table::Lights => "light",
                    Table::Views => "view",
                    #[cfg(feature = "many-lights")]
                    Table::LightTree => "light tree's node",
                    Table::Needs => "needs",
                };
                write!(f, "{name} {entry} has an unknown kind, index or number")
            }
            Self::LeftOut { needs } => {
                f.write_str("the scene needs what is left out here:")?;
                let names = [
                    (Needs::SPECULAR | Needs::GLOSSY | Needs::DIELECTRIC, " `specular`"),
                    (Needs::TRANSPARENT, " `transparent`"),
                    (Needs::SPHERES, " `sphere`"),
                    (Needs::MANY_LIGHTS, " `many-lights`"),
                ];
                let mut needed = names.into_iter().filter(|(bits, _)| needs & bits != 0);
                needed.try_for_each(|(_, name)| f.write_str(name))
            }
            Self::Block { block, error } => write!(f, "block {block}: {error}"),
        }
    }
}

impl core::error::Error for FileError {}
