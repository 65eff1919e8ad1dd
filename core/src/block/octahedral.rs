//! Unit vectors in 32 bits.
//!
//! The octahedral map of Meyer et al. 2010, as surveyed by Cigolle et al. 2014, "A survey of
//! efficient representations for independent unit vectors", two signed 16-bit coordinates: the
//! greatest error is below 7e-5 rad. The decoder uses `+ - * /` and `sqrt` only, so that every
//! machine gets the same bits.

use glam::Vec3;

/// The code that no unit vector has: "no normal here, use the plane of the triangle".
pub const NONE: u32 = 0x8000_8000;

/// Encodes a unit vector. NaN gives [`NONE`].
#[must_use]
pub fn encode(n: Vec3) -> u32 {
    let sum = n.x.abs() + n.y.abs() + n.z.abs();
    if sum.is_nan() || sum <= 0.0 || sum.is_infinite() {
        return NONE;
    }
    let (x, y) = (n.x / sum, n.y / sum);
    let (x, y) =
        if n.z < 0.0 { ((1.0 - y.abs()).copysign(x), (1.0 - x.abs()).copysign(y)) } else { (x, y) };
    let snorm = |v: f32| libm::roundf(v.clamp(-1.0, 1.0) * 32767.0) as i16 as u16;
    u32::from(snorm(x)) | u32::from(snorm(y)) << 16
}

/// Decodes to a unit vector; [`NONE`] gives `None`.
#[must_use]
pub fn decode(code: u32) -> Option<Vec3> {
    if code == NONE {
        return None;
    }
    let unit = |v: u16| f32::from((v as i16).max(-32767)) / 32767.0;
    let (x, y) = (unit(code as u16), unit((code >> 16) as u16));
    let z = 1.0 - x.abs() - y.abs();
    let (x, y) =
        if z < 0.0 { ((1.0 - y.abs()).copysign(x), (1.0 - x.abs()).copysign(y)) } else { (x, y) };
    let v = Vec3::new(x, y, z);
    Some(v / libm::sqrtf(v.dot(v)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn decodes_what_was_encoded(x in -1.0f32..1.0, y in -1.0f32..1.0, z in -1.0f32..1.0) {
            let v = Vec3::new(x, y, z);
            prop_assume!(v.length() > 1e-3);
            let n = v.normalize();
            let back = decode(encode(n)).unwrap();
            prop_assert!((back - n).length() < 7e-5, "{n} {back}");
        }
    }

    #[test]
    fn no_direction_has_the_code_of_none() {
        assert_eq!(encode(Vec3::ZERO), NONE);
        assert_eq!(encode(Vec3::splat(f32::NAN)), NONE);
        assert_eq!(decode(NONE), None);
        for axis in [Vec3::X, Vec3::Y, Vec3::Z, Vec3::NEG_X, Vec3::NEG_Y, Vec3::NEG_Z] {
            assert_eq!(decode(encode(axis)), Some(axis));
        }
    }
}
