use glam::{DVec2, DVec3, Vec3};
use kiloray_core::geometry::Ray;

use super::{EDGE_BOUND, POINT_BOUND};

/// What is true of a line and a triangle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TriangleTruth {
    /// Where the line of the ray crosses the triangle's plane; NaN if it is parallel to it.
    pub t: f64,
    /// How far a hit's `t` may be from it.
    pub t_error: f64,
    /// Seen along the ray: the distance between the ray and the triangle's border, below zero outside.
    pub margin: f64,
    /// Greatest distance along an axis between the ray's origin and a vertex: all bounds are in parts of it.
    pub reach: f64,
}

impl TriangleTruth {
    /// Of a ray with finite numbers, without regard to its `t_min` and `t_max`.
    #[must_use]
    pub fn new(ray: &Ray, vertices: [Vec3; 3]) -> Self {
        let (o, d) = (ray.origin.as_dvec3(), ray.direction.as_dvec3());
        let v = vertices.map(|v| v.as_dvec3() - o);
        let reach = v.iter().fold(0.0, |m: f64, v| m.max(v.abs().max_element()));
        let normal = (v[1] - v[0]).cross(v[2] - v[0]);
        let slope = d.dot(normal);
        let margin = margin(d, v);
        // Plane distance along the normal, turned into a distance along the ray.
        let t_error = POINT_BOUND * reach * normal.length() / slope.abs();
        Self { t: v[0].dot(normal) / slope, t_error, margin, reach }
    }

    /// The line surely passes through the triangle, also to a test of bounded error.
    #[must_use]
    pub fn surely_hit(&self) -> bool {
        self.margin > EDGE_BOUND * self.reach
    }

    /// The line surely passes beside it.
    #[must_use]
    pub fn surely_missed(&self) -> bool {
        self.margin < -EDGE_BOUND * self.reach
    }
}

/// The distance between the line of a direction through the origin and a triangle's border, measured across the direction's
/// axis; below zero outside.
fn margin(d: DVec3, v: [DVec3; 3]) -> f64 {
    let a = d.abs();
    let axis = if a.x >= a.y && a.x >= a.z {
        0
    } else if a.y >= a.z {
        1
    } else {
        2
    };
    let (i, j) = ((axis + 1) % 3, (axis + 2) % 3);
    let flat = v.map(|v| {
        let t = v[axis] / d[axis];
        DVec2::new(v[i] - t * d[i], v[j] - t * d[j])
    });
    let edges = [(0, 1), (1, 2), (2, 0)];
    let border =
        edges.iter().map(|&(a, b)| distance_to_segment(flat[a], flat[b])).fold(f64::MAX, f64::min);
    let side = edges.map(|(a, b)| flat[a].perp_dot(flat[b]));
    let inside = side.iter().all(|&s| s > 0.0) || side.iter().all(|&s| s < 0.0);
    if inside { border } else { -border }
}

/// From the origin.
fn distance_to_segment(a: DVec2, b: DVec2) -> f64 {
    let along = b - a;
    let s = if along == DVec2::ZERO { 0.0 } else { -a.dot(along) / along.length_squared() };
    (a + along * s.clamp(0.0, 1.0)).length()
}

/// The distance between a point and a triangle in space.
#[must_use]
pub fn distance_to_triangle(p: DVec3, vertices: [Vec3; 3]) -> f64 {
    let [a, b, c] = vertices.map(|v| v.as_dvec3() - p);
    let segment = |a: DVec3, b: DVec3| {
        let along = b - a;
        let s = if along == DVec3::ZERO { 0.0 } else { -a.dot(along) / along.length_squared() };
        (a + along * s.clamp(0.0, 1.0)).length()
    };
    let mut least = segment(a, b).min(segment(b, c)).min(segment(c, a));
    let normal = (b - a).cross(c - a);
    let inside = [(a, b), (b, c), (c, a)].iter().all(|&(a, b)| a.cross(b).dot(normal) >= 0.0);
    if inside && normal != DVec3::ZERO {
        least = least.min((a.dot(normal) / normal.length()).abs());
    }
    least
}
