use super::plane::Plane;
use crate::elementary::angle;
use crate::real::{self, Bits, LANES, Mask, Real, Vector};
use crate::scene::LightKind;
use crate::trace::{Kernel, Lanes, Tracer};
use core::f32::consts::PI;
use glam::Vec3;

/// What stands lower above a plane than this part of its distance may be below it by rounding.
const ABOVE_MIN: f32 = 1e-3;
/// Of shorter distances f32 does not hold the fourth power.
const DISTANCE_MIN: f32 = 1e-7;
/// Below this the sum over the edges has lost too many digits: its error is about 2⁻²² over the angle that an edge is seen under.
const PROJECTED_MIN: f32 = 1e-3;

/// A parallelogram, or the triangle that is half of it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Polygon {
    /// A corner, and the edges from there.
    pub(super) first: Vec3,
    pub(super) u: Vec3,
    pub(super) v: Vec3,
    pub(super) is_triangle: bool,
}

impl Polygon {
    /// `None` if it has no corners.
    #[inline(always)]
    pub(super) fn of(plane: &Plane) -> Option<Self> {
        let &Plane { kind, position: first, u, v, .. } = plane;
        let is_triangle = kind == LightKind::Triangle;
        (kind != LightKind::Disc).then_some(Self { first, u, v, is_triangle })
    }

    /// The projected solid angle, all of it above a surface of this normal, from a point at this height above its plane: the integral of the cosine over
    /// the directions under which the point sees it (Lambert 1760; Arvo 1995, "Applications of irradiance tensors to the simulation of non-Lambertian
    /// phenomena", eq. 5).
    ///
    /// `None` if a corner is below the surface or next to its plane, if the point is next to the polygon's own plane, or if the polygon
    /// looks too small for f32. So where there is an answer, the polygon is seen under all directions to its points.
    pub(super) fn projected<T: Tracer>(
        &self,
        tracer: T,
        from: Vec3,
        normal: Vec3,
        height: f32,
    ) -> Option<f32> {
        let (mut parts, mut low) = ([0.0; LANES], 0);
        let polygon = Self { first: self.first - from, ..*self };
        tracer.compute(Edges { polygon, normal, height, parts: &mut parts, low: &mut low });
        let [a, b, c, d, ..] = parts;
        let projected: f32 = sum([a, b, c, d]);
        (low == 0 && is_sound(projected)).then_some(projected)
    }

    /// The same from several points, and from which there is an answer.
    #[cfg(feature = "bundles")]
    #[inline(always)]
    pub(super) fn projected_from<R: Real>(
        &self,
        from: Vector<R>,
        normal: Vector<R>,
        height: R,
    ) -> (R, R::Mask) {
        let first = Vector::same(height, self.first) - from;
        let c0 = self.corner_from(first, 0);
        let c1 = self.corner_from(first, 1);
        let c2 = self.corner_from(first, 2);
        let c3 = self.corner_from(first, 3);
        let (a, low0) = edge(c3, c0, normal, height);
        let (b, low1) = edge(c0, c1, normal, height);
        let (c, low2) = edge(c1, c2, normal, height);
        let (d, low3) = edge(c2, c3, normal, height);
        let projected = sum([a, b, c, d]);
        (projected, is_sound(projected) & !(low0 | low1 | low2 | low3))
    }

    /// Its corners by number; of a triangle the last two are one. Numbers count on from 4 as from 0.
    #[inline(always)]
    fn corner<R: Real>(&self, number: R::Bits) -> Vector<R> {
        let v = (number >> 1 & 1).real();
        let u = if self.is_triangle {
            (number & 1).real() * v.complement()
        } else {
            (number.plus(1) >> 1 & 1).real()
        };
        Vector::along(self.u, u) + self.first + Vector::along(self.v, v)
    }

    /// The same of one number, seen from several points; `first` is its first.
    #[cfg(feature = "bundles")]
    #[inline(always)]
    fn corner_from<R: Real>(&self, first: Vector<R>, number: u32) -> Vector<R> {
        let v = (number >> 1 & 1) as f32;
        let u = if self.is_triangle {
            (number & 1) as f32 * (1.0 - v)
        } else {
            ((number + 1) >> 1 & 1) as f32
        };
        let like = |v: Vec3| Vector::same(first.x, v);
        like(self.u * u) + first + like(self.v * v)
    }
}

