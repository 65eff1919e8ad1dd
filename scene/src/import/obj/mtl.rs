//! What a file says of materials.

use std::path::Path;

use glam::DVec3;

use super::library::DEFINED_MAX;
use super::lines::{Lines, name, words};
use super::{Cause, ImportError, material, place, shown, syntax};
use crate::import::scan::number;
use crate::model::{Material, Model};

/// What a file says of a material; `None` where it says nothing.
#[derive(Debug, Default)]
pub(super) struct Described {
    pub(super) name: String,
    /// Where it begins.
    line: u64,
    pub(super) diffuse: Option<DVec3>,
    pub(super) specular: Option<DVec3>,
    pub(super) emission: Option<DVec3>,
    pub(super) filter: Option<DVec3>,
    pub(super) shininess: Option<f64>,
    pub(super) ior: Option<f64>,
    /// 1 for opaque (`d`).
    pub(super) dissolve: Option<f64>,
    /// 0 for opaque (`Tr`).
    pub(super) transparency: Option<f64>,
    pub(super) model: Option<f64>,
}

/// Reads all materials of a file.
pub(super) fn read(
    model: &mut Model,
    text: &[u8],
    path: &Path,
) -> Result<Vec<Material>, ImportError> {
    let mut materials = Vec::new();
    let mut described: Option<Described> = None;
    for line in Lines::new(text) {
        model.notes.set_line(line.first);
        let here = |cause| ImportError::new(place(path, line.last), cause);
        if words(&line.text).next() == Some(b"newmtl") {
            let name = name(&line.text, b"newmtl");
            if name.is_empty() {
                return Err(here(syntax("newmtl without a name")));
            }
            if materials.len() >= DEFINED_MAX {
                let limit = DEFINED_MAX as u64;
                return Err(here(Cause::Limit { what: "too many materials in all", limit }));
            }
            let name = String::from_utf8_lossy(name).into_owned();
            let begun = Described { name, line: line.first, ..Described::default() };
            if let Some(known) = described.replace(begun) {
                materials.push(finished(model, &known, path)?);
            }
        } else {
            statement(model, described.as_mut(), &line.text).map_err(here)?;
        }
    }
    if let Some(last) = described {
        materials.push(finished(model, &last, path)?);
    }
    Ok(materials)
}

/// The material of a description; notes and errors are of the line where it begins.
fn finished(model: &mut Model, d: &Described, path: &Path) -> Result<Material, ImportError> {
    let outer = model.notes.place().line;
    model.notes.set_line(d.line);
    let material = material::material(model, d);
    model.notes.set_line(outer);
    material.check().map_err(|e| ImportError::new(place(path, d.line), e))?;
    Ok(material)
}

/// Reads a line within a material, or before the first.
fn statement(
    model: &mut Model,
    described: Option<&mut Described>,
    line: &[u8],
) -> Result<(), Cause> {
    let mut words = words(line);
    let Some(keyword) = words.next() else { return Ok(()) };
    let mut words: Vec<&[u8]> = words.collect();
    let Some(d) = described else {
        model.note("a statement before the first newmtl: left out");
        return Ok(());
    };
    match keyword {
        b"Kd" => d.diffuse = color(model, &words)?.or(d.diffuse),
        b"Ks" => d.specular = color(model, &words)?.or(d.specular),
        b"Ke" => d.emission = color(model, &words)?.or(d.emission),
        b"Tf" => d.filter = color(model, &words)?.or(d.filter),
        b"Ka" => {
            if color(model, &words)?.is_some_and(|ka| ka != DVec3::ZERO) {
                model.note("an ambient colour (Ka): left out, all light comes from lights");
            }
        }
        b"Ns" => d.shininess = Some(positive(model, &words)?),
        b"Ni" => d.ior = Some(positive(model, &words)?),
        b"illum" => d.model = Some(positive(model, &words)?),
        b"d" => {
            if words.first() == Some(&&b"-halo"[..]) {
                model.note("`d -halo` (more clear where seen face on): as clear from all sides");
                words.remove(0);
            }
            d.dissolve = Some(positive(model, &words)?);
        }
        b"Tr" => d.transparency = Some(positive(model, &words)?),
        b"bump" | b"disp" | b"decal" | b"refl" | [b'm', b'a', b'p', b'_', ..] | b"norm" => {
            let text = "a texture of a material: left out, its plain colour is used";
            model.notes.add_named(text, &shown(keyword));
        }
        _ => {
            let text = "a statement about a material that is not read: left out";
            model.notes.add_named(text, &shown(keyword));
        }
    }
    Ok(())
}

/// Three numbers, or one for all; `None` for what is no colour of three channels.
fn color(model: &mut Model, words: &[&[u8]]) -> Result<Option<DVec3>, Cause> {
    let value = |word: &&[u8]| number(word).and_then(not_negative);
    match words {
        [b"spectral" | b"xyz", ..] => {
            model.note("a colour by spectrum or CIE xyz: left out");
            Ok(None)
        }
        [all] => Ok(Some(DVec3::splat(value(all)?))),
        [r, g, b, more @ ..] => {
            surplus(model, more);
            Ok(Some(DVec3::new(value(r)?, value(g)?, value(b)?)))
        }
        _ => Err(syntax("a colour needs one number or three")),
    }
}

fn positive(model: &mut Model, words: &[&[u8]]) -> Result<f64, Cause> {
    let (word, more) = words.split_first().ok_or_else(|| syntax("a number is missing"))?;
    surplus(model, more);
    number(word).and_then(not_negative)
}

/// Counts words that no statement takes.
fn surplus(model: &mut Model, words: &[&[u8]]) {
    if !words.is_empty() {
        model.note("words behind all that a statement takes: left out");
    }
}

fn not_negative(value: f64) -> Result<f64, Cause> {
    if value < 0.0 {
        let text = format!("`{}` is below zero", shown(value.to_string().as_bytes()));
        return Err(syntax(text));
    }
    Ok(value)
}
