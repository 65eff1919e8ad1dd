use core::fmt;

use bytemuck::{Pod, Zeroable};

use super::{Dealing, Placement, Rom};
use crate::block::format::{BLOCK_BYTES_MAX, BLOCK_BYTES_MIN};
use crate::block::{BlockView, FileError, KiloView, checksum};
use crate::network::NodeId;

/// A node's share of a scene, as it lies in the node's read-only memory: all that the node needs of the scene, and nothing else.
///
/// | part | begins at |
/// | --- | --- |
/// | [`ShareHeader`] | 0 |
/// | header and tables of the `.kilo` file | 64 |
/// | the node's blocks, as [`Rom::of_share`] wants them | behind, at the next multiple of 64 |
#[derive(Debug, Clone, Copy)]
pub struct Share<'a> {
    file: KiloView<'a>,
    rom: Rom<'a>,
    placement: Placement,
    here: NodeId,
}

/// The first 64 bytes of a share, little-endian.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct ShareHeader {
    /// [`MAGIC`](Self::MAGIC).
    pub magic: [u8; 4],
    /// [`VERSION`](Self::VERSION).
    pub version: u32,
    /// CRC-32 (ISO-HDLC) of the rest of this header. Tables and blocks have their own.
    pub crc: u32,
    /// Length of header and tables of the `.kilo` file.
    pub head_bytes: u32,
    /// Blocks of the node.
    pub blocks: u32,
    /// Blocks that every node has.
    pub top: u32,
    /// Whose share it is.
    pub here: u16,
    /// Nodes of the mesh.
    pub nodes: u16,
    /// Copies of each other block.
    pub replicas: u16,
    /// 0 for subtrees, 1 for one block to each node in turn.
    pub dealing: u16,
    /// Zero.
    pub _zero: [u32; 8],
}

impl ShareHeader {
    /// The first four bytes.
    pub const MAGIC: [u8; 4] = *b"KNOD";
    /// The version of this layout. A reader refuses any other.
    pub const VERSION: u32 = 1;

    /// The header of a node's share, with its checksum; nothing but the number of blocks is taken from `rom`.
    #[must_use]
    pub fn new(placement: &Placement, here: NodeId, head_bytes: u32) -> Self {
        let mut header = Self {
            magic: Self::MAGIC,
            version: Self::VERSION,
            crc: 0,
            head_bytes,
            blocks: Rom::of_share(&[], 0, *placement, here).len() as u32,
            top: placement.top,
            here: here.0,
            nodes: placement.nodes,
            replicas: placement.replicas,
            dealing: match placement.dealing {
                Dealing::Subtrees => 0,
                Dealing::RoundRobin => 1,
            },
            _zero: [0; 8],
        };
        header.crc = header.checksum();
        header
    }

    /// Where the blocks begin.
    #[must_use]
    pub fn blocks_at(&self) -> Option<usize> {
        (self.head_bytes as usize).checked_add(size_of::<Self>())?.checked_next_multiple_of(64)
    }

    fn checksum(&self) -> u32 {
        checksum(bytemuck::bytes_of(self).get(12..).unwrap_or_default())
    }
}

/// Why a share is refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum ShareError {
    /// It does not begin as a share does.
    Magic,
    /// Another version of the layout.
    Version {
        /// The share's.
        found: u32,
    },
    /// The checksum of its header does not match, or a number in it cannot be.
    Header,
    /// It ends before its last block does.
    Truncated,
    /// The tables, or a block, are refused.
    Scene(FileError),
}

impl<'a> Share<'a> {
    /// Opens a share, and checks all of it but the blocks.
    ///
    /// `bytes` begins at a multiple of 16, and may be longer than the share.
    ///
    /// # Errors
    /// [`ShareError`] names the first thing found wrong.
    pub fn parse(bytes: &'a [u8]) -> Result<Self, ShareError> {
        if bytes.get(..4) != Some(&ShareHeader::MAGIC) {
            return Err(ShareError::Magic);
        }
        let header = bytes.get(..size_of::<ShareHeader>()).ok_or(ShareError::Truncated)?;
        let header: ShareHeader =
            bytemuck::try_pod_read_unaligned(header).map_err(|_| ShareError::Header)?;
        if header.version != ShareHeader::VERSION {
            return Err(ShareError::Version { found: header.version });
        }
        if header.crc != header.checksum() || header.here >= header.nodes {
            return Err(ShareError::Header);
        }
        let blocks_at = header.blocks_at().ok_or(ShareError::Header)?;
        let head = bytes.get(size_of::<ShareHeader>()..blocks_at).ok_or(ShareError::Truncated)?;
        let file = KiloView::parse_head(head).map_err(ShareError::Scene)?;
        let block_bytes = file.limits().block_bytes;
        if !block_bytes.is_power_of_two()
            || !(BLOCK_BYTES_MIN..=BLOCK_BYTES_MAX).contains(&block_bytes)
        {
            return Err(ShareError::Header);
        }
        let placement = Placement {
            dealing: match header.dealing {
                0 => Dealing::Subtrees,
                1 => Dealing::RoundRobin,
                _ => return Err(ShareError::Header),
            },
            blocks: file.blocks(),
            nodes: header.nodes,
            top: header.top,
            replicas: header.replicas,
        };
        let here = NodeId(header.here);
        // Before they are counted one by one.
        let len = block_bytes.checked_mul(header.blocks as usize).ok_or(ShareError::Header)?;
        let blocks = bytes.get(blocks_at..).and_then(|rest| rest.get(..len));
        let blocks = blocks.ok_or(ShareError::Truncated)?;
        let rom = Rom::of_share(blocks, block_bytes, placement, here);
        if rom.len() != header.blocks as usize {
            return Err(ShareError::Header);
        }
        Ok(Self { file, rom, placement, here })
    }

    /// Checks the blocks: a pass over all of them.
    ///
    /// # Errors
    /// [`ShareError::Scene`] with the first block that is refused.
    pub fn check_blocks(&self) -> Result<(), ShareError> {
        let limits = self.file.limits();
        for block in (0..self.file.blocks()).filter(|&block| self.rom.holds(block)) {
            let bytes = self.rom.block(block).unwrap_or_default();
            if let Err(error) = BlockView::parse(bytes, block, &limits) {
                return Err(ShareError::Scene(FileError::Block { block, error }));
            }
        }
        Ok(())
    }

    /// Whose share it is.
    #[must_use]
    pub const fn here(&self) -> NodeId {
        self.here
    }

    /// Which node owns which block.
    #[must_use]
    pub const fn placement(&self) -> &Placement {
        &self.placement
    }

    /// Header and tables of the scene; it has no blocks.
    #[must_use]
    pub const fn file(&self) -> &KiloView<'a> {
        &self.file
    }

    /// The blocks.
    #[must_use]
    pub const fn rom(&self) -> &Rom<'a> {
        &self.rom
    }

    /// What tells this scene from others: the checksum of its tables, the same in all shares.
    #[must_use]
    pub fn scene(&self) -> u32 {
        self.file.header().crc
    }
}

impl fmt::Display for ShareError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Magic => f.write_str("this is not a node's share of a scene"),
            Self::Version { found } => {
                write!(
                    f,
                    "the share has layout {found}, this program reads {}",
                    ShareHeader::VERSION
                )
            }
            Self::Header => f.write_str("the header of the share holds a number that cannot be"),
            Self::Truncated => f.write_str("the share ends before its last block"),
            Self::Scene(error) => error.fmt(f),
        }
    }
}

impl core::error::Error for ShareError {}
