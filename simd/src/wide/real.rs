//! Eight numbers at a time, for samples of light.
//!
//! Each operation is one of IEEE 754, and nothing is fused: every lane has the bits that `f32` has in [`kiloray_core::real`].

#[allow(clippy::wildcard_imports, reason = "a kernel names a hundred instructions")]
use core::arch::x86_64::*;
use core::ops::{Add, BitAnd, BitOr, BitXor, Div, Mul, Neg, Not, Shl, Shr, Sub};

use kiloray_core::real::{Bits, LANES, Mask, Real};

/// Eight f32. Whoever has one has [`Wide`](super::Wide) lanes, so the machine has AVX2: they are read and [counted](Whole::count_from) by such lanes, and made from one another.
#[derive(Debug, Clone, Copy)]
pub struct Eight(__m256);

/// Eight whole numbers.
#[derive(Debug, Clone, Copy)]
pub struct Whole(__m256i);

/// Eight answers: all bits of a lane, or none.
#[derive(Debug, Clone, Copy)]
pub struct Answers(__m256);

/// One expression of instructions: a value of AVX2 exists wherever it stands.
macro_rules! avx2 {
    ($e:expr) => {
        // SAFETY: operands exist, so the machine has AVX2; loads and stores are of eight places that a reference has.
        unsafe { $e }
    };
}

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

impl Real for Eight {
    type Mask = Answers;
    type Bits = Whole;

    const COUNT: usize = LANES;

    #[inline(always)]
    fn same(self, x: f32) -> Self {
        Self(avx2!(_mm256_set1_ps(x)))
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(avx2!(_mm256_sqrt_ps(self.0)))
    }

    #[inline(always)]
    fn abs(self) -> Self {
        Self(avx2!(_mm256_andnot_ps(_mm256_set1_ps(-0.0), self.0)))
    }

    #[inline(always)]
    fn copysign(self, sign: Self) -> Self {
        let bit = avx2!(_mm256_set1_ps(-0.0));
        Self(avx2!(_mm256_or_ps(_mm256_andnot_ps(bit, self.0), _mm256_and_ps(bit, sign.0))))
    }

