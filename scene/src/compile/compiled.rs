use kiloray_core::block::format::FileHeader;

use super::stats::Stats;
use crate::kilo::Image;
use crate::needs::Summary;

/// A compiled scene: the bytes of a `.kilo` file, and how they came to be.
#[derive(Debug)]
pub struct Compiled {
    /// The file in memory.
    pub image: Image,
    /// Counts and times.
    pub stats: Stats,
    /// What the scene needs, in words.
    pub summary: Summary,
}

impl Compiled {
    /// The bytes of the file; they begin at a multiple of 64 in memory.
    #[must_use]
    pub fn bytes(&self) -> &[u8] {
        self.image.bytes()
    }

    /// The header of the file.
    #[must_use]
    pub fn header(&self) -> &FileHeader {
        bytemuck::from_bytes(&self.bytes()[..size_of::<FileHeader>()])
    }
}
