use crate::elementary::angle;
use core::f32::consts::PI;
use glam::Vec3;

/// What stands lower above a plane than this part of its distance may be below it by rounding.
const ABOVE_MIN: f32 = 1e-3;
/// Of shorter distances f32 does not hold the fourth power.
const DISTANCE_MIN: f32 = 1e-7;
/// Below this the sum over the edges has lost too many digits: its error is about 2⁻²² over the angle that an edge is seen under.
const PROJECTED_MIN: f32 = 1e-3;

/// The projected solid angle of a polygon, all of it above a surface: the integral of the cosine over the directions under which the
/// origin sees it (Lambert 1760; Arvo 1995, "Applications of irradiance tensors to the simulation of non-Lambertian phenomena", eq. 5).
///
/// `None` if a corner is below the surface or next to its plane, if the origin, at a `height` above the polygon's own plane, is next to that, or if the polygon
/// looks too small for f32. So where there is an answer, the polygon is seen under all directions to its points.
pub(super) fn polygon(corners: &[Vec3], height: f32, normal: Vec3) -> Option<f32> {
    let is_above = |c: &Vec3| {
        let distance = libm::sqrtf(c.dot(*c));
        distance > DISTANCE_MIN && c.dot(normal).min(height) > ABOVE_MIN * distance
    };
    if !corners.iter().all(is_above) {
        return None;
    }
    let mut from = *corners.last()?;
    let mut sum = 0.0;
    for &to in corners {
        let product = from.cross(to);
        let sin = libm::sqrtf(product.dot(product));
        if sin > 0.0 {
            sum += product.dot(normal) / sin * angle(sin, from.dot(to));
        }
        from = to;
    }
    let projected = 0.5 * sum.abs();
    (projected > PROJECTED_MIN && projected <= PI * 1.001).then_some(projected)
}

/// The same of a sphere, whose centre is seen in the unit direction `axis`, by the cosine and the sine of half the angle of its cone.
pub(super) fn sphere(axis: Vec3, cos: f32, sin: f32, normal: Vec3) -> Option<f32> {
    let height = axis.dot(normal);
    // The height of the cone's lowest direction.
    let lowest = height * cos - libm::sqrtf((1.0 - height * height).max(0.0)) * sin;
    (lowest > ABOVE_MIN).then_some(PI * sin * sin * height)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;
    use proptest::prelude::*;

    /// By the midpoints of many small parts, in f64.
    fn by_parts(p: Vec3, u: Vec3, v: Vec3, normal: Vec3) -> f64 {
        const N: u32 = 500;
        let [p, u, v, normal] = [p, u, v, normal].map(|v| v.as_dvec3());
        let plane = u.cross(v);
        let part = |i: u32, j: u32| {
            let at = |i: u32| (f64::from(i) + 0.5) / f64::from(N);
            let to: DVec3 = p + u * at(i) + v * at(j);
            let square = to.length_squared();
            to.dot(normal) * to.dot(plane).abs() / (square * square)
        };
        (0..N * N).map(|k| part(k / N, k % N)).sum::<f64>() / f64::from(N * N)
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(40))]
        #[test]
        fn a_polygon_is_the_sum_of_its_parts(
            p in prop::array::uniform3(-2.0f32..2.0),
            u in prop::array::uniform3(-2.0f32..2.0),
            v in prop::array::uniform3(-2.0f32..2.0),
            scale in -6..9,
        ) {
            let [p, u, v] = [p, u, v].map(Vec3::from);
            let p = p + Vec3::Z * 3.0;
            prop_assume!(p.dot(u.cross(v)).abs() > 0.3);
            let scale = 10.0_f32.powi(scale);
            let [a, b, c, d] = [p, p + u, p + u + v, p + v].map(|c| c * scale);
            let height = a.dot(u.cross(v).normalize()).abs();
            if let Some(found) = polygon(&[a, b, c, d], height, Vec3::Z) {
                let exact = by_parts(p, u, v, Vec3::Z);
                prop_assert!((f64::from(found) - exact).abs() < 3e-4 * exact, "{found} {exact}");
                let halves = [polygon(&[a, b, c], height, Vec3::Z), polygon(&[c, d, a], height, Vec3::Z)];
                if let [Some(one), Some(other)] = halves {
                    prop_assert!((one + other - found).abs() < 2e-5 * found);
                }
            }
        }
    }

    #[test]
    fn a_square_overhead_has_its_form_factor() {
        // The form factor of a parallel square from the point below its corner (Siegel & Howell, configuration 10), times 4.
        let x = 1.0_f64;
        let root = (1.0 + x * x).sqrt();
        let exact = 4.0 * (x / root) * (x / root).atan();
        let square = [(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)];
        let found = polygon(&square.map(|(x, y)| Vec3::new(x, y, 1.0)), 1.0, Vec3::Z).unwrap();
        assert!((f64::from(found) - exact).abs() < 1e-6 * exact, "{found} {exact}");
    }

    #[test]
    fn what_reaches_below_the_horizon_is_left_to_samples() {
        let corners =
            [Vec3::new(1.0, 0.0, 1.0), Vec3::new(0.0, 1.0, 1.0), Vec3::new(1.0, 1.0, -0.01)];
        assert_eq!(polygon(&corners, 0.5, Vec3::Z), None);
        let half = core::f32::consts::FRAC_1_SQRT_2;
        assert_eq!(sphere(Vec3::new(half, 0.0, half), half, half, Vec3::Z), None);
        assert_eq!(sphere(Vec3::Z, half, half, Vec3::Z), Some(PI * half * half));
    }
}
