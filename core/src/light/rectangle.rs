use crate::elementary::{asin, sin_cos_of_turns};
use crate::real::{Real, Vector};
use core::f32::consts::{PI, TAU};
use glam::Vec3;

/// A rectangle, sampled by the solid angle under which the origin sees it: Ureña, Fajardo, King 2013, "An area-preserving
/// parametrization for spherical rectangles". Names are those of the paper.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Rectangle {
    x: Vec3,
    y: Vec3,
    z: Vec3,
    z0: f32,
    x0: f32,
    x1: f32,
    y0: f32,
    y1: f32,
    b0: f32,
    b1: f32,
    k: f32,
    pub(super) solid_angle: f32,
}

/// Below this the sum of four arc sines has lost too many digits: its error is about 2e-7.
const SOLID_ANGLE_MIN: f32 = 0.02;

impl Rectangle {
    /// `corner` is seen from the point; `u` and `v` are orthogonal edges.
    pub(super) fn new(corner: Vec3, u: Vec3, v: Vec3) -> Option<Self> {
        let (width, height) = (libm::sqrtf(u.dot(u)), libm::sqrtf(v.dot(v)));
        let (x, y) = (u / width, v / height);
        let z = x.cross(y);
        let z0 = corner.dot(z);
        let (z, z0) = if z0 > 0.0 { (-z, -z0) } else { (z, z0) };
        let (x0, y0) = (corner.dot(x), corner.dot(y));
        let (x1, y1) = (x0 + width, y0 + height);
        // z components of the unit normals of the planes through the origin and each edge: those at y0, x1, y1, x0.
        let component = |a: f32| a / libm::sqrtf(z0 * z0 + a * a);
        let (n0, n1, n2, n3) = (-component(y0), component(x1), component(y1), -component(x0));
        // Each inner angle is acos(-n n') = π/2 + asin(n n'): without the 2π that the sum of four would take away again.
        let q = [n0 * n1, n1 * n2, n2 * n3, n3 * n0].map(|q| asin(q.clamp(-1.0, 1.0)));
        let [q0, q1, q2, q3] = q;
        let solid_angle = (q0 + q1) + (q2 + q3);
        (solid_angle >= SOLID_ANGLE_MIN).then_some(Self {
            x,
            y,
            z,
            z0,
            x0,
            x1,
            y0,
            y1,
            b0: n0,
            b1: n2,
            k: PI - q2 - q3,
            solid_angle,
        })
    }

    /// The vector from the point to the sample.
    #[inline(always)]
    pub(super) fn sample<R: Real>(&self, [u, v]: [R; 2]) -> Vector<R> {
        let (sin, cos) = sin_cos_of_turns((u * self.solid_angle + self.k) / TAU);
        let f = (cos * self.b0 - self.b1) / sin;
        let c = (u.same(1.0) / (f * f + self.b0 * self.b0).sqrt()).at_most(1.0).copysign(f);
        let xu = -(c * self.z0) / (c * c).complement().at_least(f32::MIN_POSITIVE).sqrt();
        let xu = xu.at_least(self.x0).at_most(self.x1);
        let d2 = xu * xu + self.z0 * self.z0;
        let h0 = u.same(self.y0) / (d2 + self.y0 * self.y0).sqrt();
        let h1 = u.same(self.y1) / (d2 + self.y1 * self.y1).sqrt();
        let h = h0 + v * (h1 - h0);
        let yv = h * (d2 / (h * h).complement().at_least(f32::MIN_POSITIVE)).sqrt();
        let yv = yv.at_least(self.y0).at_most(self.y1);
        Vector::along(self.x, xu) + Vector::along(self.y, yv) + self.z * self.z0
    }
}
