//! What a scene needs, so that the rest is skipped.

use kiloray_core::material::passes_shadow_rays;
use kiloray_core::scene::{Light, LightKind, Material, MaterialKind, Needs};

use crate::compile::Surfaces;

/// Finds what materials, lights and surfaces make necessary.
pub(crate) fn needs(materials: &[Material], lights: &[Light], surfaces: &Surfaces) -> Needs {
    let mut bits = 0;
    let mut radiance_max = 0.0_f32;
    let some = |v: [f32; 3]| v.iter().any(|&x| x > 0.0);
    for m in materials {
        radiance_max = m.emission.iter().copied().fold(radiance_max, f32::max);
        if passes_shadow_rays(m) {
            bits |= Needs::TRANSPARENT;
        }
        match MaterialKind::from_u32(m.kind) {
            Some(MaterialKind::Opaque) => {
                let through = some(m.transmit) && m.transmit_specular > 0.0;
                if through || some(m.specular) {
                    bits |= Needs::SPECULAR;
                }
                if (through || some(m.specular)) && m.roughness > 0.0 {
                    bits |= Needs::GLOSSY;
                }
            }
            Some(MaterialKind::Mirror | MaterialKind::Glass | MaterialKind::Void) => {
                bits |= Needs::SPECULAR;
            }
            Some(MaterialKind::Dielectric) => {
                bits |= Needs::SPECULAR | Needs::DIELECTRIC;
            }
            Some(MaterialKind::Light) | None => {}
        }
    }
    for light in lights {
        if light.kind == LightKind::Distant as u32 {
            bits |= Needs::DISTANT;
        }
        radiance_max = light.radiance.iter().copied().fold(radiance_max, f32::max);
    }
    if surfaces.spheres > 0 {
        bits |= Needs::SPHERES;
    }
    if surfaces.normals {
        bits |= Needs::NORMALS;
    }
    Needs { bits, radiance_max }
}
