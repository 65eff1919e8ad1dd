use std::path::Path;

use thiserror::Error;

use crate::model::{ModelError, Note, Place};
use crate::regular;

/// A file cannot be read into a scene: `file:line: cause; what to do`, in one line.
#[derive(Debug, Error)]
pub struct ImportError {
    /// Where.
    pub place: Place,
    /// Why.
    #[source]
    pub cause: Cause,
    /// The place that included the file, if another did.
    pub from: Option<Place>,
    /// What was ignored or repaired before: it may be why nothing is left.
    pub notes: Vec<Note>,
}

/// Why a file cannot be read.
#[derive(Debug, Error)]
pub enum Cause {
    /// The system refuses.
    #[error("cannot be read: {}", regular::words(.0))]
    Read(#[from] std::io::Error),
    /// There is no such file.
    #[error("no such file")]
    Missing,
    /// The extension is none that is read.
    #[error("{0}")]
    Kind(&'static str),
    /// The file is not text.
    #[error("a binary file where text is expected")]
    Binary,
    /// Nothing was read.
    #[error("nothing to render in it: no surface and no light")]
    Empty,
    /// The text is not as the format demands.
    #[error("{0}")]
    Syntax(String),
    /// A command that is not built in.
    #[error(
        "the command `{0}` is not run; only xform and genbox are built in: expand it with Radiance's own xform first"
    )]
    Command(String),
    /// A bound of [`Limits`](super::Limits) is passed.
    #[error("{what}: the limit is {limit}")]
    Limit {
        /// What is too much.
        what: &'static str,
        /// How much is allowed.
        limit: u64,
    },
    /// The model cannot hold it.
    #[error(transparent)]
    Model(#[from] ModelError),
}

impl std::fmt::Display for ImportError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}: {}", self.place, self.cause)?;
        match &self.from {
            Some(from) => write!(f, " (included at {from})"),
            None => Ok(()),
        }
    }
}

impl ImportError {
    pub(super) fn new(place: Place, cause: impl Into<Cause>) -> Self {
        Self { place, cause: cause.into(), from: None, notes: Vec::new() }
    }
}

/// A syntax error.
pub(super) fn syntax(text: impl Into<String>) -> Cause {
    Cause::Syntax(text.into())
}

/// A place in a file, the file named as the user did; in one line, whatever the name holds.
pub(super) fn place(path: &Path, line: u64) -> Place {
    let name = path.to_string_lossy().replace(char::is_control, "?");
    Place { file: Some(name.into()), line }
}
