use super::{OpticalDepth, ROUGHNESS_MIN, Surface, fresnel};
use crate::geometry::{Hit, Primitive, Ray, sphere_roots};
use crate::scene::{Material, MaterialKind};
use glam::Vec3;

/// Whether shadow rays pass surfaces of this material, weakened or not: panes of glass, clear trans, and void.
///
/// They stop at dielectrics: a refracted shadow ray would miss its light, and what
/// lies in the shadow of a crystal ball gets no light through it. They stop at rough trans too.
#[must_use]
pub fn passes_shadow_rays(material: &Material) -> bool {
    match MaterialKind::from_u32(material.kind) {
        Some(MaterialKind::Void) => true,
        Some(MaterialKind::Glass) => material.transmit != [0.0; 3],
        Some(MaterialKind::Opaque) => {
            material.roughness < ROUGHNESS_MIN
                && material.transmit_specular > 0.0
                && material.transmit != [0.0; 3]
        }
        _ => false,
    }
}

impl OpticalDepth {
    /// Goes on through what a shadow ray has hit: whether nothing of its light is left. What no material of the table is stops it.
    pub fn cross(&mut self, materials: &[Material], ray: &Ray, hit: &Hit) -> bool {
        let here = match materials.get(usize::from(hit.material)) {
            Some(material) => crossing(material, ray, hit),
            None => Self::OPAQUE,
        };
        *self = self.and(here);
        self.is_opaque()
    }
}

/// Whether a ray that meets a sphere at `t` meets it once more behind: it is told of it once.
#[inline(never)]
fn is_met_again(ray: &Ray, t: f32, center: Vec3, radius: f32) -> bool {
    let roots = sphere_roots(ray.origin, ray.direction, center, radius);
    roots.is_some_and(|roots| roots.far > t && roots.far <= ray.t_max)
}

/// What a shadow ray loses where it hits, of a sphere at both its sides; [`OpticalDepth::OPAQUE`] if it stops there.
///
/// It is a function of the material, the ray and the primitive's plane: shading normals do not count.
#[cfg_attr(feature = "bundles", inline)]
#[must_use]
pub fn crossing(material: &Material, ray: &Ray, hit: &Hit) -> OpticalDepth {
    if !passes_shadow_rays(material) {
        return OpticalDepth::OPAQUE;
    }
    let cos = || {
        let surface = Surface::new(ray, hit, false);
        surface.normal.dot(surface.outgoing)
    };
    let here = match MaterialKind::from_u32(material.kind) {
        Some(MaterialKind::Void) => OpticalDepth::CLEAR,
        Some(MaterialKind::Glass) => {
            OpticalDepth::of(fresnel::pane(cos(), index(material), material.transmit.into()).1)
        }
        Some(MaterialKind::Opaque) => {
            let passed = Vec3::from(material.transmit) * material.transmit_specular;
            OpticalDepth::of(passed * (1.0 - fresnel::taken(material.specular.into(), cos)))
        }
        _ => OpticalDepth::OPAQUE,
    };
    match hit.primitive {
        // At the same angle.
        Primitive::Sphere { center, radius, .. } if is_met_again(ray, hit.t, center, radius) => {
            here.and(here)
        }
        _ => here,
    }
}

/// The index of refraction; 1 where it makes no sense.
pub(super) fn index(material: &Material) -> f32 {
    if material.ior > 0.0 { material.ior } else { 1.0 }
}
