use crate::elementary::{exponent, power_of_two};
use glam::Vec3;

/// The step of all sums of light: a power of two, chosen from the brightest thing of the scene.
///
/// Light is added as 64-bit integers, so the order cannot matter: not of shadow rays, not of the parts of a path, not of
/// the paths of a pixel. A step is at most 2⁻⁴⁴ of the brightest radiance; 2¹⁸ samples of it fit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Unit {
    /// Steps in a unit of radiance: a power of two.
    steps: f32,
    /// The radiance of a step.
    step: f32,
}

/// Light, as a number of steps per channel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(transparent)]
pub struct Sum(pub [i64; 3]);

impl Unit {
    /// The unit for a scene whose brightest radiance is this ([`Needs::radiance_max`](crate::scene::Needs::radiance_max)).
    #[must_use]
    pub fn new(radiance_max: f32) -> Self {
        let exponent = exponent(if radiance_max.is_finite() { radiance_max } else { 1.0 });
        // Both powers stay normal numbers; a scene darker than 10⁻²⁴ is counted in other steps.
        let exponent = exponent.clamp(-82, 127) - 44;
        Self { steps: power_of_two(-exponent), step: power_of_two(exponent) }
    }

    /// The radiance of a step.
    pub(super) const fn step(&self) -> f32 {
        self.step
    }

    /// Light in steps, to the nearest. NaN and infinity count as none; what is too bright is cut off. A part may be negative, where others are too great.
    #[cfg_attr(feature = "bundles", inline)]
    #[must_use]
    pub fn quantise(&self, light: Vec3) -> Sum {
        Sum([light.x, light.y, light.z].map(|x| steps(x, self.steps)))
    }

    /// The mean radiance of so many samples.
    #[must_use]
    pub fn resolve(&self, sum: Sum, samples: u32) -> Vec3 {
        let n = f64::from(samples.max(1));
        Vec3::from(sum.0.map(|x| (x as f64 * f64::from(self.step) / n) as f32))
    }
}

/// See [`Unit::quantise`].
#[cfg_attr(feature = "bundles", inline)]
#[cfg_attr(not(feature = "bundles"), inline(never))]
fn steps(x: f32, of_one: f32) -> i64 {
    let size = x.abs();
    let steps = if size < f32::INFINITY { nearest(size * of_one) } else { 0 };
    if x < 0.0 { -steps } else { steps }
}

/// The whole number nearest to one that is not negative; of two the greater.
fn nearest(x: f32) -> i64 {
    if x < 8_388_608.0 {
        // Subtracting its whole part from a number below 2²³ is exact.
        let whole = x as i32;
        i64::from(whole) + i64::from(x - whole as f32 >= 0.5)
    } else {
        // It is whole. The cast saturates.
        x as i64
    }
}

impl Sum {
    /// No light.
    pub const ZERO: Self = Self([0; 3]);

    /// Adds. The order does not matter; but for a channel that is full, where the picture is wrong.
    #[inline]
    pub fn add(&mut self, other: Self) {
        for (a, b) in self.0.iter_mut().zip(other.0) {
            *a = a.saturating_add(b);
        }
    }

    /// A channel is full: the picture is wrong there, and says so.
    #[must_use]
    pub fn is_full(&self) -> bool {
        self.0.contains(&i64::MAX)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn sums_agree_with_f64_and_do_not_depend_on_the_order(
            mut light in prop::collection::vec(0f32..1000.0, 1..200),
            by in 0usize..200,
        ) {
            let unit = Unit::new(1000.0);
            let sum = |light: &[f32]| {
                let mut sum = Sum::ZERO;
                for &x in light {
                    sum.add(unit.quantise(Vec3::new(x, 0.5 * x, 0.0)));
                }
                sum
            };
            let forward = sum(&light);
            let n = light.len();
            let exact: f64 = light.iter().map(|&x| f64::from(x)).sum::<f64>() / n as f64;
            light.rotate_left(by % n);
            light.reverse();
            prop_assert_eq!(sum(&light), forward);
            let mean = unit.resolve(forward, n as u32);
            prop_assert!((f64::from(mean.x) - exact).abs() <= exact * 1e-7 + 1e-10);
            prop_assert_eq!(mean.z, 0.0);
        }
    }

    #[test]
    fn steps_are_rounded_to_the_nearest() {
        let mut x = 0.0_f32;
        while x < 1e20 {
            for x in [x, x.next_up(), x.next_down().max(0.0), x.floor() + 0.5, x.ceil()] {
                assert_eq!(nearest(x), x.round() as i64, "{x}");
            }
            x = (x * 1.07).max(x + 0.37);
        }
    }

    #[test]
    fn what_is_no_light_counts_as_none_and_too_much_is_cut_off() {
        let unit = Unit::new(1.0);
        let strange = Vec3::new(f32::NAN, f32::NEG_INFINITY, f32::INFINITY);
        assert_eq!(unit.quantise(strange), Sum::ZERO);
        let mut sum = unit.quantise(Vec3::splat(0.3));
        sum.add(unit.quantise(Vec3::splat(-0.3)));
        assert_eq!(sum, Sum::ZERO);
        let mut sum = unit.quantise(Vec3::splat(1e30));
        assert!(sum.is_full());
        sum.add(unit.quantise(Vec3::ONE));
        assert!(sum.is_full());
        for radiance in [0.0, 1e-38, 1e38, f32::NAN, f32::INFINITY] {
            let unit = Unit::new(radiance);
            assert!(unit.step > 0.0 && unit.steps.is_finite() && unit.step * unit.steps == 1.0);
        }
    }

    #[test]
    fn a_quarter_of_a_million_of_the_brightest_samples_fit() {
        for radiance_max in [1.0_f32, 1.999, 100.0, 3e7, 1e30, f32::MAX, 3e-24, 2.1e-25] {
            let unit = Unit::new(radiance_max);
            let one = unit.quantise(Vec3::splat(radiance_max)).0[0];
            assert!(one < i64::MAX >> 18 && one > i64::MAX >> 21);
        }
    }
}
