//! What is generated: primitives and rays of all sizes and shapes.

use glam::Vec3;
use kiloray_core::geometry::Ray;
use proptest::prelude::*;
use proptest::test_runner::{Config, RngAlgorithm, TestRng, TestRunner};

/// A runner with a fixed seed: a failure is the same again, and is shrunk.
pub(crate) fn runner(cases: u32) -> TestRunner {
    let config = Config { cases, failure_persistence: None, ..Config::default() };
    TestRunner::new_with_rng(config, TestRng::deterministic_rng(RngAlgorithm::ChaCha))
}

pub(crate) fn signed() -> impl Strategy<Value = f32> {
    prop_oneof![8 => -1.0_f32..1.0, 1 => Just(0.0), 1 => Just(-0.0), 1 => Just(1.0), 1 => Just(-1.0)]
}

pub(crate) fn unit() -> impl Strategy<Value = f32> {
    prop_oneof![6 => 0.0_f32..1.0, 1 => Just(0.0), 1 => Just(1.0), 1 => Just(0.5)]
}

pub(crate) fn point() -> impl Strategy<Value = Vec3> {
    (signed(), signed(), signed()).prop_map(|(x, y, z)| Vec3::new(x, y, z))
}

/// A power of ten.
pub(crate) fn decade(lo: i32, hi: i32) -> impl Strategy<Value = f32> {
    (f64::from(lo)..=f64::from(hi)).prop_map(|e| 10_f64.powf(e) as f32)
}

/// Directions: any, along an axis, in a plane of two axes, with components that differ wildly.
pub(crate) fn direction() -> impl Strategy<Value = Vec3> {
    let zero = prop_oneof![Just(0.0_f32), Just(-0.0)];
    let axis = (0..3_usize, prop_oneof![Just(1.0_f32), Just(-1.0)], zero.clone(), zero.clone());
    prop_oneof![
        4 => point(),
        1 => axis.prop_map(|(k, s, a, b)| {
            let mut d = Vec3::new(a, b, a);
            d[k] = s;
            d
        }),
        1 => (point(), 0..3_usize, zero).prop_map(|(mut d, k, z)| {
            d[k] = z;
            d
        }),
        1 => (point(), 0..3_usize, decade(-30, 0)).prop_map(|(mut d, k, s)| {
            d[k] *= s;
            d
        }),
    ]
    .prop_map(|d| if d.abs().max_element() > 0.0 { d } else { Vec3::X })
}

/// Triangles from 1e-20 to 1e20, round ones and slivers, at the origin and far from it for their size.
pub(crate) fn triangle() -> impl Strategy<Value = [Vec3; 3]> {
    let width = prop_oneof![3 => Just(1.0_f32), 1 => Just(1e-6), 1 => decade(-9, 0)];
    let offset =
        prop_oneof![2 => Just(0.0_f32), 2 => decade(-1, 2), 1 => Just(1e4), 1 => decade(0, 6)];
    let shape = (point(), point(), signed(), width, 0..3_usize, 0..8_usize);
    (decade(-20, 20), offset, point(), shape).prop_map(
        |(size, offset, at, (a, b, s, width, turn, flat))| {
            let offset = at * offset * size.min(1e14);
            let mut v = [offset, offset + a * size, offset + (a * s + b * width) * size];
            if flat < 3 {
                // In a plane of two axes: its box is flat.
                let at = v[0][flat];
                v.iter_mut().for_each(|v| v[flat] = at);
            }
            v.rotate_left(turn);
            v
        },
    )
}

/// A ray at a place near the triangle: inside, on an edge, at a vertex, or a few last places from there.
pub(crate) fn ray_at(vertices: [Vec3; 3]) -> impl Strategy<Value = Ray> {
    let weights =
        (unit(), unit(), prop_oneof![3 => Just(0.0_f32), 2 => -1.0_f32..1.0, 1 => -1e-6_f32..1e-6]);
    let size = vertices.iter().map(|v| (*v - vertices[0]).abs().max_element()).fold(0.0, f32::max);
    let range = prop_oneof![
        6 => Just((0.0, f32::INFINITY)),
        1 => Just((0.5, 2.0)),
        1 => Just((1.0, 1.0)),
        1 => Just((0.0, 0.9)),
    ];
    (weights, direction(), decade(-3, 4), decade(-19, 19), range).prop_map(
        move |((s, t, out), direction, distance, length, (t_min, t_max))| {
            let (s, t) = if s + t > 1.0 { (1.0 - s, 1.0 - t) } else { (s, t) };
            let [v0, v1, v2] = vertices;
            let target = v0 + (v1 - v0) * s + (v2 - v0) * t + (v1 - v2) * out;
            let distance = (size * distance).min(1e20);
            // `t` of the target has to be an f32 number.
            let length = length.clamp(distance * 1e-37, distance.max(1e-20) * 1e37);
            let at = distance / length;
            Ray {
                origin: target - direction * distance,
                direction: direction * length.clamp(1e-19, 1e19),
                t_min: t_min * at,
                t_max: t_max * at,
            }
        },
    )
}

/// The range that the tests promise: finite, and `t` an f32 number.
pub(crate) fn is_in_range(ray: &Ray, reach: f64) -> bool {
    let d = f64::from(ray.direction.abs().max_element());
    ray.origin.is_finite()
        && (1e-20..1e20).contains(&d)
        && reach < 1e37
        && reach / d < 1e37
        && ray.t_min.is_finite()
        && !ray.t_max.is_nan()
}
