use crate::elementary::{exp2, log2};
use glam::Vec3;

/// How much light a shadow ray has lost to the panes it crossed: a sum of integers, so the order of the crossings cannot matter.
///
/// Per channel the binary logarithm of what was lost, in steps of 2⁻²⁰ (a step is 7e-7 of the light).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct OpticalDepth([u32; 3]);

/// Steps of the fixed-point logarithm in a factor of two.
const STEPS: f32 = (1 << 20) as f32;

impl OpticalDepth {
    /// Nothing in the way.
    pub const CLEAR: Self = Self([0; 3]);
    /// Nothing passes.
    pub const OPAQUE: Self = Self([u32::MAX; 3]);

    /// The depth of something that leaves this part of the light.
    #[must_use]
    pub fn of(transmittance: Vec3) -> Self {
        Self(transmittance.to_array().map(|t| {
            if t >= 1.0 {
                0
            } else if t > 0.0 {
                // At most 126 * 2²⁰, or infinite: no overflow.
                libm::roundf(-log2(t) * STEPS) as u32
            } else {
                u32::MAX
            }
        }))
    }

    /// As plain numbers.
    #[must_use]
    pub const fn steps(self) -> [u32; 3] {
        self.0
    }

    /// Of plain numbers.
    #[must_use]
    pub const fn of_steps(steps: [u32; 3]) -> Self {
        Self(steps)
    }

    /// Both, one behind the other.
    #[must_use]
    pub fn and(self, other: Self) -> Self {
        let ([a0, a1, a2], [b0, b1, b2]) = (self.0, other.0);
        Self([a0.saturating_add(b0), a1.saturating_add(b1), a2.saturating_add(b2)])
    }

    /// Whether nothing is left in any channel.
    #[must_use]
    pub fn is_opaque(self) -> bool {
        self == Self::OPAQUE
    }

    /// The part of the light that is left.
    #[must_use]
    pub fn transmittance(self) -> Vec3 {
        if self == Self::CLEAR {
            return Vec3::ONE;
        }
        Vec3::from(self.0.map(|steps| exp2(-(steps as f32 / STEPS))))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn depths_multiply_in_any_order(t in prop::collection::vec(1e-3f32..1.0, 1..8)) {
            let depths: std::vec::Vec<_> = t.iter().map(|&t| OpticalDepth::of(Vec3::new(t, 1.0, 0.0))).collect();
            let forward = depths.iter().fold(OpticalDepth::CLEAR, |a, &b| a.and(b));
            let backward = depths.iter().rev().fold(OpticalDepth::CLEAR, |a, &b| b.and(a));
            prop_assert_eq!(forward, backward);
            let product: f64 = t.iter().map(|&t| f64::from(t)).product();
            let left = forward.transmittance();
            prop_assert!((f64::from(left.x) / product - 1.0).abs() < 2e-5);
            prop_assert_eq!((left.y, left.z), (1.0, 0.0));
        }
    }

    #[test]
    fn the_ends_of_the_scale() {
        assert_eq!(OpticalDepth::of(Vec3::ONE), OpticalDepth::CLEAR);
        assert!(OpticalDepth::of(Vec3::ZERO).is_opaque());
        assert!(OpticalDepth::of(Vec3::splat(f32::NAN)).is_opaque());
        assert_eq!(OpticalDepth::OPAQUE.and(OpticalDepth::OPAQUE).transmittance(), Vec3::ZERO);
    }
}
