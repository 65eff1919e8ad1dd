//! Smooth interfaces: what part is reflected.

use crate::elementary::{exp2, log2};
use crate::real::Real;
use core::f32::consts::LOG2_E;
use glam::Vec3;

/// What an interface does with light from one side.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Interface {
    /// Reflected part, unpolarised.
    pub reflected: f32,
    /// Unit direction of the refracted ray; `None` where all is reflected.
    pub refracted: Option<Vec3>,
}

/// Fresnel's equations and Snell's law (Born & Wolf, 1.5.2), for a ray that meets the interface from the side of `normal`.
///
/// `outgoing` is the unit direction back along the ray; `ratio` the index of its own side over that of the far side.
#[must_use]
pub fn interface(outgoing: Vec3, normal: Vec3, ratio: f32) -> Interface {
    let cos_i = outgoing.dot(normal).clamp(0.0, 1.0);
    // The part along the surface itself, rather than 1 - cos², which cancels near the normal.
    let along = outgoing - normal * cos_i;
    let sin2_t = ratio * ratio * along.dot(along);
    if sin2_t >= 1.0 {
        return Interface { reflected: 1.0, refracted: None };
    }
    let cos_t = libm::sqrtf(1.0 - sin2_t);
    let s = quotient(ratio * cos_i - cos_t, ratio * cos_i + cos_t);
    let p = quotient(cos_i - ratio * cos_t, cos_i + ratio * cos_t);
    let direction = -(along * ratio) - normal * cos_t;
    Interface {
        reflected: (0.5 * (s * s + p * p)).min(1.0),
        refracted: Some(direction / libm::sqrtf(direction.dot(direction))),
    }
}

/// Smooth highlights of plastic, metal and trans grow towards the horizon from this reflectance on.
const POLISHED_MIN: f32 = 0.018;

/// The part that a smooth highlight of this reflectance takes from all else, at `cos` from the normal; 0 if it is too weak.
#[inline(always)]
pub(super) fn taken(reflectance: Vec3, cos: impl FnOnce() -> f32) -> f32 {
    if reflectance.max_element() >= POLISHED_MIN { polish(cos().clamp(0.0, 1.0)) } else { 0.0 }
}

/// The same of a highlight that is strong enough: Radiance's estimate (`FRESNE` of normal.c, 2.83).
#[inline(always)]
pub(super) fn polish<R: Real>(cos: R) -> R {
    exp2(cos * (-5.85 * LOG2_E)) - 0.002_029_430_6
}

/// A thin pane of glass, seen at `cos` from its normal: the reflected and the transmitted part per channel, with all
/// internal reflections, as Radiance defines its `glass` ("the materials", Radiance reference manual; the sums of the
/// geometric series for each polarisation).
///
/// `transmissivity` is the part that one pass at normal incidence leaves, without the losses at the faces.
#[must_use]
pub fn pane(cos: f32, index: f32, transmissivity: Vec3) -> (Vec3, Vec3) {
    let cos = cos.clamp(0.0, 1.0);
    let cos_t = libm::sqrtf((1.0 - (1.0 - cos * cos) / (index * index)).max(0.0));
    let s = quotient(cos - index * cos_t, cos + index * cos_t);
    let p = quotient(cos_t - index * cos, cos_t + index * cos);
    let (s, p) = (s * s, p * p);
    let channel = |clear: f32| {
        // The path inside is longer at a slant; a clear pane needs no power, an opaque one stays opaque.
        let pass = if clear >= 1.0 {
            1.0
        } else if clear <= 0.0 || cos_t <= 0.0 {
            0.0
        } else {
            exp2(log2(clear) / cos_t)
        };
        let (reflected_s, transmitted_s) = series(s, pass);
        let (reflected_p, transmitted_p) = series(p, pass);
        (0.5 * (reflected_s + reflected_p), 0.5 * (transmitted_s + transmitted_p))
    };
    let [(r0, t0), (r1, t1), (r2, t2)] = transmissivity.to_array().map(channel);
    (Vec3::new(r0, r1, r2), Vec3::new(t0, t1, t2))
}

/// Reflected and transmitted part of a pane with reflectance `r` at each face and `a` left by each pass:
/// `r + (1 - r)² r a² / (1 - r² a²)` and `(1 - r)² a / (1 - r² a²)`.
fn series(r: f32, a: f32) -> (f32, f32) {
    let rest = 1.0 - r * r * a * a;
    if rest <= 0.0 {
        // Grazing and clear: all is reflected.
        return (1.0, 0.0);
    }
    let through = (1.0 - r) * (1.0 - r) * a / rest;
    (r + through * r * a, through)
}

