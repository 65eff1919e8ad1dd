use kiloray_core::block::{FileError, NoBlock};
use kiloray_core::render::RenderError;
use kiloray_core::store::{ArenaFull, BudgetError, FetchError};

/// Why a view has no picture of a size.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum PictureError {
    /// The picture has no pixels, or more than the memory of this machine can name.
    #[error("a picture of {width} × {height} pixels cannot be made")]
    Size {
        /// Columns.
        width: u32,
        /// Rows.
        height: u32,
    },
    /// The view shows nothing.
    #[error("the view shows nothing: its size, direction or up vector makes no sense")]
    View,
}

/// Why there is no picture.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// There is no such picture.
    #[error(transparent)]
    Picture(#[from] PictureError),
    /// The memory is too small.
    #[error("{0}")]
    Budget(#[from] BudgetError),
    /// The plan and the renderer disagree.
    #[error("{0}")]
    Arena(#[from] ArenaFull),
    /// The file is not sound.
    #[error("{0}")]
    File(#[from] FileError),
    /// A block could not be had.
    #[error("{0}")]
    Blocks(RenderError<FetchError<NoBlock>>),
    /// Threads cannot be started.
    #[error("cannot start {threads} threads: {cause}")]
    Threads {
        /// How many.
        threads: usize,
        /// Why.
        cause: String,
    },
    /// It was told to stop.
    #[error("cancelled")]
    Cancelled,
}

impl From<RenderError<FetchError<NoBlock>>> for Error {
    fn from(error: RenderError<FetchError<NoBlock>>) -> Self {
        match error {
            RenderError::Cancelled => Self::Cancelled,
            error => Self::Blocks(error),
        }
    }
}
