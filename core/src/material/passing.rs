//! The lobe of what passes a rough sheet.

use super::ward::{EXPONENT_MAX, tangents};
use crate::elementary::{exp2, log2, sin_cos_of_turns};
use crate::real::{Real, Vector};
use core::f32::consts::{LN_2, LOG2_E, PI};
use glam::Vec3;

/// Directions about the straight way on: `exp((2 cos γ - 2) / α²) / (π α²)`, as Radiance has it for `trans` (normal.c), a von Mises-Fisher distribution.
/// Here it is normalised, and all that is sampled weighs one, so that no more passes than comes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Passing {
    /// Unit direction of the straight way on.
    pub(super) ahead: Vec3,
    /// Roughness, at least [`ROUGHNESS_MIN`](super::ROUGHNESS_MIN).
    pub(super) alpha: f32,
}

impl Passing {
    /// The density \[1/sr\] of a unit direction.
    #[inline(always)]
    pub(super) fn density<R: Real>(&self, direction: Vector<R>) -> R {
        let alpha2 = self.alpha * self.alpha;
        // 2 - 2 cos γ, without cancellation.
        let chord = direction - self.ahead;
        let exponent = chord.dot(chord) / alpha2;
        let density = exp2(exponent * -LOG2_E) / (PI * alpha2 * self.whole());
        let none = density.same(0.0);
        R::select(none.same(EXPONENT_MAX).above(exponent), density, none)
    }

    /// A direction for two numbers in [0, 1).
    pub(super) fn sample(&self, [u, v]: [f32; 2]) -> Vec3 {
        // 1 - u is above zero: u has 24 bits.
        let exponent = (-LN_2 * log2(1.0 - u * self.whole())).max(0.0);
        let chord2 = (exponent * self.alpha * self.alpha).min(4.0);
        let (sin, cos) = sin_cos_of_turns(v);
        let (s, t) = tangents(self.ahead);
        let aside = libm::sqrtf((chord2 * (1.0 - 0.25 * chord2)).max(0.0));
        let direction = self.ahead * (1.0 - 0.5 * chord2) + (s * cos + t * sin) * aside;
        direction / libm::sqrtf(direction.dot(direction))
    }

    /// The part of the distribution that the sphere has.
    fn whole(&self) -> f32 {
        1.0 - exp2(-4.0 * LOG2_E / (self.alpha * self.alpha))
    }
}
