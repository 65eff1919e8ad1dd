//! What a scene needs, so that the rest is skipped.

use core::fmt;
use std::collections::BTreeMap;

use glam::Vec3;
use kiloray_core::material::{ROUGHNESS_MIN, passes_shadow_rays};
use kiloray_core::scene::{Light, LightKind, LightNode, Material, MaterialKind, Needs};

use crate::compile::{Dark, Surfaces};

/// What a compiled scene needs and what was left out of it: prints as a few lines.
#[derive(Debug, Clone, PartialEq)]
pub struct Summary {
    /// What tracing and shading need.
    pub needs: Needs,
    /// Materials in the table.
    pub materials: usize,
    /// Materials of the model that nothing uses.
    pub materials_unused: usize,
    /// Lights in the table.
    pub lights: usize,
    /// Lights that light nothing, by why.
    pub lights_dark: BTreeMap<Dark, u64>,
    /// Views.
    pub views: usize,
    /// Extent of all surfaces [input units].
    pub size: [f64; 3],
    /// Greatest distance between an input vertex and the stored one [input units].
    pub position_error: f32,
}

/// The bits of [`Needs`]: when it is set, and what is skipped when it is not.
const PARTS: [(u32, &str, &str); 8] = [
    (Needs::SPECULAR, "specular rays", "specular rays"),
    (Needs::GLOSSY, "glossy lobes", "glossy lobes"),
    (Needs::DIELECTRIC, "refraction", "refraction and absorption"),
    (
        Needs::TRANSPARENT,
        "shadow rays through glass",
        "shadows through glass (shadow rays end at the first hit)",
    ),
    (Needs::SPHERES, "spheres", "spheres"),
    (Needs::NORMALS, "shading normals", "shading normals"),
    (Needs::DISTANT, "light from beyond", "light from beyond (rays that escape are black)"),
    (Needs::MANY_LIGHTS, "a tree of lights", "a tree of lights (each is looked at)"),
];

impl fmt::Display for Summary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [x, y, z] = self.size;
        writeln!(
            f,
            "size      {x:.4} x {y:.4} x {z:.4}; positions are true to {:.2e}",
            self.position_error
        )?;
        write!(f, "tables    {} materials", self.materials)?;
        if self.materials_unused > 0 {
            write!(f, " ({} unused ones left out)", self.materials_unused)?;
        }
        write!(f, ", {} lights", self.lights)?;
        for (why, count) in &self.lights_dark {
            write!(f, " ({count} left out: {})", why.reason())?;
        }
        writeln!(f, ", {} views", self.views)?;
        let list = |set: bool| {
            let part = |&(bit, needed, skipped): &(u32, &'static str, &'static str)| {
                let is_set = self.needs.bits & bit != 0;
                (is_set == set).then_some(if set { needed } else { skipped })
            };
            let parts: Vec<_> = PARTS.iter().filter_map(part).collect();
            if parts.is_empty() { "nothing".to_owned() } else { parts.join(", ") }
        };
        writeln!(f, "needs     {}", list(true))?;
        write!(f, "skips     {}", list(false))
    }
}

/// Finds what materials, lights and surfaces make necessary. `bounds`, of the surfaces.
pub(crate) fn needs(
    materials: &[Material],
    lights: &[Light],
    light_tree: &[LightNode],
    surfaces: &Surfaces,
    bounds: ([f32; 3], [f32; 3]),
) -> Needs {
    let mut bits = materials.iter().map(of_material).fold(0, |all, bits| all | bits);
    if lights.iter().any(|light| light.kind == LightKind::Distant as u32) {
        bits |= Needs::DISTANT;
    }
    if !light_tree.is_empty() {
        bits |= Needs::MANY_LIGHTS;
    }
    if surfaces.spheres > 0 {
        bits |= Needs::SPHERES;
    }
    if surfaces.normals {
        bits |= Needs::NORMALS;
    }
    let radiances = materials
        .iter()
        .map(|m| m.emission)
        .chain(lights.iter().map(|light| brightest(light, bounds)));
    let radiance_max = radiances.flatten().fold(0.0, f32::max).min(f32::MAX);
    Needs { bits, radiance_max }
}

fn of_material(m: &Material) -> u32 {
    let some = |v: [f32; 3]| v.iter().any(|&x| x > 0.0);
    let through = some(m.transmit) && m.transmit_specular > 0.0;
    let bits = match MaterialKind::from_u32(m.kind) {
        Some(MaterialKind::Opaque) if some(m.specular) || through => {
            let glossy = m.roughness >= ROUGHNESS_MIN;
            Needs::SPECULAR | if glossy { Needs::GLOSSY } else { 0 }
        }
        Some(MaterialKind::Mirror | MaterialKind::Glass) => Needs::SPECULAR,
        Some(MaterialKind::Dielectric) => Needs::SPECULAR | Needs::DIELECTRIC,
        _ => 0,
    };
    bits | if passes_shadow_rays(m) { Needs::TRANSPARENT } else { 0 }
}

/// The greatest radiance that a light causes: its own, or for a point without area what a white
/// surface returns, at the nearest place of the scene or at 1/64 of its size if the point is inside.
fn brightest(light: &Light, (lo, hi): ([f32; 3], [f32; 3])) -> [f32; 3] {
    let is_point = [LightKind::Point as u32, LightKind::Spot as u32].contains(&light.kind);
    if !is_point {
        return light.radiance;
    }
    let at = Vec3::from(light.position);
    let near = at.distance(at.clamp(lo.into(), hi.into())).max(1.0 / 64.0);
    light.radiance.map(|i| i / (near * near) * std::f32::consts::FRAC_1_PI)
}

#[cfg(test)]
mod tests;