/// What the edge from one corner to another adds to the integral, and whether the other is too low.
#[inline(always)]
fn edge<R: Real>(from: Vector<R>, to: Vector<R>, normal: Vector<R>, height: R) -> (R, R::Mask) {
    let distance = to.length();
    let height = to.dot(normal).lesser(height);
    let is_high = distance.above(distance.same(DISTANCE_MIN)) & height.above(distance * ABOVE_MIN);
    let product = from.cross(to);
    let sin = product.length();
    let part = product.dot(normal) / sin * angle(sin, from.dot(to));
    (R::select(sin.is_positive(), part, sin.same(0.0)), !is_high)
}

#[inline(always)]
fn sum<R: Real>([a, b, c, d]: [R; 4]) -> R {
    (a + b + c + d).abs() * 0.5
}

#[inline(always)]
fn is_sound<R: Real>(projected: R) -> R::Mask {
    projected.above(projected.same(PROJECTED_MIN)) & !projected.above(projected.same(PI * 1.001))
}

/// All edges of a polygon that the origin sees, in lanes.
struct Edges<'a> {
    polygon: Polygon,
    normal: Vec3,
    height: f32,
    parts: &'a mut [f32; LANES],
    /// Not 0 if a corner is too low.
    low: &'a mut u32,
}

impl Kernel for Edges<'_> {
    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) {
        let Self { polygon, normal, height, parts, low } = self;
        for first in (0..4).step_by(L::Real::COUNT) {
            let number = lanes.count_from(first as u32);
            let (from, to): (Vector<L::Real>, _) =
                (polygon.corner(number.plus(3)), polygon.corner(number));
            let normal = Vector::same(to.x, normal);
            let (part, is_low) = edge(from, to, normal, to.x.same(height));
            real::put(parts, first, part);
            *low |= is_low.lanes();
        }
    }
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
    use crate::trace::Scalar;
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
            let height = (p * scale).dot(u.cross(v).normalize()).abs();
            let projected = |p: Vec3, u: Vec3, v: Vec3, is_triangle| {
                let [first, u, v] = [p, u, v].map(|v| v * scale);
                let polygon = Polygon { first, u, v, is_triangle };
                polygon.projected(Scalar, Vec3::ZERO, Vec3::Z, height)
            };
            if let Some(found) = projected(p, u, v, false) {
                let exact = by_parts(p, u, v, Vec3::Z);
                prop_assert!((f64::from(found) - exact).abs() < 3e-4 * exact, "{found} {exact}");
                let halves = [projected(p, u, v, true), projected(p + u + v, -u, -v, true)];
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
        let square = Polygon {
            first: Vec3::ONE,
            u: Vec3::NEG_X * 2.0,
            v: Vec3::NEG_Y * 2.0,
            is_triangle: false,
        };
        let found = square.projected(Scalar, Vec3::ZERO, Vec3::Z, 1.0).unwrap();
        assert!((f64::from(found) - exact).abs() < 1e-6 * exact, "{found} {exact}");
    }

    #[test]
    fn what_reaches_below_the_horizon_is_left_to_samples() {
        let first = Vec3::new(1.0, 0.0, 1.0);
        let (u, v) = (Vec3::new(0.0, 1.0, 0.0), Vec3::new(0.0, 1.0, -1.01));
        for (u, v) in [(u, v), (v, u)] {
            let triangle = Polygon { first, u, v, is_triangle: true };
            assert_eq!(triangle.projected(Scalar, Vec3::ZERO, Vec3::Z, 0.5), None);
        }
        let half = core::f32::consts::FRAC_1_SQRT_2;
        assert_eq!(sphere(Vec3::new(half, 0.0, half), half, half, Vec3::Z), None);
        assert_eq!(sphere(Vec3::Z, half, half, Vec3::Z), Some(PI * half * half));
    }
}
