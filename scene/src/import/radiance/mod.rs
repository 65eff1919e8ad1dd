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
//! Semantics are those of Radiance's reference manual and of `oconv`, with these differences:
//! - patterns and textures are left out: what they modify is given the material that they modify;
//!   of a mixture the foreground is taken;
//! - materials that are not built in (`BSDF` and the like) become grey;
//! - `instance` and `mesh` are refused, for the picture would lack what they hold;
//! - a surface whose modifier is `void` is nothing to see, as in Radiance, and dropped with a note.
//!
//! A file named by `!xform` is sought in the directory of the file that names it, then in the current directory, where Radiance looks.

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
