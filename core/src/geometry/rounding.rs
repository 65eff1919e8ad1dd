//! What rounding can do to an f32 result, and the few operations that make it certain.

/// The unit roundoff of f32, `u = 2⁻²⁴`: a single operation errs by at most this part of its result.
pub const UNIT_ROUNDOFF: f32 = 1.0 / (1 << 24) as f32;

/// The lesser of two; `b` where they are equal or one is NaN. The rule of x86's `minps`.
#[inline(always)]
#[must_use]
pub fn min(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

/// The greater of two; `b` where they are equal or one is NaN. The rule of x86's `maxps`.
#[inline(always)]
#[must_use]
pub fn max(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn min_and_max_prefer_the_second_like_the_vector_instructions() {
        assert_eq!(min(f32::NAN, 1.0), 1.0);
        assert_eq!(max(f32::NAN, 1.0), 1.0);
        assert!(min(1.0, f32::NAN).is_nan());
        assert!(max(0.0, -0.0).is_sign_negative());
        assert!(min(-0.0, 0.0).is_sign_positive());
        assert_eq!((min(1.0, 2.0), max(1.0, 2.0)), (1.0, 2.0));
    }
}