    #[inline(always)]
    fn greater(self, other: Self) -> Self {
        Self(avx2!(_mm256_max_ps(self.0, other.0)))
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Avx2;
    use kiloray_core::trace::Lanes;
    use proptest::prelude::*;

    /// Eight numbers of these bits.
    fn eight(proof: Avx2, bits: [u32; LANES]) -> Eight {
        proof.read(&bits.map(f32::from_bits), 0)
    }

    fn stored(x: Eight) -> [f32; LANES] {
        let mut to = [0.0; LANES];
        x.store(&mut to);
        to
    }

    /// The bits of a number; of all NaN the same.
    fn bits(x: f32) -> u32 {
        if x.is_nan() { f32::NAN.to_bits() } else { x.to_bits() }
    }

    /// Numbers near 1, all others, and those at the ends.
    fn numbers() -> impl Strategy<Value = [u32; LANES]> {
        let ends = [0.0, -0.0, 1.0, f32::INFINITY, f32::MIN_POSITIVE, f32::NAN, f32::MAX, 1e-45];
        let number = prop_oneof![
            (-3f32..3.0).prop_map(f32::to_bits),
            any::<u32>(),
            prop::sample::select(ends.map(f32::to_bits).to_vec()),
        ];
        prop::array::uniform8(number)
    }

    proptest! {
        #[test]
        fn lanes_do_what_single_numbers_do(a in numbers(), b in numbers(), x: u32, shift in 0_u32..32) {
            let Some(proof) = Avx2::detect() else { return Ok(()) };
            let (wide, other) = (eight(proof, a), eight(proof, b));
            let single = |f: fn(f32, f32) -> f32| -> [f32; LANES] {
                core::array::from_fn(|i| f(f32::from_bits(a[i]), f32::from_bits(b[i])))
            };
            let c = f32::from_bits(b[0]);
            let with_one = |f: fn(f32, f32) -> f32| -> [f32; LANES] {
                core::array::from_fn(|i| f(f32::from_bits(a[i]), c))
            };
            let cases = [
                ("+", wide + other, single(|a, b| a + b)),
                ("-", wide - other, single(|a, b| a - b)),
                ("*", wide * other, single(|a, b| a * b)),
                ("/", wide / other, single(|a, b| a / b)),
                ("+ c", wide + c, with_one(|a, b| a + b)),
                ("- c", wide - c, with_one(|a, b| a - b)),
                ("* c", wide * c, with_one(|a, b| a * b)),
                ("/ c", wide / c, with_one(|a, b| a / b)),
                ("-a", -wide, single(|a, _| -a)),
                ("same", wide.same(c), with_one(|_, c| c)),
                ("sqrt", wide.sqrt(), single(|a, _| Real::sqrt(a))),
                ("abs", wide.abs(), single(|a, _| Real::abs(a))),
                ("copysign", wide.copysign(other), single(Real::copysign)),
                ("greater", wide.greater(other), single(Real::greater)),
                ("lesser", wide.lesser(other), single(Real::lesser)),
                ("complement", wide.complement(), single(|a, _| 1.0 - a)),
                ("at_least", wide.at_least(c), with_one(Real::at_least)),
                ("at_most", wide.at_most(c), with_one(Real::at_most)),
                ("select", Eight::select(wide.above(other), wide, other), single(|a, b| Real::select(a > b, a, b))),
                ("not", Eight::select(!wide.above(other) & wide.always(), wide, other), single(|a, b| if a > b { b } else { a })),
                ("of_bits", Eight::of_bits(wide.bits()), single(|a, _| a)),
            ];
            for (name, found, exact) in cases {
                prop_assert_eq!(stored(found).map(bits), exact.map(bits), "{}", name);
            }
            let lanes = |f: fn(f32, f32) -> bool| (0..LANES).fold(0, |lanes, i| {
                lanes | u32::from(f(f32::from_bits(a[i]), f32::from_bits(b[i]))) << i
            });
            prop_assert_eq!(wide.above(other).lanes(), lanes(|a, b| a > b));
            prop_assert_eq!((wide.above(other) | other.above(wide)).lanes(), lanes(|a, b| a > b || b > a));
            let whole = wide.bits();
            let as_bits = |x: Whole| stored(Eight::of_bits(x)).map(f32::to_bits);
            prop_assert_eq!(as_bits(whole ^ other.bits()), core::array::from_fn(|i| a[i] ^ b[i]));
            prop_assert_eq!(as_bits(whole ^ x), a.map(|a| a ^ x));
            prop_assert_eq!(as_bits(whole & x), a.map(|a| a & x));
            prop_assert_eq!(as_bits(whole | x), a.map(|a| a | x));
            prop_assert_eq!(as_bits(whole.same(x)), [x; LANES]);
            prop_assert_eq!(as_bits(whole.sum(other.bits())), core::array::from_fn(|i| a[i].wrapping_add(b[i])));
            prop_assert_eq!(as_bits(whole.product(other.bits())), core::array::from_fn(|i| a[i].wrapping_mul(b[i])));
            prop_assert_eq!(as_bits(proof.read_whole(&a, 0)), a);
            prop_assert_eq!(as_bits(whole << shift), a.map(|a| a << shift));
            prop_assert_eq!(as_bits(whole >> shift), a.map(|a| a >> shift));
            prop_assert_eq!(as_bits(whole.plus(x)), a.map(|a| a.wrapping_add(x)));
            prop_assert_eq!(as_bits(whole.times(x)), a.map(|a| a.wrapping_mul(x)));
            prop_assert_eq!(as_bits(whole.reversed()), a.map(u32::reverse_bits));
            prop_assert_eq!(stored(whole.real()).map(bits), a.map(|a| bits(a as i32 as f32)));
            prop_assert_eq!(as_bits(proof.count_from(x)), core::array::from_fn(|i| x.wrapping_add(i as u32)));
            // Of what is no 32-bit number nobody asks.
            let small = a.map(|a| f32::from_bits(a & 0x807f_ffff | 0x3f80_0000) * 1e5);
            let wide = eight(proof, small.map(f32::to_bits));
            prop_assert_eq!(as_bits(wide.whole()), small.map(|x| x as i32 as u32));
            prop_assert_eq!(as_bits(wide.nearest()), small.map(|x| x.round() as i32 as u32));
        }
    }
}
