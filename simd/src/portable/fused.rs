//! A product and a sum with one rounding.

cfg_select! {
    any(target_feature = "fma", target_arch = "aarch64") => {
        /// Whether the machine that this is compiled for has an instruction for it.
        const IS_INSTRUCTION: bool = true;
        /// What is quickest on such a machine, if it has no lanes of its own.
        pub type Quickest = crate::Portable;
    }
    _ => {
        /// Whether the machine that this is compiled for has an instruction for it.
        const IS_INSTRUCTION: bool = false;
        /// What is quickest on such a machine, if it has no lanes of its own: eight numbers go by twos. It does other work than lanes, for the same hits.
        pub type Quickest = kiloray_core::trace::Scalar;
    }
}

/// `a * b + c`, rounded once.
///
/// Where no instruction does it the library's function takes longer than all else that is done with a box. In f64 the product is exact, and what the sum loses is
/// known (Knuth's sum of two). A sum that is rounded to an odd number in its place may be rounded again: no tie is made, or lost, on the way (Boldo, Melquiond: Emulation of
/// a FMA and Correctly Rounded Sums, 2008).
#[inline(always)]
pub(super) fn fused(a: f32, b: f32, c: f32) -> f32 {
    if IS_INSTRUCTION {
        return a.mul_add(b, c);
    }
    let (product, c) = (f64::from(a) * f64::from(b), f64::from(c));
    let sum = product + c;
    let added = sum - product;
    let lost = (product - (sum - added)) + (c - added);
    let bits = sum.to_bits();
    // Not true of a NaN, which is lost where the sum is infinite.
    let is_inexact = u64::from(lost.abs() > 0.0);
    // Towards zero, and odd.
    let is_less = (bits ^ lost.to_bits()) >> 63;
    f64::from_bits(bits.wrapping_sub(is_inexact & is_less) | is_inexact) as f32
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn check(a: f32, b: f32, c: f32) -> Result<(), TestCaseError> {
        let (found, exact) = (fused(a, b, c), a.mul_add(b, c));
        let same = found.to_bits() == exact.to_bits() || found.is_nan() && exact.is_nan();
        prop_assert!(same, "{a:e} {b:e} {c:e}: {found:e}, not {exact:e}");
        Ok(())
    }

    /// All exponents, infinities and NaN among them, with few bits or many.
    fn number() -> impl Strategy<Value = f32> {
        (any::<u32>(), 0_u32..24).prop_map(|(bits, cut)| f32::from_bits(bits >> cut << cut))
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(100_000))]

        #[test]
        fn it_rounds_once(a in number(), b in number(), c in number()) {
            check(a, b, c)?;
        }

        #[test]
        fn it_rounds_once_where_much_is_lost(a in number(), b in number(), ulp in -3_i32..4, apart in -60_i32..60) {
            // A sum near zero, or near a tie, of a part that is far below the other.
            let c = f32::from_bits((-(a * b)).to_bits().wrapping_add_signed(ulp));
            check(a, b, c)?;
            check(a, b, c * 2f32.powi(apart))?;
            check(1.0 + ulp as f32 / (1 << 23) as f32, f32::from_bits(a.to_bits() | 1), (a * 2f32.powi(apart)) / (1 << 24) as f32)?;
        }
    }

    #[test]
    fn ties_of_less_than_normal_numbers_are_not_made() {
        // The product is a little above or below half of the least number there is: 2⁴⁶ + 1 times 2⁻¹⁹⁶, and less.
        let (a, b) = (8_392_705.0 * 2f32.powi(-98), 8_384_513.0 * 2f32.powi(-98));
        for c in [0.0, 2f32.powi(-130), 2f32.powi(-126), 2f32.powi(-149), -2f32.powi(-149)] {
            for c in [c, -c] {
                check(a, b, c).unwrap();
                check(-a, b, c).unwrap();
            }
        }
    }
}
