use super::Aim;
use super::distant::versine;
use crate::scene::{Light, LightKind};
use glam::Vec3;

impl Aim {
    /// How far a point lies off a light's surface.
    #[must_use]
    pub fn distance_to(light: &Light, point: Vec3) -> f32 {
        let off = point - Vec3::from(light.position);
        let (u, v) = (Vec3::from(light.u), Vec3::from(light.v));
        let kind = match LightKind::from_u32(light.kind) {
            Some(LightKind::Sphere) => return (length(off) - u.x).abs(),
            Some(kind @ (LightKind::Parallelogram | LightKind::Triangle | LightKind::Disc)) => kind,
            _ => return length(off),
        };
        // The point's coordinates along u and v, put back into the shape.
        // By products of vectors: those of their lengths and angle lose all of a thin shape.
        let n = u.cross(v);
        let nn = n.dot(n);
        if nn.is_nan() || nn <= 0.0 {
            return length(off);
        }
        let (a, b) = (off.cross(v).dot(n) / nn, u.cross(off).dot(n) / nn);
        let (a, b) = match kind {
            LightKind::Disc => {
                let scale = libm::sqrtf(a * a + b * b).max(1.0);
                (a / scale, b / scale)
            }
            LightKind::Triangle => {
                let (a, b) = (a.max(0.0), b.max(0.0));
                let scale = (a + b).max(1.0);
                (a / scale, b / scale)
            }
            _ => (a.clamp(0.0, 1.0), b.clamp(0.0, 1.0)),
        };
        length(off - u * a - v * b)
    }

    /// The lengths of what spans a light's surface, if it has one.
    #[must_use]
    pub fn size(light: &Light) -> f32 {
        let [u, v] = [light.u, light.v].map(Vec3::from);
        length(u) + length(v)
    }

    /// Whether a distant light lies in a unit direction.
    #[must_use]
    pub fn is_towards(light: &Light, direction: Vec3) -> bool {
        let axis = Vec3::from(light.u);
        let versine = versine(light.v.into());
        let cos = direction.dot(axis);
        if cos > 0.5 {
            // 1 - cos of a small angle, from the chord.
            let chord = direction - axis;
            0.5 * chord.dot(chord) <= versine
        } else {
            1.0 - cos <= versine
        }
    }
}

/// A board has it once.
#[cfg_attr(not(feature = "bundles"), inline(never))]
fn length(v: Vec3) -> f32 {
    libm::sqrtf(v.dot(v))
}
