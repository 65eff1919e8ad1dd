use std::io;
use std::path::{Path, PathBuf};

use kiloray_core::block::{FileError, KiloView};
use memmap2::Mmap;

use super::image::Image;
use super::tree::check_blocks;
use crate::compile::Compiled;
use crate::regular;

/// A `.kilo` file: from the disk, checked in full or as far as [`map`](Self::map) does, or straight from the compiler.
#[derive(Debug)]
pub struct KiloFile {
    bytes: Bytes,
}

#[derive(Debug)]
enum Bytes {
    Mapped(Mmap),
    Owned(Image),
}

/// Why a file cannot be used.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum KiloError {
    /// It cannot be opened, read, mapped or written.
    #[error("{}: {}", path.display(), regular::words(source))]
    Io {
        /// Its path.
        path: PathBuf,
        /// What the system says.
        source: io::Error,
    },
    /// Its bytes are refused.
    #[error("{}: {error}", path.display())]
    Damaged {
        /// Its path.
        path: PathBuf,
        /// What is wrong.
        error: FileError,
    },
    /// The bytes of a file in memory are refused.
    #[error("{0}")]
    Refused(FileError),
}

impl KiloFile {
    /// Maps a file and checks all of it.
    ///
    /// # Errors
    ///
    /// [`KiloError::Io`] or [`KiloError::Damaged`].
    pub fn open(path: &Path) -> Result<Self, KiloError> {
        let file = Self::map(path)?;
        file.check().map_err(|error| KiloError::Damaged { path: path.into(), error })?;
        Ok(file)
    }

    /// Maps a file and checks its header and tables alone: for who reads only some of its blocks, and checks those
    /// ([`KiloView::check_block`]).
    ///
    /// # Errors
    ///
    /// [`KiloError::Io`] or [`KiloError::Damaged`].
    pub fn map(path: &Path) -> Result<Self, KiloError> {
        let io = |source| KiloError::Io { path: path.into(), source };
        let file = regular::open(path).map_err(io)?;
        let len = file.metadata().map_err(io)?.len();
        let bytes = if len == 0 {
            // Nothing cannot be mapped everywhere.
            Bytes::Owned(Image::copy_of(&[]))
        } else {
            // SAFETY: the map is read-only and private to this value. If another process changes
            // the file meanwhile, the bytes change: every reader of `KiloView` works on whatever
            // bytes there are (`BlockView::trusted` says so), and none is a reference to a type
            // for which some bytes are invalid. A file that is made shorter ends the process with
            // a signal, as with every program that maps its input.
            Bytes::Mapped(unsafe { Mmap::map(&file) }.map_err(io)?)
        };
        let file = Self { bytes };
        KiloView::parse(file.bytes())
            .map_err(|error| KiloError::Damaged { path: path.into(), error })?;
        Ok(file)
    }

    /// A compiled scene without a way over the disk.
    #[must_use]
    pub fn from_compiled(compiled: Compiled) -> Self {
        Self { bytes: Bytes::Owned(compiled.image) }
    }

    /// Copies the bytes of a file, and checks all of them.
    ///
    /// # Errors
    ///
    /// [`KiloError::Refused`].
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, KiloError> {
        let file = Self { bytes: Bytes::Owned(Image::copy_of(bytes)) };
        file.check().map_err(KiloError::Refused)?;
        Ok(file)
    }

    /// Writes the file: to a temporary name beside `path`, which is then renamed. Nothing
    /// half-written is ever found under `path`.
    ///
    /// # Errors
    ///
    /// [`KiloError::Io`], with what the system says: the disk is full, the directory is missing.
    pub fn write(&self, path: &Path) -> Result<(), KiloError> {
        super::write::write_whole(path, self.bytes())
            .map_err(|source| KiloError::Io { path: path.into(), source })
    }

    /// The bytes of the file; they begin at a multiple of 64 in memory.
    #[must_use]
    pub fn bytes(&self) -> &[u8] {
        match &self.bytes {
            Bytes::Mapped(map) => map,
            Bytes::Owned(image) => image.bytes(),
        }
    }

    /// The file's content.
    ///
    /// # Panics
    ///
    /// If the mapped file was changed since it was opened so that its header is refused now.
    #[must_use]
    pub fn view(&self) -> KiloView<'_> {
        match KiloView::parse(self.bytes()) {
            Ok(view) => view,
            Err(error) => panic!("the file was changed while it was in use: {error}"),
        }
    }

    fn check(&self) -> Result<(), FileError> {
        check_blocks(&KiloView::parse(self.bytes())?)
    }
}