/// A quotient whose divisor is zero only where both vanish, at grazing incidence: there all is reflected.
fn quotient(a: f32, b: f32) -> f32 {
    if b == 0.0 { 1.0 } else { a / b }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Fresnel's equations by angles (sine and tangent form), in f64.
    fn by_angles(theta: f64, ratio: f64) -> f64 {
        let sin_t = ratio * theta.sin();
        if sin_t >= 1.0 {
            return 1.0;
        }
        let t = sin_t.asin();
        if theta < 1e-9 {
            return ((ratio - 1.0) / (ratio + 1.0)).powi(2);
        }
        let s = (theta - t).sin() / (theta + t).sin();
        let p = (theta - t).tan() / (theta + t).tan();
        0.5 * (s * s + p * p)
    }

    proptest! {
        #[test]
        fn fresnel_agrees_with_its_other_form(theta in 0.0f64..1.55, index in 1.05f64..3.0, inside: bool) {
            let ratio = if inside { index } else { 1.0 / index };
            // Next to the angle of total reflection the slope is infinite.
            prop_assume!((ratio * theta.sin() - 1.0).abs() > 1e-3);
            let outgoing = Vec3::new(theta.sin() as f32, 0.0, theta.cos() as f32);
            let found = interface(outgoing, Vec3::Z, ratio as f32);
            prop_assert!((f64::from(found.reflected) - by_angles(theta, ratio)).abs() < 1e-5);
            prop_assert_eq!(found.refracted.is_none(), ratio * theta.sin() > 1.0);
            if let Some(d) = found.refracted {
                prop_assert!((d.length() - 1.0).abs() < 1e-6);
                prop_assert!(d.z < 0.0);
                prop_assert!((f64::from(d.x) + ratio * theta.sin()).abs() < 1e-5);
            }
        }

        #[test]
        fn a_pane_neither_makes_nor_loses_light(cos in 0.0f32..=1.0, index in 1.0f32..3.0, clear in 0.0f32..=1.0) {
            let (r, t) = pane(cos, index, Vec3::new(clear, 1.0, 0.0));
            prop_assert!(r.x >= 0.0 && t.x >= 0.0 && r.x + t.x <= 1.0 + 1e-6);
            prop_assert!((r.y + t.y - 1.0).abs() < 1e-5);
            prop_assert_eq!(t.z, 0.0);
        }

        /// Radiance's source code computes these terms in another arrangement.
        #[test]
        fn a_pane_is_radiances_glass(cos in 0.01f64..=1.0, clear in 0.01f64..1.0) {
            let n = 1.52_f64;
            let cos2 = ((1.0 - 1.0 / (n * n)) + (cos / n).powi(2)).sqrt();
            let d = clear.powf(1.0 / cos2);
            let r1e = ((cos - n * cos2) / (cos + n * cos2)).powi(2);
            let r1m = ((1.0 / cos - n / cos2) / (1.0 / cos + n / cos2)).powi(2);
            let transmitted = 0.5 * (1.0 - r1e).powi(2) * d / (1.0 - (r1e * d).powi(2))
                + 0.5 * (1.0 - r1m).powi(2) * d / (1.0 - (r1m * d).powi(2));
            let d2 = d * d;
            let reflected = 0.5 * r1e * (1.0 + (1.0 - 2.0 * r1e) * d2) / (1.0 - r1e * r1e * d2)
                + 0.5 * r1m * (1.0 + (1.0 - 2.0 * r1m) * d2) / (1.0 - r1m * r1m * d2);
            let (r, t) = pane(cos as f32, n as f32, Vec3::splat(clear as f32));
            prop_assert!((f64::from(t.x) - transmitted).abs() < 1e-5);
            prop_assert!((f64::from(r.x) - reflected).abs() < 1e-5);
        }
    }

    #[test]
    fn clear_glass_transmits_what_its_manual_says() {
        // The Radiance reference manual: transmissivity .96 for a transmittance of .88 at normal incidence.
        let (_, t) = pane(1.0, 1.52, Vec3::splat(0.96));
        assert!((t.x - 0.88).abs() < 0.003, "{t}");
    }
}
