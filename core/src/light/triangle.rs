use crate::elementary::{angle, sin_cos_of_turns};
use crate::real::{Real, Vector};
use core::f32::consts::TAU;
use glam::Vec3;

/// A triangle, sampled by the solid angle under which the origin sees it: Arvo 1995, "Stratified sampling of spherical
/// triangles". Names are those of the paper.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct SphericalTriangle {
    a: Vec3,
    b: Vec3,
    /// Unit, at right angles to `a`, towards `c`.
    c_off_a: Vec3,
    sin_alpha: f32,
    cos_alpha: f32,
    cos_c: f32,
    pub(super) solid_angle: f32,
}

/// Below this solid angle, and where an angle is flat, rounding spoils the map.
const SOLID_ANGLE_MIN: f32 = 0.02;

impl SphericalTriangle {
    /// The corners are seen from the point, in either sense.
    pub(super) fn new(a: Vec3, b: Vec3, c: Vec3) -> Option<Self> {
        let (a, b, c) = (unit(a)?, unit(b)?, unit(c)?);
        // Van Oosterom & Strackee 1983: no difference of angles.
        let triple = a.dot(b.cross(c)).abs();
        let half = angle(triple, 1.0 + a.dot(b) + b.dot(c) + c.dot(a));
        let b_off_a = unit(b - a * a.dot(b))?;
        let c_off_a = unit(c - a * a.dot(c))?;
        let cos_alpha = b_off_a.dot(c_off_a).clamp(-1.0, 1.0);
        let sin_alpha = libm::sqrtf(1.0 - cos_alpha * cos_alpha);
        let found =
            Self { a, b, c_off_a, sin_alpha, cos_alpha, cos_c: a.dot(b), solid_angle: 2.0 * half };
        (found.solid_angle >= SOLID_ANGLE_MIN && sin_alpha > 0.01).then_some(found)
    }

    /// A unit direction.
    #[inline(always)]
    pub(super) fn sample<R: Real>(&self, [x, y]: [R; 2]) -> Vector<R> {
        // Of `φ - α`, without α itself.
        let (sin, cos) = sin_cos_of_turns(x * self.solid_angle / TAU);
        let s = sin * self.cos_alpha - cos * self.sin_alpha;
        let t = cos * self.cos_alpha + sin * self.sin_alpha;
        let u = t - self.cos_alpha;
        let v = s + self.sin_alpha * self.cos_c;
        let q = ((v * t - u * s) * self.cos_alpha - v) / ((v * s + u * t) * self.sin_alpha);
        // Both vanish at x = 0, where the sub-triangle is A and B alone: of NaN comes 1.
        let q = q.at_most(1.0).at_least(-1.0);
        let c = Vector::along(self.a, q) + Vector::along(self.c_off_a, (q * q).complement().sqrt());
        let cos = c.on(self.b);
        let z = (y * cos.complement()).complement();
        let off = c - Vector::along(self.b, cos);
        // Where nothing is off, nothing times it is.
        let off = off / off.length().at_least(f32::MIN_POSITIVE);
        Vector::along(self.b, z) + off * (z * z).complement().at_least(0.0).sqrt()
    }
}

/// `v` at unit length.
pub(super) fn unit(v: Vec3) -> Option<Vec3> {
    let len = libm::sqrtf(v.dot(v));
    (len > 0.0).then(|| v / len)
}
