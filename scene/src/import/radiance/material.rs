//! Materials, from Radiance's units to ours.

use glam::DVec3;
use kiloray_core::scene::MaterialKind;

use super::kinds::Stuff;
use super::names::Names;
use super::reader::Arguments;
use super::xform::Xform;
use crate::import::Cause;
use crate::import::error::syntax;
use crate::model::{Cone, Emitter, IOR, Material, Model};

/// Index of refraction of `glass` without a fourth number.
const GLASS_IOR: f64 = 1.52;
/// Absorption where nothing is let through [1 / input unit]: black within any scene that f32 holds.
const ABSORPTION_MAX: f64 = 1e20;

/// Makes a material of its type and name and its arguments. `glow` in the answer: a source of it is seen only.
///
/// `place` is the transformation of the file that defines it: it turns spotlights and scales the
/// reach of a glow and the absorption of a dielectric, as Radiance's `xform` does.
pub(super) fn material(
    stuff: Stuff,
    [type_name, name]: [&str; 2],
    arguments: &Arguments,
    place: &Xform,
    names: &Names,
    model: &mut Model,
) -> Result<(Material, bool), Cause> {
    let numbers = &arguments.numbers[..];
    let amounts = numbers.iter().take(amounts(stuff));
    if let Some((i, value)) = amounts.enumerate().find(|(_, value)| **value < 0.0) {
        let (at, count) = (i + 1, numbers.len());
        return Err(syntax(format!("number {at} of {count} is {value}, below zero")));
    }
    let base = Material { name: name.to_owned(), ..Material::default() };
    let size = place.scale.abs();
    let made = match (stuff, numbers) {
        (Stuff::Plastic | Stuff::Metal, &[r, g, b, spec, rough]) => {
            let metal = stuff == Stuff::Metal;
            coated(base, [r, g, b], spec, rough, metal, [0.0; 2], model)
        }
        (Stuff::Plastic2 | Stuff::Metal2, &[r, g, b, spec, u, v]) => {
            let metal = stuff == Stuff::Metal2;
            coated(base, [r, g, b], spec, isotropic(u, v, model), metal, [0.0; 2], model)
        }
        (Stuff::Trans, &[r, g, b, spec, rough, trans, tspec]) => {
            coated(base, [r, g, b], spec, rough, false, [trans, tspec], model)
        }
        (Stuff::Trans2, &[r, g, b, spec, u, v, trans, tspec]) => {
            coated(base, [r, g, b], spec, isotropic(u, v, model), false, [trans, tspec], model)
        }
        (Stuff::Dielectric, &[r, g, b, ior, hartmann]) => {
            if hartmann != 0.0 {
                model.note("dispersion of a dielectric (Hartmann's constant): not simulated");
            }
            dielectric(base, [r, g, b], index(ior)?, size, model)
        }
        (Stuff::Interface, &[r, g, b, inside, _, _, _, outside]) => {
            model.note("an interface: a dielectric of the relative index, clear outside");
            dielectric(base, [r, g, b], index(inside / outside)?, size, model)
        }
        (Stuff::Glass, &[r, g, b]) => glass(base, [r, g, b], GLASS_IOR, model),
        (Stuff::Glass, &[r, g, b, ior]) => glass(base, [r, g, b], index(ior)?, model),
        (Stuff::Mirror, &[r, g, b]) => match alternate(arguments, names)? {
            Some(seen) => Material { name: name.to_owned(), ..seen },
            None => Material {
                kind: MaterialKind::Mirror,
                diffuse: DVec3::ZERO,
                specular: share([r, g, b], model),
                ..base
            },
        },
        (Stuff::Light, &[r, g, b]) => {
            light(base, [r, g, b], Emitter::Sampled { reach: f64::INFINITY, cone: None })
        }
        (Stuff::Illum, &[r, g, b]) => {
            let nothing = Material { kind: MaterialKind::Void, ..base };
            let seen = alternate(arguments, names)?.unwrap_or(nothing);
            let emitter = Emitter::Illum { radiance: DVec3::new(r, g, b) };
            Material { name: name.to_owned(), emitter, ..seen }
        }
        (Stuff::Glow, &[r, g, b, reach]) => {
            let lights = reach > 0.0;
            let sampled = Emitter::Sampled { reach: reach * size, cone: None };
            light(base, [r, g, b], if lights { sampled } else { Emitter::None })
        }
        (Stuff::Spotlight, &[r, g, b, angle, x, y, z]) => {
            let direction = place.vector(DVec3::new(x, y, z));
            let axis = direction.try_normalize();
            let axis = axis.ok_or_else(|| syntax("the spotlight's direction has no length"))?;
            if !(angle > 0.0 && angle <= 360.0) {
                return Err(syntax(
                    "the spotlight's angle must be above 0 and at most 360 degrees",
                ));
            }
            let half_angle = (angle / 2.0).to_radians();
            let cone = Some(Cone { axis, half_angle, focus: direction.length() });
            light(base, [r, g, b], Emitter::Sampled { reach: f64::INFINITY, cone })
        }
        (Stuff::Nothing, _) => {
            model.note("antimatter or mist: left out");
            Material { kind: MaterialKind::Void, ..base }
        }
        (Stuff::Other, _) => {
            let which = format!("{type_name} {name}");
            model.notes.add_named("a material that is not built in: grey instead", &which);
            base
        }
        _ => return Err(syntax(wrong_count(stuff, numbers.len()))),
    };
    made.check()?;
    Ok((made, stuff == Stuff::Glow))
}

