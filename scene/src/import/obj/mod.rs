//! Wavefront meshes (`.obj`) and their materials (`.mtl`).
//!
//! | part | what |
//! | --- | --- |
//! | `lines` | lines that join, words, names, comments |
//! | `mesh` | vertices and faces |
//! | `library` | which material a name means |
//! | `mtl` | what a file says of materials |
//! | `material` | what that is here |
//!
//! `docs/formats.md` tells what is read, what is left out and counted, and what becomes of a
//! material; `ARCHITECTURE.md` why this reader is our own.

mod library;
mod lines;
mod material;
mod mesh;
mod mtl;

use std::path::Path;

use super::error::{place, syntax};
use super::scan::shown;
use super::{Cause, ImportError, Limits, defaults, text};
use crate::model::Model;

/// Reads a file into the model.
pub(super) fn read(model: &mut Model, path: &Path, limits: &Limits) -> Result<(), ImportError> {
    let text = text::read(model, path, limits).map_err(|c| ImportError::new(place(path, 0), c))?;
    model.notes.set_place(place(path, 0));
    mesh::read(model, &text, path, &mut library::Library::new(path, limits))
}

/// In this line, or in a file that it names.
enum Failure {
    Here(Cause),
    Elsewhere(Box<ImportError>),
}

impl<C: Into<Cause>> From<C> for Failure {
    fn from(cause: C) -> Self {
        Self::Here(cause.into())
    }
}

#[cfg(test)]
mod tests;
