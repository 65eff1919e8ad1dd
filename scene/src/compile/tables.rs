//! Materials, lights and views in scene units.
//!
//! Radiance and reflectance do not depend on the scale. Lengths are multiplied by it, absorption
//! (per length) is divided, and an intensity [W/sr] is multiplied by its square: `I / d²` stays.

use glam::DVec3;
use kiloray_core::scene::{Light, LightKind, Material, View, ViewKind};

use super::frame::Placement;
use super::options::CompileError;
use super::surfaces::{GROUP_SPHERE, Surfaces};
use crate::model;

/// Finite, or the nearest number that is.
fn real(v: f64) -> f32 {
    if v.is_nan() { 0.0 } else { (v as f32).clamp(-f32::MAX, f32::MAX) }
}

fn reals(v: DVec3) -> [f32; 3] {
    v.to_array().map(real)
}

/// An amount, which is never negative.
fn amount(v: f64) -> f32 {
    real(v).max(0.0)
}

fn rgb(v: DVec3) -> [f32; 3] {
    v.to_array().map(amount)
}

fn material(m: &model::Material, place: Placement) -> Material {
    Material {
        kind: m.kind as u32,
        roughness: amount(m.roughness),
        ior: amount(m.ior),
        transmit_specular: amount(m.transmit_specular),
        diffuse: rgb(m.diffuse),
        specular: rgb(m.specular),
        transmit: rgb(m.transmit),
        absorption: rgb(m.absorption / place.scale()),
        emission: rgb(m.emission),
        light: 0,
    }
}

/// Renumbers the materials that surfaces or lights use, in the order of the model.
pub(crate) struct Materials {
    pub(crate) table: Vec<Material>,
    /// New numbers; `u32::MAX` for what is not used.
    pub(crate) renamed: Vec<u32>,
}

impl Materials {
    /// Also renames the groups of the surfaces.
    pub(crate) fn of(
        list: &[model::Material],
        surfaces: &mut Surfaces,
        lights: &[model::Light],
        place: Placement,
    ) -> Self {
        let mut used = vec![false; list.len()];
        let of_items = surfaces.items.iter().map(|item| (item.group & (GROUP_SPHERE - 1)) as usize);
        let of_lights = lights.iter().filter_map(|light| light.material.map(usize::from));
        for index in of_items.chain(of_lights) {
            used[index] = true;
        }
        let mut table = Vec::new();
        let mut renamed = vec![u32::MAX; used.len()];
        for ((m, used), new) in list.iter().zip(used).zip(&mut renamed) {
            if used {
                *new = table.len() as u32;
                table.push(material(m, place));
            }
        }
        for item in &mut surfaces.items {
            let old = item.group & (GROUP_SPHERE - 1);
            item.group = item.group & GROUP_SPHERE | renamed[old as usize];
        }
        Self { table, renamed }
    }
}

impl Materials {
    /// The light table, in the order of materials, and the materials' way to it.
    pub(crate) fn lights(&mut self, lights: &[model::Light], place: Placement) -> Vec<Light> {
        let mut table: Vec<_> = lights
            .iter()
            .map(|l| {
                let material = l.material.map_or(u32::MAX, |m| self.renamed[usize::from(m)]);
                Light { material, ..light(l, place) }
            })
            .collect();
        table.sort_by_key(|light| light.material);
        for (index, light) in table.iter().enumerate().rev() {
            if let Some(material) = self.table.get_mut(light.material as usize) {
                material.light = index as u32 + 1;
            }
        }
        table
    }
}

/// An entry of the light table, without its material.
fn light(l: &model::Light, place: Placement) -> Light {
    let scale = place.scale();
    let (u, v, power) = match l.kind {
        LightKind::Parallelogram | LightKind::Triangle | LightKind::Disc | LightKind::Sphere => {
            (l.u * scale, l.v * scale, 1.0)
        }
        LightKind::Point | LightKind::Spot => (l.u, l.v, scale * scale),
        LightKind::Distant => {
            let versine = if l.v.y > 0.0 { l.v.y } else { 1.0 - l.v.x };
            (l.u, DVec3::new(l.v.x, versine, 0.0), 1.0)
        }
    };
    let (cone, cone_cos, focus) = l.cone.map_or(([0.0; 3], -1.0, 0.0), |cone| {
        let axis = reals(cone.axis.normalize_or_zero());
        (axis, real(libm::cos(cone.half_angle)), real((cone.focus * scale).max(0.0)))
    });
    Light {
        kind: l.kind as u32,
        material: u32::MAX,
        reach: if l.reach.is_nan() { f32::INFINITY } else { (l.reach * scale).max(0.0) as f32 },
        position: reals(if l.kind == LightKind::Distant {
            DVec3::ZERO
        } else {
            place.point(l.position)
        }),
        u: reals(u),
        v: reals(v),
        radiance: rgb(l.radiance * power),
        cone_cos,
        cone,
        focus,
    }
}

/// A view; `None` if it looks nowhere.
pub(crate) fn view(v: &model::View, place: Placement) -> Option<View> {
    let length = match v.kind {
        ViewKind::Perspective => 1.0,
        ViewKind::Parallel => place.scale(),
    };
    let direction = v.direction.try_normalize()?;
    let up = v.up.try_normalize()?;
    // Cut at a character, so that the name stays UTF-8.
    let mut name = [0; 20];
    let end = (0..=v.name.len().min(name.len())).rev().find(|&i| v.name.is_char_boundary(i));
    let text = &v.name.as_bytes()[..end.unwrap_or(0)];
    name[..text.len()].copy_from_slice(text);
    Some(View {
        kind: v.kind as u32,
        name,
        position: reals(place.point(v.position)),
        direction: reals(direction),
        up: reals(up),
        size: v.size.map(|s| amount(s * length).max(f32::MIN_POSITIVE)),
        offset: v.offset.map(real),
        clip: v.clip.map(|c| amount(c * place.scale())),
    })
}

/// A view for a scene that is compiled already: in the scene coordinates of its file. `None` if
/// its direction or up is no direction.
#[must_use]
pub fn view_in(frame: &kiloray_core::scene::Frame, v: &model::View) -> Option<View> {
    let center = frame.center.into();
    view(v, Placement { center, exponent: frame.exponent, lo: center, hi: center })
}

/// Refuses lights that name a material the model does not have.
pub(crate) fn check_lights(model: &model::Model) -> Result<(), CompileError> {
    let len = model.materials.len();
    for index in model.lights.iter().filter_map(|light| light.material) {
        if usize::from(index) >= len {
            return Err(CompileError::Missing {
                what: "material",
                index: u64::from(index),
                len: len as u64,
            });
        }
    }
    Ok(())
}
