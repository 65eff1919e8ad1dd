//! Elementary functions in f32: sums and products in one written order, so that all machines get the same bits.
//!
//! `libm` has them for any argument, to the last bit, and takes 6 KiB of a board's flash and arithmetic in f64 for it. Here arguments are as
//! short as sampling makes them, and an ulp or two is nothing beside what is sampled.

use crate::real::{Bits, Part, Real};
use core::f32::consts::{FRAC_1_SQRT_2, FRAC_PI_2, LN_2, PI};

/// The value of a polynomial, the coefficient of the lowest power first.
#[inline(always)]
fn polynomial<R: Real>(x: R, coefficients: &[f32]) -> R {
    let mut sum = x.same(0.0);
    for &c in coefficients.iter().rev() {
        sum = sum * x + c;
    }
    sum
}

/// Sine and cosine of an angle in turns, of which there are fewer than 2²⁰. Error: 2⁻²³.
#[inline(always)]
pub(crate) fn sin_cos_of_turns<R: Real>(turns: R) -> (R, R) {
    R::apart(SinCos(turns))
}

struct SinCos<R>(R);

impl<R: Real> Part for SinCos<R> {
    type Result = (R, R);

    #[inline(always)]
    fn run(self) -> (R, R) {
        // Both steps are exact: a multiple of a power of two, and what is left of it.
        let quarters = self.0 * 4.0;
        let nearest = quarters.nearest();
        let r = quarters - nearest.real();
        let r2 = r * r;
        let sin = r * polynomial(r2, &[1.570_796_4, -0.645_963_5, 0.079_680_03, -0.004_601_658]);
        let cos =
            polynomial(r2, &[1.0, -1.233_700_5, 0.253_669_26, -0.020_860_309, 0.000_904_060_55]);
        // Without branches: in which quarter a sample lies nobody can foretell.
        let is_even = (nearest & 1).is_zero();
        let (sin, cos) = (R::select(is_even, sin, cos), R::select(is_even, cos, sin));
        let sin = R::of_bits(sin.bits() ^ (nearest & 2) << 30);
        (sin, R::of_bits(cos.bits() ^ (nearest.plus(1) & 2) << 30))
    }
}

/// The angle \[radians\] of a vector to the x axis, in (-π, π]. Error: 2⁻²² of it.
#[inline(always)]
pub(crate) fn angle<R: Real>(y: R, x: R) -> R {
    R::apart(Angle(y, x))
}

struct Angle<R>(R, R);

impl<R: Real> Part for Angle<R> {
    type Result = R;

    #[inline(always)]
    fn run(self) -> R {
        const ATAN: [f32; 9] = [
            1.0,
            -0.333_330_72,
            0.199_926_2,
            -0.142_036_45,
            0.106_409_34,
            -0.075_042_956,
            0.042_691_53,
            -0.016_068_636,
            0.002_849_891_3,
        ];
        let Self(y, x) = self;
        let (up, aside) = (y.abs(), x.abs());
        let is_steep = up.above(aside);
        let z = R::select(is_steep, aside, up) / R::select(is_steep, up, aside);
        let angle = z * polynomial(z * z, &ATAN);
        let angle = R::select(is_steep, -angle + FRAC_PI_2, angle);
        let angle = R::select((-x).is_positive(), -angle + PI, angle);
        angle.copysign(y)
    }
}

/// The arc sine \[radians\] of -1 to 1. Error: 2⁻²² of it.
pub(crate) fn asin(sin: f32) -> f32 {
    angle(sin, libm::sqrtf((1.0 - sin) * (1.0 + sin)))
}

/// Two to a power of at most 127; 0 where no normal number is near. Error: 2⁻²³ of it.
#[inline(always)]
pub(crate) fn exp2<R: Real>(x: R) -> R {
    R::apart(Exp2(x))
}

struct Exp2<R>(R);

impl<R: Real> Part for Exp2<R> {
    type Result = R;

    #[inline(always)]
    fn run(self) -> R {
        const EXP2: [f32; 7] =
            [1.0, LN_2, 0.240_226_5, 0.055_503_28, 0.009_618_004, 0.001_340_023_5, 0.000_154_762_8];
        let x = self.0.at_least(-127.0);
        let nearest = x.nearest();
        // Its bits are an exponent alone: 0 for the power of -127.
        polynomial(x - nearest.real(), &EXP2) * R::of_bits(nearest.plus(127) << 23)
    }
}

