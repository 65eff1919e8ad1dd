//! Eight f64, for places of surfaces.

#[allow(clippy::wildcard_imports, reason = "a kernel names a hundred instructions")]
use core::arch::x86_64::*;
use core::ops::{Add, Div, Mul, Neg, Sub};

use kiloray_core::real::{Double, Number};

use super::real::{Answers, Eight, avx2};

/// Eight f64, the first four and the others. They are made from [`Eight`], so the machine has AVX2.
#[derive(Debug, Clone, Copy)]
pub struct EightDouble([__m256d; 2]);

impl EightDouble {
    /// The same numbers.
    #[inline(always)]
    pub(super) fn of(numbers: __m256) -> Self {
        Self(avx2!([
            _mm256_cvtps_pd(_mm256_castps256_ps128(numbers)),
            _mm256_cvtps_pd(_mm256_extractf128_ps::<1>(numbers)),
        ]))
    }
}

/// The same of both halves. (A closure would be compiled without the instructions.)
macro_rules! both {
    ($a:expr, |$x:ident| $e:expr) => {{
        let [low, high] = $a.0;
        EightDouble([
            {
                let $x = low;
                avx2!($e)
            },
            {
                let $x = high;
                avx2!($e)
            },
        ])
    }};
    ($a:expr, $b:expr, |$x:ident, $y:ident| $e:expr) => {{
        let ([a, b], [c, d]) = ($a.0, $b.0);
        EightDouble([
            {
                let ($x, $y) = (a, c);
                avx2!($e)
            },
            {
                let ($x, $y) = (b, d);
                avx2!($e)
            },
        ])
    }};
}

macro_rules! operators {
    ($($trait:ident $method:ident $instruction:ident;)*) => {
        $(impl $trait for EightDouble {
            type Output = Self;

            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                both!(self, other, |a, b| $instruction(a, b))
            }
        })*
    };
}

operators! {
    Add add _mm256_add_pd;
    Sub sub _mm256_sub_pd;
    Mul mul _mm256_mul_pd;
    Div div _mm256_div_pd;
}

impl Neg for EightDouble {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        both!(self, |a| _mm256_xor_pd(a, _mm256_set1_pd(-0.0)))
    }
}

impl Number for EightDouble {
    #[inline(always)]
    fn sqrt(self) -> Self {
        both!(self, |a| _mm256_sqrt_pd(a))
    }

    #[inline(always)]
    fn abs(self) -> Self {
        both!(self, |a| _mm256_andnot_pd(_mm256_set1_pd(-0.0), a))
    }

    #[inline(always)]
    fn greater(self, other: Self) -> Self {
        both!(self, other, |a, b| _mm256_max_pd(a, b))
    }
}

impl Double for EightDouble {
    type Real = Eight;

    #[inline(always)]
    fn same(self, x: f64) -> Self {
        Self([avx2!(_mm256_set1_pd(x)); 2])
    }

    #[inline(always)]
    fn above(self, other: Self) -> Answers {
        let [low, high] = both!(self, other, |a, b| _mm256_cmp_pd::<_CMP_GT_OQ>(a, b)).0;
        // Of each answer one half.
        avx2!({
            let [low, high] = [_mm256_castpd_ps(low), _mm256_castpd_ps(high)];
            let pairs = _mm256_castps_pd(_mm256_shuffle_ps::<0b10_00_10_00>(low, high));
            Answers(_mm256_castpd_ps(_mm256_permute4x64_pd::<0b11_01_10_00>(pairs)))
        })
    }

    #[inline(always)]
    fn single(self) -> Eight {
        let [low, high] = self.0;
        Eight(avx2!(_mm256_set_m128(_mm256_cvtpd_ps(high), _mm256_cvtpd_ps(low))))
    }

    #[inline(always)]
    fn turned(self, by: Eight) -> Self {
        let none = avx2!(_mm256_setzero_ps());
        let is_below = avx2!(_mm256_cmp_ps::<_CMP_LT_OQ>(by.0, none));
        // Minus one in f32 and in f64 is the sign, for a number that is not zero.
        let signs = Self::of(avx2!(_mm256_and_ps(is_below, _mm256_set1_ps(-1.0))));
        both!(self, signs, |a, sign| _mm256_xor_pd(a, _mm256_and_pd(sign, _mm256_set1_pd(-0.0))))
    }
}
