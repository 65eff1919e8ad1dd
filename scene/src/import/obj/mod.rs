//! Wavefront meshes (`.obj`) and their materials (`.mtl`).
//!
//! Both are read here. The usual crate, `tobj` (4.0.5), names no line of an error, makes up normals
//! for faces without, does arithmetic on unchecked indices, and panics at a `Ks` without numbers.
//!
//! - `v`, `vn`, `f` (also with negative indices), `usemtl`, `mtllib` are read; `vt`, groups,
//!   objects and smoothing groups have no effect; points, lines and free-form surfaces are left
//!   out and counted;
//! - faces of more than three corners are cut as [`Model::add_polygon_face`] cuts polygons;
//! - a face has shading normals only if all its corners name one;
//! - a missing material file, or a missing material, gives the default: grey, reflectance ½.
//!
//! Materials: `Kd` is diffuse reflectance, `Ks` specular reflectance with a roughness of
//! `sqrt(2 / (Ns + 2))`, for which Ward's lobe is as wide as Blinn's of exponent `Ns`; `Ke` is emitted
//! radiance. `illum 5`, or 3 with a black `Kd`, is a mirror. `d` below 1 (`Tr` above 0), or `illum`
//! 4, 6, 7 or 9, is clear: a dielectric of index `Ni` if that is given and above 1, else a thin pane
//! that lets `Tf` times `1 - d` through (all of `Tf` where `d` is 1).
//! An `Ni` that is not from 0.01 to 100 is taken as not given. Textures are left out and counted.

mod mesh;
mod mtl;

use std::collections::{HashMap, HashSet};
use std::path::Path;

use super::error::{place, syntax};
use super::scan::shown;
use super::{Cause, ImportError, Limits, defaults, text};
use crate::model::{Material, Model};

/// Reads a file into the model.
pub(super) fn read(model: &mut Model, path: &Path, limits: &Limits) -> Result<(), ImportError> {
    let text = text::read(path, limits).map_err(|c| ImportError::new(place(path, 0), c))?;
    model.notes.set_place(place(path, 0));
    let mut materials = Materials {
        limits,
        path,
        known: HashMap::new(),
        files: HashSet::new(),
        text_bytes: 0,
        fallback: None,
    };
    mesh::read(model, &text, path, &mut materials)
}

/// The materials of a mesh, entered into the model as they are used.
struct Materials<'a> {
    limits: &'a Limits,
    path: &'a Path,
    known: HashMap<Vec<u8>, (Material, Option<u16>)>,
    /// The files read so far: each counts once.
    files: HashSet<Vec<u8>>,
    text_bytes: u64,
    /// The index of the default.
    fallback: Option<u16>,
}

impl Materials<'_> {
    /// Reads a file of materials; a missing one is noted.
    fn read(&mut self, model: &mut Model, name: &[u8]) -> Result<(), ImportError> {
        if !self.files.insert(name.to_owned()) {
            return Ok(());
        }
        let file = Path::new(std::str::from_utf8(name).unwrap_or_default());
        let file = self.path.parent().unwrap_or(Path::new("")).join(file);
        let text = match text::read(&file, self.limits) {
            Ok(text) => text,
            Err(Cause::Missing) => {
                let text = "a file of materials is missing: grey instead";
                model.notes.add_named(text, &shown(name));
                return Ok(());
            }
            Err(cause) => return Err(ImportError::new(place(&file, 0), cause)),
        };
        self.text_bytes = self.text_bytes.saturating_add(text.len() as u64);
        if self.text_bytes > self.limits.text_bytes {
            let limit = self.limits.text_bytes;
            let cause = Cause::Limit { what: "too much text in all [bytes]", limit };
            return Err(ImportError::new(place(&file, 0), cause));
        }
        let outer = model.notes.place().clone();
        model.notes.set_place(place(&file, 0));
        for material in mtl::read(model, &text, &file)? {
            self.known.insert(material.name.clone().into_bytes(), (material, None));
        }
        model.notes.set_place(outer);
        Ok(())
    }

    /// The index of a material by name; that of the default if there is none of that name.
    fn index(&mut self, model: &mut Model, name: Option<&[u8]>) -> Result<u16, Cause> {
        if let Some(name) = name {
            if let Some((material, index)) = self.known.get_mut(name) {
                if index.is_none() {
                    *index = Some(model.add_material(material.clone())?);
                }
                if let Some(index) = *index {
                    return Ok(index);
                }
            }
            let text = "a material is not defined: grey instead";
            model.notes.add_named(text, &shown(name));
        }
        match self.fallback {
            Some(index) => Ok(index),
            None => {
                let index = model.add_material(defaults::material())?;
                self.fallback = Some(index);
                Ok(index)
            }
        }
    }
}

#[cfg(test)]
mod tests;
