//! From Wavefront's description of a material to ours: `docs/formats.md` has the table.

use glam::DVec3;
use kiloray_core::scene::MaterialKind;

use super::mtl::Described;
use crate::model::{Emitter, IOR, Material, Model};

/// Illumination models of what refracts, or stands for it.
const GLASS: [u32; 4] = [4, 6, 7, 9];

/// Makes the material, and counts what of it is left out.
pub(super) fn material(model: &mut Model, d: &Described) -> Material {
    let shares = [d.diffuse, d.specular, d.filter, d.dissolve.map(DVec3::splat)];
    let clear = d.transparency.map(DVec3::splat);
    if shares.iter().chain([&clear]).flatten().any(|share| share.max_element() > 1.0) {
        model.note("a share of light above 1 (Kd, Ks, Tf, d or Tr): taken as 1");
    }
    if d.model.is_some_and(|illum| illum > 10.0) {
        model.note("an illumination model above 10: taken as 2");
    }
    let illum = d.model.filter(|illum| *illum <= 10.0).map_or(2, |illum| illum as u32);
    let clear = d.transparency.map(|tr| 1.0 - tr.min(1.0));
    let opacity = d.dissolve.map(|d| d.min(1.0)).or(clear).unwrap_or(1.0);
    if clear.is_some_and(|clear| (clear - opacity).abs() > 1e-3) {
        model.note("`d` and `Tr` of a material that do not add up to 1: `d` counts");
    }
    let given = d.ior.filter(|ior| IOR.contains(ior));
    if given != d.ior {
        model.note("an index of refraction (Ni) that is not from 0.01 to 100: taken as not given");
    }
    let base = Material { name: d.name.clone(), ..Material::default() };
    if let Some(emission) = d.emission.filter(|e| *e != DVec3::ZERO) {
        return lamp(model, d, base, emission, opacity < 1.0 || GLASS.contains(&illum));
    }
    let filter = d.filter.unwrap_or(DVec3::ONE).min(DVec3::ONE);
    if GLASS.contains(&illum) {
        return glass(model, d, base, filter, opacity, given.filter(|ior| *ior > 1.0));
    }
    let opaque = opaque(model, d, base, illum);
    if opacity < 1.0 { faded(model, opaque, filter, opacity) } else { opaque }
}

/// A colour is given that is not black.
fn shows(color: Option<DVec3>) -> bool {
    color.is_some_and(|c| c != DVec3::ZERO)
}

/// A lamp emits, and does nothing else.
fn lamp(
    model: &mut Model,
    d: &Described,
    base: Material,
    emission: DVec3,
    clear: bool,
) -> Material {
    if shows(d.diffuse) || shows(d.specular) || clear {
        model
            .note("what a material that emits (Ke) reflects or lets through (Kd, Ks, d): left out");
    }
    let emitter = Emitter::Sampled { reach: f64::INFINITY, cone: None };
    Material { kind: MaterialKind::Light, diffuse: DVec3::ZERO, emission, emitter, ..base }
}

/// A dielectric of index `ior`, or a pane without one.
fn glass(
    model: &mut Model,
    d: &Described,
    base: Material,
    filter: DVec3,
    opacity: f64,
    ior: Option<f64>,
) -> Material {
    if shows(d.diffuse) {
        model.note("the diffuse colour (Kd) of glass (illum 4, 6, 7 or 9): left out");
    }
    let base = Material { diffuse: DVec3::ZERO, ..base };
    if let Some(ior) = ior {
        if filter != DVec3::ONE || opacity < 1.0 {
            model.note("a filter (Tf or d) of glass that refracts: left out, it is clear");
        }
        return Material { kind: MaterialKind::Dielectric, ior, ..base };
    }
    // What a pane does not let through is lost, not scattered.
    let share = if opacity < 1.0 { 1.0 - opacity } else { 1.0 };
    Material { kind: MaterialKind::Glass, transmit: filter * share, ..base }
}

/// A mirror, or a diffuse surface with a highlight.
fn opaque(model: &mut Model, d: &Described, base: Material, illum: u32) -> Material {
    let kd = d.diffuse.unwrap_or(DVec3::splat(0.5));
    let ks = d.specular.unwrap_or(DVec3::ZERO);
    if illum == 5 || illum == 3 && kd == DVec3::ZERO && ks != DVec3::ZERO {
        if shows(d.diffuse) {
            model.note("the diffuse colour (Kd) of a mirror (illum 5): left out");
        }
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
    // Ward's lobe of this roughness is as wide as Blinn's of exponent Ns.
    let roughness = (2.0 / (d.shininess.unwrap_or(0.0) + 2.0)).sqrt();
    Material { diffuse, specular, roughness, ..base }
}

/// A surface of which `opacity` is there: the rest lets light straight through, as Radiance's trans
/// without roughness.
fn faded(model: &mut Model, surface: Material, filter: DVec3, opacity: f64) -> Material {
    let mirror = surface.kind == MaterialKind::Mirror;
    if !mirror && surface.specular != DVec3::ZERO {
        model.note(
            "the highlight (Ks) of a surface that is partly clear (d below 1): left out, it would blur what is seen through it",
        );
    }
    Material {
        kind: MaterialKind::Opaque,
        diffuse: surface.diffuse * opacity,
        specular: if mirror { surface.specular * opacity } else { DVec3::ZERO },
        roughness: 0.0,
        transmit: filter * (1.0 - opacity),
        transmit_specular: 1.0,
        ..surface
    }
}
