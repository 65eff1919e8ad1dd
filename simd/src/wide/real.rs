//! Eight numbers at a time, for samples of light.
//!
//! Each operation is one of IEEE 754, and nothing is fused: every lane has the bits that `f32` has in [`kiloray_core::real`].

#[allow(clippy::wildcard_imports, reason = "a kernel names a hundred instructions")]
use core::arch::x86_64::*;
use core::ops::{Add, BitAnd, BitOr, BitXor, Div, Mul, Neg, Not, Shl, Shr, Sub};

use kiloray_core::real::{Bits, LANES, Mask, Number, Real};

use super::double::EightDouble;

/// Eight f32. Whoever has one has [`Wide`](super::Wide) lanes, so the machine has AVX2: they are read and [counted](Whole::count_from) by such lanes, and made from one another.
#[derive(Debug, Clone, Copy)]
pub struct Eight(pub(super) __m256);

/// Eight whole numbers.
#[derive(Debug, Clone, Copy)]
pub struct Whole(__m256i);

/// Eight answers: all bits of a lane, or none.
#[derive(Debug, Clone, Copy)]
pub struct Answers(pub(super) __m256);

/// One expression of instructions: a value of AVX2 exists wherever it stands.
macro_rules! avx2 {
    ($e:expr) => {
        // SAFETY: operands exist, so the machine has AVX2; loads and stores are of eight places that a reference has.
        unsafe { $e }
    };
}

pub(super) use avx2;

macro_rules! operators {
    ($type:ident, $operand:ty, $($trait:ident $method:ident |$a:ident, $b:ident| $e:expr;)*) => {
        $(impl $trait<$operand> for $type {
            type Output = Self;

            #[inline(always)]
            fn $method(self, other: $operand) -> Self {
                let ($a, $b) = (self.0, other);
                Self(avx2!($e))
            }
        })*
    };
}

operators! {Eight, Self,
    Add add |a, b| _mm256_add_ps(a, b.0);
    Sub sub |a, b| _mm256_sub_ps(a, b.0);
    Mul mul |a, b| _mm256_mul_ps(a, b.0);
    Div div |a, b| _mm256_div_ps(a, b.0);
}

operators! {Eight, f32,
    Add add |a, b| _mm256_add_ps(a, _mm256_set1_ps(b));
    Sub sub |a, b| _mm256_sub_ps(a, _mm256_set1_ps(b));
    Mul mul |a, b| _mm256_mul_ps(a, _mm256_set1_ps(b));
    Div div |a, b| _mm256_div_ps(a, _mm256_set1_ps(b));
}

operators! {Whole, Self,
    BitXor bitxor |a, b| _mm256_xor_si256(a, b.0);
}

operators! {Whole, u32,
    BitXor bitxor |a, b| _mm256_xor_si256(a, _mm256_set1_epi32(b as i32));
    BitAnd bitand |a, b| _mm256_and_si256(a, _mm256_set1_epi32(b as i32));
    BitOr bitor |a, b| _mm256_or_si256(a, _mm256_set1_epi32(b as i32));
    Shl shl |a, b| _mm256_sll_epi32(a, _mm_cvtsi32_si128(b as i32));
    Shr shr |a, b| _mm256_srl_epi32(a, _mm_cvtsi32_si128(b as i32));
}

operators! {Answers, Self,
    BitAnd bitand |a, b| _mm256_and_ps(a, b.0);
    BitOr bitor |a, b| _mm256_or_ps(a, b.0);
}

impl Not for Answers {
    type Output = Self;

    #[inline(always)]
    fn not(self) -> Self {
        Self(avx2!(_mm256_xor_ps(self.0, _mm256_castsi256_ps(_mm256_set1_epi32(-1)))))
    }
}

impl Neg for Eight {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        Self(avx2!(_mm256_xor_ps(self.0, _mm256_set1_ps(-0.0))))
    }
}

impl Number for Eight {
    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(avx2!(_mm256_sqrt_ps(self.0)))
    }

    #[inline(always)]
    fn abs(self) -> Self {
        Self(avx2!(_mm256_andnot_ps(_mm256_set1_ps(-0.0), self.0)))
    }

    #[inline(always)]
    fn greater(self, other: Self) -> Self {
        Self(avx2!(_mm256_max_ps(self.0, other.0)))
    }
}

impl Real for Eight {
    type Mask = Answers;
    type Bits = Whole;
    type Double = EightDouble;

    const COUNT: usize = LANES;

    #[inline(always)]
    fn same(self, x: f32) -> Self {
        Self(avx2!(_mm256_set1_ps(x)))
    }

    #[inline(always)]
    fn double(self) -> EightDouble {
        EightDouble::of(self.0)
    }

