use kiloray_core::block::format::{BLOCK_BYTES_MAX, BLOCK_BYTES_MIN};

/// What the compiler may be told.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Options {
    /// Size of a block: a power of two from 1 to 64 KiB.
    pub block_bytes: usize,
    /// Lights in the table at most: each costs every node 80 bytes, and 96 for its part of their tree where they are more than 64.
    pub lights_max: usize,
}

impl Options {
    /// Blocks of a size \[bytes\], the rest by default.
    #[must_use]
    pub fn blocks_of(block_bytes: usize) -> Self {
        Self { block_bytes, ..Self::default() }
    }
}

impl Default for Options {
    /// Blocks of 16 KiB, and 65,536 lights (11 MiB with their tree).
    fn default() -> Self {
        Self { block_bytes: 16 << 10, lights_max: 1 << 16 }
    }
}

/// A stage of the compiler.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stage {
    /// Vertices are rounded and merged, primitives boxed.
    Surfaces,
    /// The tree is built.
    Tree,
    /// The tree is cut, and treelets are packed into blocks.
    Cut,
    /// The same again, as blocks were left too empty: once or twice.
    Recut,
    /// Blocks are written.
    Blocks,
}

impl Stage {
    /// One word for a progress bar.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Surfaces => "surfaces",
            Self::Tree => "tree",
            Self::Cut => "cut",
            Self::Recut => "fill",
            Self::Blocks => "blocks",
        }
    }
}

/// Hears how far the compiler is. `()` does not listen.
pub trait Progress {
    /// `done` of `total` steps of a stage are done.
    fn report(&mut self, stage: Stage, done: u64, total: u64);
}

impl Progress for () {
    fn report(&mut self, _: Stage, _: u64, _: u64) {}
}

impl<F: FnMut(Stage, u64, u64)> Progress for F {
    fn report(&mut self, stage: Stage, done: u64, total: u64) {
        self(stage, done, total);
    }
}

/// Why a model cannot be compiled.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum CompileError {
    /// The size of a block is not one of the seven.
    #[error("a block of {0} bytes: the size must be a power of two from 1024 to 65536")]
    BlockBytes(usize),
    /// More than the file's 32-bit numbers count.
    #[error("{count} {what}: {limit} at most")]
    TooMany {
        /// Of what.
        what: &'static str,
        /// How many there are.
        count: u64,
        /// How many there may be.
        limit: u64,
    },
    /// More lights than the table has room for: emissive faces are a light each.
    #[error("{count} lights: {limit} at most")]
    Lights {
        /// How many light a surface.
        count: usize,
        /// How many there may be.
        limit: usize,
    },
    /// A surface or light names a material, vertex or normal that the model does not have.
    #[error("{what} {index} is missing: the model has {len}")]
    Missing {
        /// Of what.
        what: &'static str,
        /// Which one.
        index: u64,
        /// How many there are.
        len: u64,
    },
}

impl Options {
    /// Checks the options.
    ///
    /// # Errors
    ///
    /// [`CompileError::BlockBytes`].
    pub fn check(&self) -> Result<(), CompileError> {
        let bytes = self.block_bytes;
        if bytes.is_power_of_two() && (BLOCK_BYTES_MIN..=BLOCK_BYTES_MAX).contains(&bytes) {
            Ok(())
        } else {
            Err(CompileError::BlockBytes(bytes))
        }
    }
}
