//! Which lights a scene needs, and which surface belongs to which.

use std::collections::BTreeMap;

use glam::DVec3;
use kiloray_core::scene::{LightKind, MaterialKind};

use super::frame::Placement;
use super::surfaces::{GROUP_SPHERE, Surfaces, position};
use crate::model::{Light, Material, Model};

/// Lights that share a material with others get one of their own up to this number: each costs 80
/// bytes of every node's tables.
const SPLIT_MAX: usize = 1024;

/// Why a light is left out.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Dark {
    /// It has no power, or no area.
    Off,
    /// It shines away from every surface of the scene.
    FacesAway,
    /// No surface is within its reach.
    TooFar,
}

impl Dark {
    /// A few words for a report.
    #[must_use]
    pub const fn reason(self) -> &'static str {
        match self {
            Self::Off => "without power or area",
            Self::FacesAway => "facing away from all surfaces",
            Self::TooFar => "out of reach of all surfaces",
        }
    }
}

/// The lights that can light a surface, and how many cannot.
pub(crate) fn useful(model: &Model, place: Placement) -> (Vec<Light>, BTreeMap<Dark, u64>) {
    let mut dark = BTreeMap::new();
    let mut useful = Vec::with_capacity(model.lights.len());
    for light in &model.lights {
        // A surface that no ray sees names no light.
        let seen = |&m: &u16| model.materials[usize::from(m)].kind != MaterialKind::Void;
        let material = light.material.filter(seen);
        match darkness(light, place) {
            // Where it is seen, the light alone knows its cone.
            Some(Dark::FacesAway) if light.cone.is_some() && material.is_some() => {}
            Some(reason) => {
                *dark.entry(reason).or_default() += 1;
                continue;
            }
            None => {}
        }
        useful.push(Light { material, ..*light });
    }
    (useful, dark)
}

fn darkness(light: &Light, place: Placement) -> Option<Dark> {
    let power = light.radiance.max_element() > 0.0 && light.radiance.is_finite();
    let area = match light.kind {
        LightKind::Parallelogram | LightKind::Triangle | LightKind::Disc => {
            let normal = light.u.normalize_or_zero().cross(light.v.normalize_or_zero());
            normal != DVec3::ZERO
        }
        LightKind::Sphere => light.u.x > 0.0,
        LightKind::Point | LightKind::Spot | LightKind::Distant => true,
    };
    if !power || !area {
        return Some(Dark::Off);
    }
    if light.kind == LightKind::Distant {
        return None;
    }
    // A ball round the light, and one round the scene.
    let (center, radius) = ball(light);
    let nearest = center.clamp(place.lo, place.hi);
    if nearest.distance(center) - radius > light.reach {
        return Some(Dark::TooFar);
    }
    let faces = faces(light, place) && shines_on(light, center, radius, place);
    (!faces).then_some(Dark::FacesAway)
}

fn ball(light: &Light) -> (DVec3, f64) {
    match light.kind {
        LightKind::Parallelogram => {
            let half = (light.u + light.v) * 0.5;
            (light.position + half, half.length().max((light.u - light.v).length() * 0.5))
        }
        LightKind::Triangle => {
            let center = light.position + (light.u + light.v) / 3.0;
            let corners = [DVec3::ZERO, light.u, light.v].map(|c| light.position + c);
            (center, corners.map(|c| c.distance(center)).into_iter().fold(0.0, f64::max))
        }
        LightKind::Disc => (light.position, light.u.length().max(light.v.length())),
        LightKind::Sphere => (light.position, light.u.x),
        LightKind::Point | LightKind::Spot | LightKind::Distant => (light.position, 0.0),
    }
}

/// Whether any point of the scene's box lies before the plane of a flat light.
fn faces(light: &Light, place: Placement) -> bool {
    if !matches!(light.kind, LightKind::Parallelogram | LightKind::Triangle | LightKind::Disc) {
        return true;
    }
    let normal = light.u.cross(light.v).normalize_or_zero();
    // The corner that lies farthest along the normal.
    let corner = DVec3::select(normal.cmpge(DVec3::ZERO), place.hi, place.lo);
    let size = (place.hi - place.lo).max_element() + light.position.abs().max_element();
    normal.dot(corner - light.position) > 1e-14 * size
}

