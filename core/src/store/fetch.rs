use super::{BlockCache, CacheCounts, Claim};
use crate::block::{BlockError, BlockLimits, BlockSource, BlockView, KiloView, NoBlock};
use core::fmt;

/// Where blocks lie that are in no frame: a file, or a flash that cannot be read in place.
pub trait Medium {
    /// Why a block cannot be read.
    type Error;

    /// Writes a block to `into`, which has its size.
    ///
    /// # Errors
    /// As the medium defines; what `into` holds then does not matter.
    fn read(&mut self, block: u32, into: &mut [u8]) -> Result<(), Self::Error>;

    /// Whether all its blocks have been checked already, so that it can be spared on arrival.
    fn is_checked(&self) -> bool {
        false
    }
}

/// A mapped file. Its blocks are checked each time they arrive.
impl Medium for KiloView<'_> {
    type Error = NoBlock;

    fn read(&mut self, block: u32, into: &mut [u8]) -> Result<(), NoBlock> {
        match self.block_bytes(block) {
            Some(bytes) if bytes.len() == into.len() => {
                into.copy_from_slice(bytes);
                Ok(())
            }
            _ => Err(NoBlock(block)),
        }
    }
}

/// A medium all of whose blocks have been checked.
#[derive(Debug, Clone, Copy)]
pub struct Checked<M>(pub M);

impl<M: Medium> Medium for Checked<M> {
    type Error = M::Error;

    fn read(&mut self, block: u32, into: &mut [u8]) -> Result<(), M::Error> {
        self.0.read(block, into)
    }

    fn is_checked(&self) -> bool {
        true
    }
}

/// Blocks through a cache: what is not here is read from a medium into a frame, at once.
#[derive(Debug)]
pub struct FetchedBlocks<'a, M> {
    cache: BlockCache<'a>,
    medium: M,
    limits: BlockLimits,
}

/// Why a block could not be had.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FetchError<E> {
    /// The medium did not give it.
    Medium {
        /// The block.
        block: u32,
        /// Why.
        error: E,
    },
    /// It arrived, and is damaged.
    Refused {
        /// The block.
        block: u32,
        /// What is wrong with it.
        error: BlockError,
    },
    /// No frame can be had for it.
    Full {
        /// The block.
        block: u32,
    },
}

impl<'a, M: Medium> FetchedBlocks<'a, M> {
    /// Blocks of `medium`, by way of `cache`.
    #[must_use]
    pub const fn new(cache: BlockCache<'a>, medium: M, limits: BlockLimits) -> Self {
        Self { cache, medium, limits }
    }

    /// What the cache did so far.
    #[must_use]
    pub const fn counts(&self) -> CacheCounts {
        self.cache.counts()
    }

    /// Reads a block into a frame and checks it.
    #[cold]
    fn fetch(&mut self, block: u32) -> Result<(), FetchError<M::Error>> {
        self.cache.reserve(block, Claim::Demand).map_err(|_| FetchError::Full { block })?;
        let frame = self.cache.incoming(block).ok_or(FetchError::Full { block })?;
        let read = match self.medium.read(block, frame) {
            Err(error) => Err(FetchError::Medium { block, error }),
            Ok(()) if self.medium.is_checked() => Ok(()),
            Ok(()) => match BlockView::parse(frame, block, &self.limits) {
                Ok(_) => Ok(()),
                Err(error) => Err(FetchError::Refused { block, error }),
            },
        };
        match read {
            Ok(()) => self.cache.arrived(block),
            Err(_) => {
                self.cache.discard(block);
                return read;
            }
        };
        read
    }
}

impl<M: Medium> BlockSource for FetchedBlocks<'_, M> {
    type Error = FetchError<M::Error>;

    #[inline]
    fn block(&mut self, block: u32) -> Result<BlockView<'_>, Self::Error> {
        let frame = match self.cache.find(block) {
            Some(frame) => Some(frame),
            None => {
                self.cache.note_miss();
                self.fetch(block)?;
                self.cache.first_use(block)
            }
        };
        let bytes = frame.and_then(|frame| self.cache.bytes(frame));
        bytes.map(BlockView::trusted).ok_or(FetchError::Full { block })
    }
}

impl<E: fmt::Display> fmt::Display for FetchError<E> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Medium { error, .. } => error.fmt(f),
            Self::Refused { block, error } => write!(f, "block {block}: {error}"),
            Self::Full { block } => write!(f, "no frame is free for block {block}"),
        }
    }
}

impl<E: fmt::Debug + fmt::Display> core::error::Error for FetchError<E> {}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::block::checksum;
    use crate::block::format::BlockHeader;
    use crate::store::{Arena, Chunk};
    use bytemuck::Zeroable;

    const BLOCK: usize = 1024;

    /// Blocks of one empty node each; number 3 is damaged.
    struct Shelf {
        reads: Vec<u32>,
    }

    impl Medium for Shelf {
        type Error = NoBlock;

        fn read(&mut self, block: u32, into: &mut [u8]) -> Result<(), NoBlock> {
            self.reads.push(block);
            if block >= 8 {
                return Err(NoBlock(block));
            }
            into.fill(0);
            let header = BlockHeader {
                block,
                scale: [1.0; 3],
                nodes: 1,
                height: 1,
                nesting: 1,
                ..BlockHeader::zeroed()
            };
            into[..64].copy_from_slice(bytemuck::bytes_of(&header));
            into[BLOCK - 128..]
                .copy_from_slice(bytemuck::bytes_of(&crate::block::format::Node::EMPTY));
            let crc = checksum(&into[4..]);
            into[..4].copy_from_slice(&crc.to_le_bytes());
            if block == 3 {
                into[100] ^= 1;
            }
            Ok(())
        }
    }

    fn shelf(memory: &mut [Chunk], frames: usize) -> FetchedBlocks<'_, Shelf> {
        let cache = BlockCache::new(&mut Arena::new(memory), BLOCK, frames).unwrap();
        let limits = BlockLimits { block_bytes: BLOCK, blocks: 8, materials: 1 };
        FetchedBlocks::new(cache, Shelf { reads: Vec::new() }, limits)
    }

    #[test]
    fn a_block_is_read_once_while_it_stays() {
        let mut memory = vec![Chunk::ZERO; 64];
        let mut blocks = shelf(&mut memory, 2);
        for n in [0, 0, 1, 0, 1, 2, 1, 0] {
            assert_eq!(blocks.block(n).unwrap().number(), n);
        }
        // 2 takes the frame of 0, 0 that of 2.
        assert_eq!(blocks.medium.reads, [0, 1, 2, 0]);
        let counts = blocks.counts();
        assert_eq!((counts.hits, counts.misses, counts.fetched, counts.evictions), (4, 4, 4, 2));
    }

    #[test]
    fn what_is_damaged_or_missing_is_named_and_keeps_no_frame() {
        let mut memory = vec![Chunk::ZERO; 64];
        let mut blocks = shelf(&mut memory, 1);
        for _ in 0..3 {
            let error = blocks.block(3).unwrap_err();
            assert_eq!(error, FetchError::Refused { block: 3, error: BlockError::Checksum });
            let error = blocks.block(9).unwrap_err();
            assert_eq!(error, FetchError::Medium { block: 9, error: NoBlock(9) });
        }
        assert_eq!(blocks.block(2).unwrap().number(), 2);
        assert_eq!(
            shelf(&mut [Chunk::ZERO], 0).block(0).unwrap_err(),
            FetchError::Full { block: 0 }
        );
    }
}
