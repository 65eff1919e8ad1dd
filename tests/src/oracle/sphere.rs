use glam::Vec3;
use kiloray_core::geometry::Ray;

use super::RIM_BOUND;

/// What is true of a line and a sphere.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SphereTruth {
    /// Where the line enters and leaves; NaN if it misses.
    pub t: [f64; 2],
    /// How far inside the sphere the line comes, below zero if it misses.
    pub margin: f64,
    /// Greatest distance along an axis between the ray's origin and a point of the sphere.
    pub reach: f64,
}

impl SphereTruth {
    /// Of a ray with finite numbers, without regard to its `t_min` and `t_max`.
    #[must_use]
    pub fn new(ray: &Ray, center: Vec3, radius: f32) -> Self {
        let d = ray.direction.as_dvec3();
        let (length, unit) = (d.length(), d.normalize());
        let to = center.as_dvec3() - ray.origin.as_dvec3();
        let middle = to.dot(unit);
        // The part of `to` across the ray: no difference of squares.
        let distance = to.cross(unit).length();
        let r = f64::from(radius);
        let half = ((r - distance) * (r + distance)).sqrt();
        Self {
            t: [(middle - half) / length, (middle + half) / length],
            margin: r - distance,
            reach: to.abs().max_element() + r,
        }
    }

    /// The line surely crosses the sphere.
    #[must_use]
    pub fn surely_hit(&self) -> bool {
        self.margin > RIM_BOUND * self.reach
    }

    /// The line surely misses it.
    #[must_use]
    pub fn surely_missed(&self) -> bool {
        self.margin < -RIM_BOUND * self.reach
    }
}
