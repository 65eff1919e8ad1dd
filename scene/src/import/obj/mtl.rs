//! Materials of a mesh.

use std::path::Path;

use glam::DVec3;
use kiloray_core::scene::MaterialKind;

use super::{Cause, ImportError, place, shown, syntax};
use crate::import::scan::number;
use crate::model::{Emitter, IOR, Material, Model};

/// What a file says of a material; `None` where it says nothing.
#[derive(Debug, Default)]
struct Described {
    name: String,
    diffuse: Option<DVec3>,
    specular: Option<DVec3>,
    emission: Option<DVec3>,
    filter: Option<DVec3>,
    shininess: Option<f64>,
    ior: Option<f64>,
    /// 1 for opaque.
    dissolve: Option<f64>,
    model: Option<f64>,
}

/// Reads all materials of a file.
pub(super) fn read(
    model: &mut Model,
    text: &[u8],
    path: &Path,
) -> Result<Vec<Material>, ImportError> {
    let mut materials = Vec::new();
    let mut described: Option<Described> = None;
    for (line, number) in text.split(|&b| b == b'\n').zip(1u64..) {
        model.notes.set_line(number);
        let line = line.trim_ascii();
        if let Some(name) = line
            .strip_prefix(b"newmtl")
            .filter(|rest| rest.first().is_none_or(u8::is_ascii_whitespace))
        {
            let name = name.trim_ascii();
            if name.is_empty() {
                return Err(ImportError::new(place(path, number), syntax("newmtl without a name")));
            }
            materials.extend(described.take().map(|d| material(model, &d)));
            let name = String::from_utf8_lossy(name).into_owned();
            described = Some(Described { name, ..Described::default() });
        } else {
            let read = statement(model, described.as_mut(), line);
            read.map_err(|cause| ImportError::new(place(path, number), cause))?;
        }
    }
    materials.extend(described.map(|d| material(model, &d)));
    Ok(materials)
}

/// Reads a line within a material, or before the first.
fn statement(
    model: &mut Model,
    described: Option<&mut Described>,
    line: &[u8],
) -> Result<(), Cause> {
    let mut words = line.split(u8::is_ascii_whitespace).filter(|w| !w.is_empty());
    let Some(keyword) = words.next().filter(|w| !w.starts_with(b"#")) else { return Ok(()) };
    let words: Vec<&[u8]> = words.collect();
    let Some(d) = described else {
        model.note("a statement before the first newmtl: left out");
        return Ok(());
    };
    match keyword {
        b"Kd" => d.diffuse = color(model, &words)?.or(d.diffuse),
        b"Ks" => d.specular = color(model, &words)?.or(d.specular),
        b"Ke" => d.emission = color(model, &words)?.or(d.emission),
        b"Tf" => d.filter = color(model, &words)?.or(d.filter),
        b"Ns" => d.shininess = Some(positive(&words)?),
        b"Ni" => d.ior = Some(positive(&words)?),
        b"illum" => d.model = Some(positive(&words)?),
        // `d -halo 0.6`: more clear where seen face on.
        b"d" => {
            d.dissolve = Some(positive(words.strip_prefix(&[&b"-halo"[..]]).unwrap_or(&words))?)
        }
        b"Tr" => d.dissolve = Some(1.0 - positive(&words)?),
        b"bump" | b"disp" | b"decal" | b"refl" => {
            model.note("a texture of a material: left out, its plain colour is used");
        }
        [b'm', b'a', b'p', b'_', ..] | [b'n', b'o', b'r', b'm', ..] => {
            model.note("a texture of a material: left out, its plain colour is used");
        }
        // They have no meaning for a tracer of light.
        b"Ka" | b"sharpness" => {}
        _ => model.note("a statement about a material that is not read: left out"),
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
        [r, g, b, ..] => Ok(Some(DVec3::new(value(r)?, value(g)?, value(b)?))),
        _ => Err(syntax("a colour needs one number or three")),
    }
}

fn positive(words: &[&[u8]]) -> Result<f64, Cause> {
    let word = words.first().ok_or_else(|| syntax("a number is missing"))?;
    number(word).and_then(not_negative)
}

fn not_negative(value: f64) -> Result<f64, Cause> {
    if value < 0.0 {
        let text = format!("`{}` is below zero", shown(value.to_string().as_bytes()));
        return Err(syntax(text));
    }
    Ok(value)
}

/// From Wavefront's description to ours.
fn material(model: &mut Model, d: &Described) -> Material {
    let shares = [d.diffuse, d.specular, d.filter, d.dissolve.map(DVec3::splat)];
    if shares.iter().flatten().any(|share| share.max_element() > 1.0) {
        model.note("a share of light above 1 (Kd, Ks, Tf or d): taken as 1");
    }
    if d.model.is_some_and(|illum| illum > 10.0) {
        model.note("an illumination model above 10: taken as 2");
    }
    let kd = d.diffuse.unwrap_or(DVec3::splat(0.5));
    let ks = d.specular.unwrap_or(DVec3::ZERO);
    let filter = d.filter.unwrap_or(DVec3::ONE).min(DVec3::ONE);
    let opacity = d.dissolve.unwrap_or(1.0).clamp(0.0, 1.0);
    let given = d.ior.filter(|ior| IOR.contains(ior));
    if given != d.ior {
        model.note("an index of refraction (Ni) that is not from 0.01 to 100: taken as not given");
    }
    let ior = given.unwrap_or(1.5).max(1.0);
    let base = Material { name: d.name.clone(), ior, ..Material::default() };
    if let Some(emission) = d.emission.filter(|e| *e != DVec3::ZERO) {
        let emitter = Emitter::Sampled { reach: f64::INFINITY, cone: None };
        let kind = MaterialKind::Light;
        return Material { kind, diffuse: DVec3::ZERO, emission, emitter, ..base };
    }
    let illum = d.model.map_or(2, |m| m as u32);
    if opacity < 1.0 || matches!(illum, 4 | 6 | 7 | 9) {
        let clear = Material { diffuse: DVec3::ZERO, ..base };
        if given.is_some_and(|ior| ior > 1.0) {
            return Material { kind: MaterialKind::Dielectric, ..clear };
        }
        // Without refraction it is a pane. What a pane does not let through is lost, not scattered.
        let share = if opacity < 1.0 { 1.0 - opacity } else { 1.0 };
        return Material { kind: MaterialKind::Glass, transmit: filter * share, ior: 1.5, ..clear };
    }
    if illum == 5 || illum == 3 && kd == DVec3::ZERO && ks != DVec3::ZERO {
        let specular = if ks == DVec3::ZERO { DVec3::ONE } else { ks.min(DVec3::ONE) };
        return Material { kind: MaterialKind::Mirror, diffuse: DVec3::ZERO, specular, ..base };
    }
    // Models 0 and 1 have no highlight, whatever Ks says.
    let specular = if illum < 2 { DVec3::ZERO } else { ks.min(DVec3::ONE) };
    let mut diffuse = kd.min(DVec3::ONE);
    if (diffuse + specular).max_element() > 1.0 {
        model.note("a material that reflects more than it gets (Kd + Ks above 1): Kd reduced");
        diffuse = diffuse.min(DVec3::ONE - specular);
    }
    let roughness = (2.0 / (d.shininess.unwrap_or(0.0) + 2.0)).sqrt();
    Material { diffuse, specular, roughness, ..base }
}
