//! The light and the view of a scene that has none.

use glam::DVec3;
use kiloray_core::scene::{LightKind, ViewKind};

use crate::model::{Emitter, Light, Material, Model, View};

/// Full angles of the default view [degrees].
const VIEW_DEGREES: f64 = 45.0;
/// Radiance of the default sky, from all around.
const SKY: DVec3 = DVec3::new(0.45, 0.5, 0.55);
/// Irradiance of the default sun, on a surface that faces it.
const SUN: DVec3 = DVec3::new(2.0, 1.9, 1.7);
/// Full angle of the default sun [degrees]: soft, but clear shadows.
const SUN_DEGREES: f64 = 4.0;

/// Adds what is missing. `upright`: z points up, as in Radiance; else y, as in most meshes.
pub(super) fn complete(model: &mut Model, upright: bool) {
    if model.views.is_empty()
        && let Some(view) = view(model, upright)
        && model.add_view(view).is_ok()
    {
        model.note("no view given: from the front, all in sight (choose another with --view)");
    }
    if !emits(model) {
        light(model, upright);
        model.note("no light in the scene: a sky and a sun were added");
    } else if !lit(model) {
        model.note(
            "nothing in the scene lights surfaces: what glows is seen, the rest stays dark; take a `light` that shines outwards, or give the glow a reach",
        );
    }
}

/// Something in the scene lights surfaces.
pub(super) fn lit(model: &Model) -> bool {
    model.lights.iter().any(|light| light.reach > 0.0)
}

/// The scene brings light of its own, if only to be seen.
fn emits(model: &Model) -> bool {
    let glows: Vec<bool> = model.materials.iter().map(|m| m.emission != DVec3::ZERO).collect();
    let seen = |material: u16| glows.get(usize::from(material)).copied().unwrap_or(false);
    !model.lights.is_empty()
        || model.triangles.iter().any(|t| seen(t.material))
        || model.spheres.iter().any(|s| seen(s.material))
}

/// Frames the bounds of all surfaces; `None` if there are none.
fn view(model: &Model, upright: bool) -> Option<View> {
    let corners = model.triangles.iter().flat_map(|t| t.vertices);
    let points = corners.filter_map(|i| model.vertices.get(i as usize)).copied();
    let spheres = model.spheres.iter().flat_map(|s| [s.center - s.radius, s.center + s.radius]);
    let (lo, hi) = points
        .chain(spheres)
        .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(lo, hi), p| (lo.min(p), hi.max(p)));
    let center = lo.midpoint(hi);
    let half = hi - center;
    if !half.is_finite() || half.max_element() <= 0.0 {
        return None;
    }
    // From the front, a little from the right and from above.
    let (up, ahead) = if upright {
        (DVec3::Z, DVec3::new(-0.35, 1.0, -0.3))
    } else {
        (DVec3::Y, DVec3::new(-0.35, -0.3, -1.0))
    };
    let ahead = ahead.normalize();
    let right = ahead.cross(up).normalize();
    let above = right.cross(ahead);
    // Far enough that every corner of the bounds lies within the angles.
    let tan = libm::tan((VIEW_DEGREES / 2.0).to_radians());
    let reach = (0..8).map(|i| {
        let sign = |bit: u8| if i >> bit & 1 == 1 { 1.0 } else { -1.0 };
        let corner = half * DVec3::new(sign(0), sign(1), sign(2));
        corner.dot(right).abs().max(corner.dot(above).abs()) / tan - corner.dot(ahead)
    });
    let distance = reach.fold(0.0, f64::max) * 1.05;
    Some(View {
        kind: ViewKind::Perspective,
        name: "front".to_owned(),
        position: center - ahead * distance,
        direction: ahead,
        up,
        size: [VIEW_DEGREES; 2],
        offset: [0.0; 2],
        clip: [0.0; 2],
    })
}

/// A pale sky all around, and a sun over the viewer's left shoulder.
fn light(model: &mut Model, upright: bool) {
    let up = if upright { DVec3::Z } else { DVec3::Y };
    let ahead = model.views.first().map_or(DVec3::NEG_Z, |view| view.direction);
    let right = ahead.cross(up).try_normalize().unwrap_or(DVec3::X);
    let sun = (up * 1.2 - right * 0.6 - ahead * 0.8).normalize();
    let cos = libm::cos((SUN_DEGREES / 2.0).to_radians());
    // A small cone's projected solid angle is π sin².
    let solid = std::f64::consts::PI * (1.0 - cos * cos);
    for (u, cos, radiance) in [(up, -1.0, SKY), (sun, cos, SUN / solid)] {
        model.lights.push(Light {
            kind: LightKind::Distant,
            material: None,
            reach: f64::INFINITY,
            position: DVec3::ZERO,
            u,
            v: DVec3::X * cos,
            radiance,
            cone: None,
        });
    }
}

/// The material of surfaces that name none: grey, diffuse.
pub(super) fn material() -> Material {
    Material { name: "default".to_owned(), emitter: Emitter::None, ..Material::default() }
}
