//! Materials of a mesh.

use std::cell::Cell;
use std::io::{BufRead, Read};
use std::path::Path;

use glam::DVec3;
use kiloray_core::scene::MaterialKind;

use super::{ImportError, place, shown, syntax};
use crate::model::{Emitter, Material, Model};

/// Reads all materials of a file.
pub(super) fn read(
    model: &mut Model,
    text: &[u8],
    path: &Path,
) -> Result<Vec<Material>, ImportError> {
    let line = Cell::new(0);
    let mut lines = Lines { text, line: &line };
    let read = tobj::load_mtl_buf(&mut lines);
    let at = |line: u64| place(path, line);
    let (found, _) = read.map_err(|error| {
        let text = text.split(|&b| b == b'\n').nth(line.get().saturating_sub(1) as usize);
        let text = shown(text.unwrap_or_default().trim_ascii());
        ImportError::new(at(line.get()), syntax(format!("{error}: `{text}`")))
    })?;
    let mut materials = Vec::with_capacity(found.len());
    for m in &found {
        let made = material(model, m).map_err(|what| {
            // Names come in the order of the file, but the reader keeps no line of theirs.
            let named = |l: &[u8]| {
                let l = l.trim_ascii();
                l.strip_prefix(b"newmtl").is_some_and(|l| l.trim_ascii() == m.name.as_bytes())
            };
            let line = text.split(|&b| b == b'\n').position(named).map_or(0, |i| i as u64 + 1);
            let name = shown(m.name.as_bytes());
            ImportError::new(at(line), syntax(format!("material `{name}`: {what}")))
        })?;
        materials.push(made);
    }
    Ok(materials)
}

/// Gives one line at a time, so that the line of an error is known.
struct Lines<'a> {
    text: &'a [u8],
    line: &'a Cell<u64>,
}

impl Read for Lines<'_> {
    fn read(&mut self, to: &mut [u8]) -> std::io::Result<usize> {
        self.text.read(to)
    }
}

impl BufRead for Lines<'_> {
    fn fill_buf(&mut self) -> std::io::Result<&[u8]> {
        let end = self.text.iter().position(|&b| b == b'\n').map(|i| i + 1);
        if !self.text.is_empty() {
            self.line.set(self.line.get() + 1);
        }
        Ok(self.text.get(..end.unwrap_or(self.text.len())).unwrap_or_default())
    }

    fn consume(&mut self, amount: usize) {
        self.text = self.text.get(amount..).unwrap_or_default();
    }
}

/// From Wavefront's description to ours.
fn material(model: &mut Model, m: &tobj::Material) -> Result<Material, &'static str> {
    let color = |c: Option<[f64; 3]>, other: DVec3| c.map_or(other, DVec3::from);
    let kd = color(m.diffuse, DVec3::splat(0.5));
    let ks = color(m.specular, DVec3::ZERO);
    let ke = color(m.emissive, DVec3::ZERO);
    let listed = |key: &str| m.unknown_param.get(key).map(String::as_str);
    let tf = listed("Tf").and_then(color_of).unwrap_or(DVec3::ONE);
    let tr = listed("Tr").and_then(|t| t.parse::<f64>().ok()).unwrap_or(0.0);
    let opacity = m.dissolve.unwrap_or(1.0 - tr);
    let shininess = m.shininess.unwrap_or(0.0);
    let ior = m.optical_density.unwrap_or(1.5);
    let scalars = [opacity, shininess, ior];
    if ![kd, ks, ke, tf].iter().all(|c| c.is_finite()) || !scalars.iter().all(|x| x.is_finite()) {
        return Err("a value is not a finite number");
    }
    if [kd, ks, ke, tf].iter().any(|c| c.min_element() < 0.0) || shininess < 0.0 || ior < 0.0 {
        return Err("a value is below zero");
    }
    for texture in [
        &m.ambient_texture,
        &m.diffuse_texture,
        &m.specular_texture,
        &m.normal_texture,
        &m.shininess_texture,
        &m.dissolve_texture,
    ] {
        if texture.is_some() {
            model.note("a texture of a material: left out, its plain colour is used");
        }
    }
    let base = Material { name: m.name.clone(), ior: ior.max(1.0), ..Material::default() };
    if ke != DVec3::ZERO {
        let emitter = Emitter::Sampled { reach: f64::INFINITY, cone: None };
        let kind = MaterialKind::Light;
        return Ok(Material { kind, diffuse: DVec3::ZERO, emission: ke, emitter, ..base });
    }
    let illum = m.illumination_model.unwrap_or(2);
    if opacity < 1.0 || matches!(illum, 4 | 6 | 7 | 9) {
        let clear = Material { diffuse: DVec3::ZERO, ..base };
        // Without refraction it is a pane. What a pane does not let through is lost, not scattered.
        return Ok(if ior <= 1.0 || m.optical_density.is_none() {
            let transmit = tf.min(DVec3::ONE) * (1.0 - opacity.clamp(0.0, 1.0));
            let transmit = if opacity >= 1.0 { tf.min(DVec3::ONE) } else { transmit };
            Material { kind: MaterialKind::Glass, transmit, ior: 1.5, ..clear }
        } else {
            Material { kind: MaterialKind::Dielectric, ..clear }
        });
    }
    if illum == 5 || illum == 3 && kd == DVec3::ZERO && ks != DVec3::ZERO {
        let specular = if ks == DVec3::ZERO { DVec3::ONE } else { ks.min(DVec3::ONE) };
        return Ok(Material { kind: MaterialKind::Mirror, diffuse: DVec3::ZERO, specular, ..base });
    }
    // Models 0 and 1 have no highlight, whatever Ks says.
    let specular = if illum < 2 { DVec3::ZERO } else { ks.min(DVec3::ONE) };
    let mut diffuse = kd.min(DVec3::ONE);
    let most = (diffuse + specular).max_element();
    if most > 1.0 {
        model.note("a material that reflects more than it gets (Kd + Ks above 1): Kd reduced");
        diffuse = diffuse.min(DVec3::ONE - specular);
    }
    let roughness = (2.0 / (shininess + 2.0)).sqrt();
    Ok(Material { diffuse, specular, roughness, ..base })
}

/// One number for all channels, or three.
fn color_of(text: &str) -> Option<DVec3> {
    let mut words = text.split_whitespace().map(|w| w.parse::<f64>().ok());
    let first = words.next()??;
    match (words.next(), words.next()) {
        (None, _) => Some(DVec3::splat(first)),
        (Some(g), Some(b)) => Some(DVec3::new(first, g?, b?)),
        _ => None,
    }
}
