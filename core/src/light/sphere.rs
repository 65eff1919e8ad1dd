use super::aim::Dark;
use super::projected;
use crate::elementary::sin_cos_of_turns;
use crate::material::tangents;
use crate::real::{Real, Vector};
use core::f32::consts::PI;
use glam::Vec3;

/// A sphere, seen from outside.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Ball {
    pub(super) center: Vec3,
    pub(super) radius: f32,
    /// Unit, from the point to the centre.
    axis: Vec3,
    pub(super) distance: f32,
    /// `1 - cos` of half the cone's angle.
    versine: f32,
    pub(super) solid_angle: f32,
    /// The sum of all lengths that rounding depends on.
    pub(super) size: f32,
}

impl Ball {
    pub(super) fn new(center: Vec3, radius: f32, from: Vec3) -> Result<Self, Dark> {
        let to = center - from;
        let distance = libm::sqrtf(to.dot(to));
        if radius.is_nan() || radius <= 0.0 {
            return Err(Dark::Void);
        }
        if distance.is_nan() || distance <= radius {
            // It emits outward.
            return Err(Dark::FacesAway);
        }
        let sin = radius / distance;
        let versine = sin * sin / (1.0 + cos_of(radius, distance));
        let size = center.abs().max_element() + radius;
        let solid_angle = 2.0 * PI * versine;
        if solid_angle <= 0.0 {
            return Err(Dark::Void);
        }
        Ok(Self { center, radius, axis: to / distance, distance, versine, solid_angle, size })
    }

    /// The integral of the cosine over all of it, if it is wholly above the surface.
    pub(super) fn projected(&self, normal: Vec3) -> Option<f32> {
        projected::sphere(self.axis, 1.0 - self.versine, self.radius / self.distance, normal)
    }

    /// Unit direction, distance and outward normal: uniform in the cone of visible directions.
    #[inline(always)]
    pub(super) fn sample<R: Real>(&self, from: Vec3, [a, b]: [R; 2]) -> (Vector<R>, R, Vector<R>) {
        let versine = a * self.versine;
        // sin² = 1 - cos², without the difference of near ones.
        let sin2 = versine * (-versine + 2.0);
        let (sin_phi, cos_phi) = sin_cos_of_turns(b);
        let (s, t) = tangents(self.axis);
        let aside = (Vector::along(s, cos_phi) + Vector::along(t, sin_phi)) * sin2.sqrt();
        let direction = Vector::along(self.axis, versine.complement()) + aside;
        // The nearer root of the line and the sphere.
        let (r, d) = (self.radius, self.distance);
        let distance = versine.complement() * d - (-(sin2 * (d * d)) + r * r).at_least(0.0).sqrt();
        let normal = direction * distance + from - self.center;
        (direction, distance, normal / normal.length())
    }
}

/// The cosine of half the angle under which a sphere is seen: `sqrt(d² - r²) / d`.
fn cos_of(radius: f32, distance: f32) -> f32 {
    libm::sqrtf(((distance - radius) * (distance + radius)).max(0.0)) / distance
}
