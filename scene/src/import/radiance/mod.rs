//! Radiance scene descriptions (`.rad`).
//!
//! | part | what |
//! | --- | --- |
//! | `reader` | the stream of objects and commands |
//! | `kinds` | what a type word means |
//! | `material` | materials, in Radiance's units |
//! | `names` | what a modifier's name stands for |
//! | `surface` | surfaces |
//! | `command` | command lines: words, pipes |
//! | `xform` | transformations and arrays |
//! | `genbox` | boxes |
//!
//! Semantics are those of Radiance's reference manual and of `oconv`; `docs/formats.md` has the
//! differences.

mod command;
mod genbox;
mod kinds;
mod material;
mod names;
mod reader;
mod surface;
mod xform;

use std::path::Path;

use super::{ImportError, Limits};
use crate::model::Model;

pub(super) use names::Names;

/// Reads a file into the model. Its modifiers are added to `names`: the files of a command line
/// are read as one, as by `oconv`.
pub(super) fn read(
    model: &mut Model,
    names: &mut Names,
    path: &Path,
    limits: &Limits,
) -> Result<(), ImportError> {
    reader::Reader::new(model, names, limits).file(path)
}

#[cfg(test)]
mod tests;
