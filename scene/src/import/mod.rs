//! Readers of scene files: Radiance (`.rad`, `.vf`) and Wavefront (`.obj`, `.mtl`).
//!
//! [`load`] makes one scene of several files. Whatever is wrong with a file is an [`ImportError`] of
//! one line, `file:line: cause`; what is ignored or repaired is counted in
//! [`Model::notes`](crate::model::Model::notes), and stands in the error too if there is one.
//!
//! # Defaults
//!
//! A scene without a view gets one that frames its bounds, seen from the front and a little from
//! above; a scene in which nothing emits light gets a pale sky and a sun behind the viewer's left
//! shoulder. Both are noted. Meshes alone (`.obj`, in letters of any case) have y upwards, else it is z.
//!
//! # Bounds
//!
//! [`Limits`] holds every bound: memory is at most that of the text of all files, each read once,
//! and of the surfaces. Nesting of files is bounded, a file that includes itself is refused, and
//! nothing is ever run as a command.

mod defaults;
mod error;
mod limits;
mod obj;
mod radiance;
mod scan;
mod text;
mod view;

use std::path::Path;

use kiloray_core::scene::MaterialKind;

pub use error::{Cause, ImportError};
pub use limits::Limits;
pub use view::view;

use crate::model::{Model, Place};

/// How files are read.
#[derive(Debug, Clone, Default)]
pub struct ImportOptions {
    /// What is refused as too much.
    pub limits: Limits,
    /// Leaves out the default light and view.
    pub bare: bool,
}

/// Reads files into one scene, in their order; the kind of each is told by its extension.
///
/// # Errors
/// If a file cannot be read or is not as its format demands, or if the scene is empty.
pub fn load<P: AsRef<Path>>(paths: &[P], options: &ImportOptions) -> Result<Model, ImportError> {
    let mut model = Model::default();
    match read(&mut model, paths, options) {
        Ok(()) => Ok(model),
        Err(error) => Err(ImportError { notes: model.notes.iter().cloned().collect(), ..error }),
    }
}

fn read<P: AsRef<Path>>(
    model: &mut Model,
    paths: &[P],
    options: &ImportOptions,
) -> Result<(), ImportError> {
    let mut names = radiance::Names::default();
    for path in paths {
        let path = path.as_ref();
        let kind = path.extension().and_then(|e| e.to_str()).unwrap_or_default();
        match kind.to_ascii_lowercase().as_str() {
            "rad" | "mat" => radiance::read(model, &mut names, path, &options.limits)?,
            "vf" => view::read(model, path, &options.limits)?,
            "obj" => obj::read(model, path, &options.limits)?,
            other => return Err(refusal(path, other)),
        }
    }
    model.notes.set_place(Place::default());
    if model.triangles.is_empty() && model.spheres.is_empty() && model.lights.is_empty() {
        let place = paths.first().map_or_else(Place::default, |p| error::place(p.as_ref(), 0));
        return Err(ImportError::new(place, Cause::Empty));
    }
    if !options.bare {
        let mesh = |e: &std::ffi::OsStr| e.eq_ignore_ascii_case("obj");
        let upright = paths.iter().any(|p| p.as_ref().extension().is_some_and(|e| !mesh(e)));
        defaults::complete(model, upright);
    }
    if defaults::lit(model) {
        dead_mirrors(model);
    }
    Ok(())
}

/// Says that mirrors throw no light of lamps on: Radiance makes virtual lights behind them.
fn dead_mirrors(model: &mut Model) {
    let Model { materials, notes, .. } = model;
    for mirror in materials.iter().filter(|m| m.kind == MaterialKind::Mirror) {
        let text = "a mirror in a scene with lights: they are seen in it, but it throws none of their light on (no virtual lights)";
        notes.add_named(text, &scan::shown(mirror.name.as_bytes()));
    }
}

/// Why a file of this kind is not read.
fn refusal(path: &Path, kind: &str) -> ImportError {
    let hint = match kind {
        "mtl" => "materials alone: name the .obj file that uses them",
        "oct" => "a compiled Radiance octree: name the .rad files that it was made from",
        "kilo" => "a compiled scene stands alone: name it as the only file",
        _ => "not a kind of file that is read: .rad, .vf, .obj, or a compiled .kilo",
    };
    let missing = !path.exists();
    let cause = if missing { Cause::Missing } else { Cause::Kind(hint) };
    ImportError::new(error::place(path, 0), cause)
}

#[cfg(test)]
mod tests;
