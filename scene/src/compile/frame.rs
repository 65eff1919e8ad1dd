//! Where the scene lies: the frame of [`kiloray_core::scene::Frame`] in f64.

use glam::DVec3;
use kiloray_core::scene::Frame;

use crate::model::Model;

/// From input to scene coordinates: `scene = (input - center) * 2^-exponent`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Placement {
    pub(crate) center: DVec3,
    pub(crate) exponent: i32,
    /// Lower corner of all surfaces, input coordinates.
    pub(crate) lo: DVec3,
    /// Upper corner.
    pub(crate) hi: DVec3,
}

impl Placement {
    /// Binary exponents that f64 can hold both ways.
    const EXPONENT_MAX: i32 = 1020;

    /// Fits all surfaces of the model into [-1, 1]³.
    pub(crate) fn of(model: &Model) -> Self {
        let (mut lo, mut hi) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for triangle in &model.triangles {
            for &v in &triangle.vertices {
                if let Some(&p) = model.vertices.get(v as usize) {
                    (lo, hi) = (lo.min(p), hi.max(p));
                }
            }
        }
        for sphere in &model.spheres {
            (lo, hi) =
                (lo.min(sphere.center - sphere.radius), hi.max(sphere.center + sphere.radius));
        }
        if !(lo.is_finite() && hi.is_finite()) {
            let zero = DVec3::ZERO;
            return Self { center: zero, exponent: 0, lo: zero, hi: zero };
        }
        // Halves first: the difference of two finite numbers need not be finite.
        let center = lo * 0.5 + hi * 0.5;
        let reach = (hi - center).max(center - lo).max_element();
        Self { center, exponent: exponent_above(reach), lo, hi }
    }

    /// Scene units in one input unit.
    pub(crate) fn scale(self) -> f64 {
        exp2(-self.exponent)
    }

    pub(crate) fn point(self, p: DVec3) -> DVec3 {
        (p - self.center) * self.scale()
    }

    /// The entry of the file. `error` in scene units.
    pub(crate) fn frame(self, error: f64) -> Frame {
        Frame {
            center: self.center.to_array(),
            exponent: self.exponent,
            position_error: (error * exp2(self.exponent)) as f32,
        }
    }
}

/// The least `e` with `reach * 2^-e <= 1`, within what f64 can scale by.
fn exponent_above(reach: f64) -> i32 {
    let mut e = -Placement::EXPONENT_MAX;
    if reach > 0.0 {
        e = (libm::log2(reach).ceil() as i32)
            .clamp(-Placement::EXPONENT_MAX, Placement::EXPONENT_MAX);
        // The logarithm may be off by one on either side of a power of two.
        while e < Placement::EXPONENT_MAX && reach * exp2(-e) > 1.0 {
            e += 1;
        }
        while e > -Placement::EXPONENT_MAX && reach * exp2(1 - e) <= 1.0 {
            e -= 1;
        }
    }
    e
}

/// `2^e`, exact for `|e| <= 1022`.
fn exp2(e: i32) -> f64 {
    f64::from_bits(((e + 1023) as u64) << 52)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_exponent_is_the_least_that_fits() {
        for (reach, e) in [(1.0, 0), (1.0 + f64::EPSILON, 1), (0.5, -1), (0.75, 0), (3.0, 2)] {
            assert_eq!(exponent_above(reach), e, "{reach}");
        }
        assert_eq!(exponent_above(2f64.powi(-300)), -300);
        // What f64 cannot scale by both ways stays within it.
        assert_eq!(exponent_above(0.0), -1020);
        assert_eq!(exponent_above(5e-324), -1020);
        assert_eq!(exponent_above(1.7e308), 1020);
    }
}