/// The binary logarithm of what is above zero; of 0, and of less than the least normal number, negative infinity. Error: 2⁻²² of it.
pub(crate) fn log2(x: f32) -> f32 {
    if x < f32::MIN_POSITIVE {
        return f32::NEG_INFINITY;
    }
    // x = m 2^e, with m between √½ and √2: near 1 nothing cancels.
    let mut e = exponent(x);
    let mut m = f32::from_bits(x.to_bits() & 0x7f_ffff | 0.5_f32.to_bits());
    if m < FRAC_1_SQRT_2 {
        m *= 2.0;
        e -= 1;
    }
    // ln m = 2 artanh s.
    let s = (m - 1.0) / (m + 1.0);
    s * polynomial(s * s, &[2.885_39, 0.961_798_85, 0.576_713_86, 0.431_748_33]) + e as f32
}

/// The least power of two that a normal number is below; of what is nearer to 0 one that is less.
pub(crate) const fn exponent(x: f32) -> i32 {
    (x.to_bits() >> 23 & 0xff) as i32 - 126
}

/// Two to a power, as far as it is a normal number.
pub(crate) fn power_of_two(power: i32) -> f32 {
    f32::from_bits(((power.clamp(-126, 127) + 127) as u32) << 23)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Numbers between two others, each float where they are few, else a million.
    fn sweep(from: f32, to: f32) -> impl Iterator<Item = f32> {
        let n = 1_000_000;
        (0..=n).map(move |i| from + (to - from) * (i as f32 / n as f32))
    }

    #[track_caller]
    fn is_near(found: f32, exact: f64, error: f64) {
        assert!((f64::from(found) - exact).abs() <= error, "{found} {exact}");
    }

    #[test]
    fn sine_and_cosine_are_within_an_ulp_of_one() {
        for turns in sweep(-2.0, 2.0).chain(sweep(0.0, 1.0)) {
            let exact = (f64::from(turns) * core::f64::consts::TAU).sin_cos();
            let (sin, cos) = sin_cos_of_turns(turns);
            is_near(sin, exact.0, f64::from(f32::EPSILON));
            is_near(cos, exact.1, f64::from(f32::EPSILON));
        }
        assert_eq!(sin_cos_of_turns(0.0), (0.0, 1.0));
        assert_eq!(sin_cos_of_turns(0.25), (1.0, 0.0));
        assert_eq!(sin_cos_of_turns(-0.75), (1.0, 0.0));
        assert_eq!(sin_cos_of_turns(0.5), (0.0, -1.0));
    }

    #[test]
    fn angles_are_those_of_f64() {
        let epsilon = f64::from(f32::EPSILON);
        for x in sweep(-1.0, 1.0) {
            let exact = f64::from(x).asin();
            is_near(asin(x), exact, exact.abs() * 2.0 * epsilon);
            for (y, x) in [(x, 0.7), (x, -0.7), (0.7, x), (-0.7, x)] {
                let exact = f64::from(y).atan2(f64::from(x));
                is_near(angle(y, x), exact, exact.abs() * 2.0 * epsilon);
            }
        }
        assert_eq!((angle(0.0, 1.0), angle(1.0, 0.0)), (0.0, FRAC_PI_2));
        assert_eq!((asin(1.0), asin(-1.0)), (FRAC_PI_2, -FRAC_PI_2));
    }

    #[test]
    fn powers_and_logarithms_are_those_of_f64() {
        let epsilon = f64::from(f32::EPSILON);
        for x in sweep(-126.0, 127.0).chain(sweep(-1.0, 1.0)) {
            let exact = f64::from(x).exp2();
            is_near(exp2(x), exact, exact * epsilon);
            let (power, exact) = (exact as f32, f64::from(exact as f32).log2());
            is_near(log2(power), exact, exact.abs() * 2.0 * epsilon);
        }
        for i in -126..=127 {
            assert_eq!((exp2(i as f32), log2(power_of_two(i))), (power_of_two(i), i as f32));
        }
        assert_eq!((exp2(-127.0), exp2(-1e30), exp2(f32::NEG_INFINITY)), (0.0, 0.0, 0.0));
        assert_eq!((log2(0.0), log2(1e-40)), (f32::NEG_INFINITY, f32::NEG_INFINITY));
    }
}