/// Whether the ball round the scene reaches into a cone of directions from the ball round the light.
fn shines_on(light: &Light, center: DVec3, radius: f64, place: Placement) -> bool {
    let (axis, half) = match (light.kind, light.cone) {
        (LightKind::Spot, _) => (light.u, libm::acos(light.v.x.clamp(-1.0, 1.0))),
        (_, Some(cone)) => (cone.axis, cone.half_angle),
        _ => return true,
    };
    let middle = (place.lo + place.hi) * 0.5;
    let reach = (place.hi - place.lo).length() * 0.5 + radius;
    let to = middle - center;
    let distance = to.length();
    if distance <= reach || axis == DVec3::ZERO {
        return true;
    }
    let cos = axis.dot(to) / (axis.length() * distance);
    libm::acos(cos.clamp(-1.0, 1.0)) <= half + libm::asin(reach / distance) + 1e-9
}

/// Gives each light a material of its own, if it is the only one to name the surface: whoever finds
/// the surface then knows the light. Materials some surface of which has no light, or several, stay.
pub(crate) fn split_materials(
    materials: &mut Vec<Material>,
    surfaces: &mut Surfaces,
    lights: &mut [Light],
    place: Placement,
) {
    let mut shared: BTreeMap<u16, Vec<usize>> = BTreeMap::new();
    for (index, light) in lights.iter().enumerate() {
        if let Some(material) = light.material {
            shared.entry(material).or_default().push(index);
        }
    }
    shared.retain(|_, lights| lights.len() > 1);
    let count: usize = shared.values().map(Vec::len).sum();
    if count == 0 || count > SPLIT_MAX || materials.len() + count > usize::from(u16::MAX) {
        return;
    }
    let finders = lights.iter().map(|light| Finder::of(light, place)).collect::<Vec<_>>();
    // For each surface of a shared material, its light.
    let mut owners: BTreeMap<u16, Vec<(usize, usize)>> = BTreeMap::new();
    for (item, surface) in surfaces.items.iter().enumerate() {
        let material = (surface.group & (GROUP_SPHERE - 1)) as u16;
        let Some(of_material) = shared.get(&material) else { continue };
        let corners = surfaces.corners[surface.primitive as usize].map(|v| {
            let v = position(&surfaces.vertices[v as usize]);
            DVec3::from_array(v.map(f64::from))
        });
        let sphere = surface.group & GROUP_SPHERE != 0;
        let mut own = of_material.iter().filter(|&&light| finders[light].has(corners, sphere));
        match (own.next(), own.next()) {
            (Some(&light), None) => owners.entry(material).or_default().push((item, light)),
            _ => {
                shared.remove(&material);
                owners.remove(&material);
            }
        }
    }
    for (material, of_material) in owners {
        let first = materials.len() as u16;
        let of_lights = &shared[&material];
        for (i, &light) in of_lights.iter().enumerate() {
            materials.push(materials[usize::from(material)].clone());
            lights[light].material = Some(first + i as u16);
        }
        for (item, light) in of_material {
            let group = &mut surfaces.items[item].group;
            let i = of_lights.iter().position(|&other| other == light).unwrap_or(0);
            *group = *group & GROUP_SPHERE | u32::from(first + i as u16);
        }
    }
}

/// Tells whether a surface is that of a light; scene coordinates.
struct Finder {
    kind: LightKind,
    position: DVec3,
    u: DVec3,
    v: DVec3,
}

impl Finder {
    fn of(light: &Light, place: Placement) -> Self {
        let scale = place.scale();
        Self {
            kind: light.kind,
            position: place.point(light.position),
            u: light.u * scale,
            v: light.v * scale,
        }
    }

    fn has(&self, corners: [DVec3; 3], sphere: bool) -> bool {
        // Corners are rounded to f32.
        let near = |a: f64, b: f64| (a - b).abs() <= 2f64.powi(-22);
        if self.kind == LightKind::Sphere {
            let center = corners[0].distance(self.position) <= 2f64.powi(-22);
            return sphere && center && near(corners[1].x, self.u.x);
        }
        let normal = self.u.cross(self.v).normalize_or_zero();
        let (uu, uv, vv) = (self.u.dot(self.u), self.u.dot(self.v), self.v.dot(self.v));
        let det = uu * vv - uv * uv;
        let slack = 2f64.powi(-21) / uu.min(vv).sqrt();
        !sphere
            && corners.iter().all(|&corner| {
                let off = corner - self.position;
                let (pu, pv) = (off.dot(self.u), off.dot(self.v));
                let (a, b) = ((pu * vv - pv * uv) / det, (pv * uu - pu * uv) / det);
                let unit = -slack..=1.0 + slack;
                let inside = match self.kind {
                    LightKind::Parallelogram => unit.contains(&a) && unit.contains(&b),
                    LightKind::Triangle => a >= -slack && b >= -slack && a + b <= 1.0 + slack,
                    LightKind::Disc => a * a + b * b <= 1.0 + 4.0 * slack,
                    _ => false,
                };
                inside && near(off.dot(normal), 0.0)
            })
    }
}
