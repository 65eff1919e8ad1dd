use super::flat::concentric;
use super::triangle::unit;
use crate::real::{Real, Vector};
use core::f32::consts::PI;
use glam::Vec3;

/// A disc, sampled by the directions under which the origin sees it.
///
/// They fill an elliptic cone, `x² / sin²α + y² / sin²β <= 1` for unit directions `(x, y, z)` in the frame of the cone's axes
/// (Guillén et al. 2017, "Area-preserving parameterizations for spherical ellipses", section 3). The area of this ellipse is sampled
/// evenly: not quite uniform in solid angle, by a smooth factor of `1 / z`, but without the elliptic integrals of that paper.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Ellipse {
    x: Vec3,
    y: Vec3,
    z: Vec3,
    /// `π sin α sin β`.
    area: f32,
}

impl Ellipse {
    /// The disc's `center` is seen from the point; `normal` is its unit normal, `u` a radius.
    pub(super) fn new(center: Vec3, normal: Vec3, u: Vec3) -> Option<Self> {
        let radius = libm::sqrtf(u.dot(u));
        let aside = center - normal * center.dot(normal);
        let off = libm::sqrtf(aside.dot(aside));
        // In the plane of the disc's axis and the point lie the cone's extreme directions; its axis halves them.
        let along = if off > 1e-3 * radius { aside / off } else { u / radius };
        let (near, far) = (unit(center - along * radius)?, unit(center + along * radius)?);
        let z = unit(near + far)?;
        let chord = far - near;
        let sin_alpha = 0.5 * libm::sqrtf(chord.dot(chord));
        let x = unit(chord)?;
        let y = z.cross(x);
        // The third point: the end of the radius at right angles lies on the cone too.
        let edge = unit(center + normal.cross(along) * radius)?;
        let (ex, ey) = (edge.dot(x) / sin_alpha, edge.dot(y));
        let sin2_beta = ey * ey / (1.0 - ex * ex);
        if !(sin2_beta > 1e-6 && sin2_beta < 0.999 && sin_alpha > 1e-3 && sin_alpha < 0.999) {
            return None;
        }
        let sin_beta = libm::sqrtf(sin2_beta);
        Some(Self { x: x * sin_alpha, y: y * sin_beta, z, area: PI * sin_alpha * sin_beta })
    }

    /// A unit direction, and one over its density.
    #[inline(always)]
    pub(super) fn sample<R: Real>(&self, [a, b]: [R; 2]) -> (Vector<R>, R) {
        let (s, t) = concentric(a, b);
        let aside = Vector::along(self.x, s) + Vector::along(self.y, t);
        let z = aside.dot(aside).complement().sqrt();
        (aside + Vector::along(self.z, z), z.same(self.area) / z)
    }
}