    #[inline(always)]
    fn copysign(self, sign: Self) -> Self {
        let bit = avx2!(_mm256_set1_ps(-0.0));
        Self(avx2!(_mm256_or_ps(_mm256_andnot_ps(bit, self.0), _mm256_and_ps(bit, sign.0))))
    }

    #[inline(always)]
    fn lesser(self, other: Self) -> Self {
        Self(avx2!(_mm256_min_ps(self.0, other.0)))
    }

    #[inline(always)]
    fn above(self, other: Self) -> Answers {
        Answers(avx2!(_mm256_cmp_ps::<_CMP_GT_OQ>(self.0, other.0)))
    }

    #[inline(always)]
    fn select(mask: Answers, yes: Self, no: Self) -> Self {
        Self(avx2!(_mm256_blendv_ps(no.0, yes.0, mask.0)))
    }

    #[inline(always)]
    fn bits(self) -> Whole {
        Whole(avx2!(_mm256_castps_si256(self.0)))
    }

    #[inline(always)]
    fn of_bits(bits: Whole) -> Self {
        Self(avx2!(_mm256_castsi256_ps(bits.0)))
    }

    #[inline(always)]
    fn whole(self) -> Whole {
        Whole(avx2!(_mm256_cvttps_epi32(self.0)))
    }

    #[inline(always)]
    fn store(self, to: &mut [f32; LANES]) {
        avx2!(_mm256_storeu_ps(to.as_mut_ptr(), self.0));
    }
}

impl Eight {
    /// Numbers as they stand.
    ///
    /// # Safety
    /// The machine has AVX2.
    #[inline(always)]
    pub(super) unsafe fn read(row: &[f32; LANES]) -> Self {
        Self(avx2!(_mm256_loadu_ps(row.as_ptr())))
    }
}

impl Whole {
    /// Numbers as they stand.
    ///
    /// # Safety
    /// The machine has AVX2.
    #[inline(always)]
    pub(super) unsafe fn read(row: &[u32; LANES]) -> Self {
        Self(avx2!(_mm256_loadu_si256(row.as_ptr().cast())))
    }

    /// `first`, and one more in each lane.
    ///
    /// # Safety
    /// The machine has AVX2.
    #[inline(always)]
    pub(super) unsafe fn count_from(first: u32) -> Self {
        let steps = avx2!(_mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7));
        Self(steps).plus(first)
    }
}

impl Bits for Whole {
    type Real = Eight;
    type Mask = Answers;

    #[inline(always)]
    fn same(self, x: u32) -> Self {
        Self(avx2!(_mm256_set1_epi32(x as i32)))
    }

    #[inline(always)]
    fn sum(self, other: Self) -> Self {
        Self(avx2!(_mm256_add_epi32(self.0, other.0)))
    }

    #[inline(always)]
    fn product(self, other: Self) -> Self {
        Self(avx2!(_mm256_mullo_epi32(self.0, other.0)))
    }

    #[inline(always)]
    fn reversed(self) -> Self {
        // The bytes of each number, then the halves of each byte, each half by a table.
        avx2!({
            let bytes = _mm256_setr_epi8(
                3, 2, 1, 0, 7, 6, 5, 4, 11, 10, 9, 8, 15, 14, 13, 12, 3, 2, 1, 0, 7, 6, 5, 4, 11,
                10, 9, 8, 15, 14, 13, 12,
            );
            let table = _mm256_setr_epi8(
                0, 8, 4, 12, 2, 10, 6, 14, 1, 9, 5, 13, 3, 11, 7, 15, 0, 8, 4, 12, 2, 10, 6, 14, 1,
                9, 5, 13, 3, 11, 7, 15,
            );
            let half = _mm256_set1_epi8(15);
            let x = _mm256_shuffle_epi8(self.0, bytes);
            let low = _mm256_shuffle_epi8(table, _mm256_and_si256(x, half));
            let high = _mm256_and_si256(_mm256_srli_epi16::<4>(x), half);
            Self(_mm256_or_si256(_mm256_slli_epi16::<4>(low), _mm256_shuffle_epi8(table, high)))
        })
    }

    #[inline(always)]
    fn is_zero(self) -> Answers {
        let zero = avx2!(_mm256_cmpeq_epi32(self.0, _mm256_setzero_si256()));
        Answers(avx2!(_mm256_castsi256_ps(zero)))
    }

    #[inline(always)]
    fn select(mask: Answers, yes: Self, no: Self) -> Self {
        let mask = avx2!(_mm256_castps_si256(mask.0));
        Self(avx2!(_mm256_blendv_epi8(no.0, yes.0, mask)))
    }

    #[inline(always)]
    fn real(self) -> Eight {
        Eight(avx2!(_mm256_cvtepi32_ps(self.0)))
    }
}

impl Mask for Answers {
    #[inline(always)]
    fn lanes(self) -> u32 {
        avx2!(_mm256_movemask_ps(self.0)) as u32
    }
}
