//! The same scene for other renderers, so that they can be compared on the same work.
//!
//! [`radiance()`] writes a `.rad` text and a `.vf` line, [`mitsuba()`] a scene file and its meshes.
//! Only what the models of all three agree on is exact: diffuse surfaces, perfect mirrors, clear
//! dielectrics and panes, and area lights. [`common`] reduces a scene to that, and says what it
//! changed; comparing means rendering the reduced scene everywhere.

mod common;
mod mitsuba;
mod radiance;

pub use common::common;
pub use mitsuba::mitsuba;
pub use radiance::{radiance, view_file};

use glam::DVec3;
use kiloray_core::scene::LightKind;
use kiloray_scene::model::{Emitter, Light, Model};

/// Whether surfaces of this material are lamps: they stand in the light table by their shape.
fn is_lamp(model: &Model, material: u16) -> bool {
    model
        .materials
        .get(usize::from(material))
        .is_some_and(|m| matches!(m.emitter, Emitter::Sampled { .. }))
}

/// The corners of a polygonal light, counter-clockwise seen from where it shines.
fn polygon_of(light: &Light) -> Option<Vec<DVec3>> {
    let (p, u, v) = (light.position, light.u, light.v);
    match light.kind {
        LightKind::Parallelogram => Some(vec![p, p + u, p + u + v, p + v]),
        LightKind::Triangle => Some(vec![p, p + u, p + v]),
        _ => None,
    }
}