/// How many of its numbers, from the first, are amounts of light or roughness.
const fn amounts(stuff: Stuff) -> usize {
    match stuff {
        Stuff::Plastic | Stuff::Metal => 5,
        Stuff::Plastic2 | Stuff::Metal2 => 6,
        Stuff::Trans => 7,
        Stuff::Trans2 => 8,
        Stuff::Nothing | Stuff::Other => 0,
        _ => 3,
    }
}

/// Plastic, metal and trans: `normal.c` splits light into a specular part of `spec`, of the rest
/// `trans` goes through, of that `tspec` undeviated; what is left is reflected diffusely.
fn coated(
    base: Material,
    color: [f64; 3],
    spec: f64,
    roughness: f64,
    metal: bool,
    [trans, tspec]: [f64; 2],
    model: &mut Model,
) -> Material {
    let color = share(color, model);
    let [spec, trans, tspec] = share([spec, trans, tspec], model).to_array();
    let through = trans * (1.0 - spec);
    Material {
        kind: MaterialKind::Opaque,
        roughness,
        specular: if metal { color * spec } else { DVec3::splat(spec) },
        diffuse: color * (1.0 - spec - through).max(0.0),
        transmit: color * through,
        transmit_specular: tspec,
        ..base
    }
}

/// One roughness for two: of the same area of the lobe.
fn isotropic(u: f64, v: f64, model: &mut Model) -> f64 {
    model.note("different roughness along and across: their geometric mean for both");
    (u * v).max(0.0).sqrt()
}

/// An index of refraction that makes sense.
fn index(ior: f64) -> Result<f64, Cause> {
    if IOR.contains(&ior) {
        return Ok(ior);
    }
    let (least, most) = (IOR.start(), IOR.end());
    Err(syntax(format!("an index of refraction of {ior}: it must be from {least} to {most}")))
}

/// `transmission` is the part that is left after one unit of length.
fn dielectric(
    base: Material,
    transmission: [f64; 3],
    ior: f64,
    size: f64,
    model: &mut Model,
) -> Material {
    let absorption = share(transmission, model).to_array().map(|t| {
        if t > 0.0 { (-libm::log(t) / size).min(ABSORPTION_MAX) + 0.0 } else { ABSORPTION_MAX }
    });
    Material {
        kind: MaterialKind::Dielectric,
        ior,
        diffuse: DVec3::ZERO,
        absorption: absorption.into(),
        ..base
    }
}

fn glass(base: Material, transmission: [f64; 3], ior: f64, model: &mut Model) -> Material {
    let transmit = share(transmission, model);
    Material { kind: MaterialKind::Glass, ior, transmit, diffuse: DVec3::ZERO, ..base }
}

fn light(base: Material, emission: [f64; 3], emitter: Emitter) -> Material {
    let emission = emission.into();
    Material { kind: MaterialKind::Light, diffuse: DVec3::ZERO, emission, emitter, ..base }
}

/// What is seen in place of an illum or a mirror; `None` if none is named.
fn alternate(arguments: &Arguments, names: &Names) -> Result<Option<Material>, Cause> {
    let Some(name) = arguments.strings.first() else { return Ok(None) };
    let nothing = Material { kind: MaterialKind::Void, ..Material::default() };
    match names.get(name.as_bytes()) {
        None => Err(syntax(format!("the alternate material `{name}` is not defined before it"))),
        Some(seen) => {
            Ok(Some(names.definition(seen).map_or(nothing, |seen| seen.material.clone())))
        }
    }
}

/// Parts of a whole: what is more than all is cut, and counted.
fn share(parts: [f64; 3], model: &mut Model) -> DVec3 {
    if parts.iter().any(|&p| p > 1.0) {
        model.note("a reflectance or transmittance above 1: taken as 1");
    }
    DVec3::from(parts).min(DVec3::ONE)
}

fn wrong_count(stuff: Stuff, found: usize) -> String {
    let needs = match stuff {
        Stuff::Plastic | Stuff::Metal => "5 (red green blue specularity roughness)",
        Stuff::Plastic2 | Stuff::Metal2 => "6 (red green blue specularity u-roughness v-roughness)",
        Stuff::Trans => "7 (red green blue specularity roughness transmissivity tspec)",
        Stuff::Trans2 => "8 (as trans, with two roughnesses)",
        Stuff::Dielectric => "5 (red green blue transmission, index, Hartmann's constant)",
        Stuff::Interface => "8 (transmission and index, inside and outside)",
        Stuff::Glass => "3 or 4 (red green blue transmissivity, index)",
        Stuff::Glow => "4 (red green blue reach)",
        Stuff::Spotlight => "7 (red green blue angle and direction)",
        _ => "3 (red green blue)",
    };
    format!("{found} numbers where it takes {needs}")
}
