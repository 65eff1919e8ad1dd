//! Entries of the light table for surfaces that emit.

use glam::DVec3;
use kiloray_core::scene::{LightKind, MaterialKind};

use super::{Emitter, Light, Model};

impl Model {
    pub(super) fn light_triangle(&mut self, material: u16, [a, b, c]: [DVec3; 3]) {
        self.light(material, LightKind::Triangle, a, b - a, c - a);
    }

    pub(super) fn light_parallelogram(&mut self, material: u16, corner: DVec3, u: DVec3, v: DVec3) {
        self.light(material, LightKind::Parallelogram, corner, u, v);
    }

    /// Enters an area light if the material is one that lights others.
    pub(super) fn light(
        &mut self,
        material: u16,
        kind: LightKind,
        position: DVec3,
        u: DVec3,
        v: DVec3,
    ) {
        let Some(m) = self.materials.get(usize::from(material)) else { return };
        let (reach, cone) = match m.emitter {
            Emitter::None => return,
            Emitter::Sampled { reach, cone } => (reach, cone),
            Emitter::Illum { .. } => (f64::INFINITY, None),
        };
        let radiance = m.radiance();
        if radiance == DVec3::ZERO {
            return;
        }
        let material = (m.kind != MaterialKind::Void).then_some(material);
        self.lights.push(Light { kind, material, reach, position, u, v, radiance, cone });
    }

    /// Whether surfaces of the material light others.
    pub(super) fn is_sampled(&self, material: u16) -> bool {
        self.materials
            .get(usize::from(material))
            .is_some_and(|m| m.emitter != Emitter::None && m.radiance() != DVec3::ZERO)
    }

    /// Whether surfaces of the material are nothing to hit.
    pub(super) fn is_void(&self, material: u16) -> bool {
        self.materials.get(usize::from(material)).is_some_and(|m| m.kind == MaterialKind::Void)
    }
}
