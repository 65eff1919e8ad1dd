//! Failures of other ray tracers, from their public issues. One test each.

use glam::Vec3;
use kiloray_core::geometry::{Aabb, PreparedRay, Ray};
use kiloray_tests::oracle::TriangleTruth;

fn prepared(origin: [f32; 3], direction: [f32; 3]) -> PreparedRay {
    PreparedRay::new(&ray(origin, direction))
}

fn ray(origin: [f32; 3], direction: [f32; 3]) -> Ray {
    Ray { origin: origin.into(), direction: direction.into(), t_min: 0.0, t_max: f32::INFINITY }
}

/// A zero component of the direction, and the origin on a plane of the box: 0 * inf is NaN.
#[test]
fn zero_component_with_the_origin_on_the_slab() {
    let cube = Aabb { min: Vec3::splat(-1.0), max: Vec3::splat(1.0) };
    for zero in [0.0, -0.0] {
        for at in [-1.0, 1.0] {
            for axis in 0..3 {
                let (mut origin, mut direction) = ([0.5; 3], [zero; 3]);
                origin[axis] = at;
                origin[(axis + 1) % 3] = -3.0;
                direction[(axis + 1) % 3] = 1.0;
                let inside = prepared(origin, direction).own_box(&cube).unwrap();
                assert!((inside.enter - 2.0).abs() < 1e-5 && (inside.leave - 4.0).abs() < 1e-5);
                // And well beside the slab there is no hit.
                origin[axis] = at * 1.001;
                assert_eq!(prepared(origin, direction).own_box(&cube), None);
            }
        }
    }
    // A triangle in the plane x = 1, its edge met by a ray in that plane's neighbour.
    let wall = [Vec3::new(1.0, 0.0, 0.0), Vec3::new(1.0, 1.0, 0.0), Vec3::new(0.0, 0.0, 1.0)];
    assert!(prepared([1.0, 0.25, -3.0], [0.0, 0.0, 1.0]).triangle(wall).is_some());
}

/// A box without thickness is a box: `t0 < t1` would lose it.
#[test]
fn flat_box_is_entered() {
    for axis in 0..3 {
        let (mut v, mut origin, mut direction) = (
            [Vec3::ZERO, Vec3::new(1.0, 1.0, 0.0), Vec3::new(0.0, 1.0, 1.0)],
            Vec3::new(0.3, 0.4, 0.3),
            Vec3::ZERO,
        );
        v[2][(axis + 1) % 3] = 2.0;
        for v in &mut v {
            v[axis] = 0.5;
        }
        origin[axis] = 3.0;
        direction[axis] = -1.0;
        let middle = (v[0] + v[1] + v[2]) / 3.0;
        origin[(axis + 1) % 3] = middle[(axis + 1) % 3];
        origin[(axis + 2) % 3] = middle[(axis + 2) % 3];
        let hit = prepared(origin.into(), direction.into()).triangle(v);
        assert_eq!(hit.map(|h| h.t), Some(2.5));
    }
}

/// Points and lines as triangles: no panic, no hit.
#[test]
fn point_and_line_triangles() {
    let (p, q) = (Vec3::new(0.25, 0.25, 0.0), Vec3::new(0.5, 0.25, 0.0));
    for direction in [[0.0, 0.0, -1.0], [0.1, 0.0, -1.0], [0.0, 0.3, -1.0]] {
        let ray = prepared([0.25, 0.25, 1.0], direction);
        for vertices in [[p, p, p], [p, q, p], [p, q, p + (q - p) * 0.5]] {
            assert_eq!(ray.triangle(vertices), None);
        }
    }
}

/// A zero that is negative is a zero.
#[test]
fn negative_zero_is_zero() {
    let v = [Vec3::ZERO, Vec3::new(1.0, 0.0, -0.0), Vec3::new(-0.0, 1.0, 0.5)];
    let expected = prepared([0.2, 0.2, 1.0], [0.0, 0.0, -1.0]).triangle(v).unwrap();
    for zeros in [[-0.0, -0.0], [0.0, -0.0], [-0.0, 0.0]] {
        let [x, y] = zeros;
        assert_eq!(prepared([0.2, 0.2, 1.0], [x, y, -1.0]).triangle(v), Some(expected));
    }
    let sphere = |x| prepared([x, 0.0, 2.0], [x, x, -1.0]).sphere(Vec3::splat(x), 1.0);
    assert_eq!(sphere(0.0), Some(1.0));
    assert_eq!(sphere(-0.0), Some(1.0));
}

/// An absolute threshold on the determinant loses triangles with edges of 2e-4, and smaller ones.
#[test]
fn small_triangles_are_there() {
    for e in 0..18 {
        let size = 2.0 * 10_f32.powi(-4 - e);
        let v = [Vec3::ZERO, Vec3::X * size, Vec3::Y * size].map(|v| v + Vec3::Z * size);
        let hit = prepared([size * 0.25, size * 0.25, 0.0], [0.0, 0.0, 1.0]).triangle(v);
        assert!(hit.is_some_and(|h| (h.t / size - 1.0).abs() < 1e-6), "{size} {hit:?}");
    }
}

/// A triangle that is nearly a line is not hit far from itself.
#[test]
fn near_collinear_triangle_is_not_hit_far_away() {
    let along = Vec3::new(0.3, 0.7, -0.2);
    let mut hits = 0;
    for i in 0..20_000_u32 {
        let part = |k: u32| (i.wrapping_mul(k).rotate_left(11) % 10_007) as f32 / 10_007.0 - 0.5;
        let off = Vec3::new(part(7), part(11), part(13)) * 1e-7;
        let v = [Vec3::ONE, Vec3::ONE + along, Vec3::ONE + along * 0.4 + off];
        // Rays in the plane of the line, and at points beyond its ends.
        let target = Vec3::ONE + along * (part(17) * 6.0) + off * part(19) * 3.0;
        let origin = target + Vec3::new(part(23), part(29), part(31)) * 8.0;
        let ray = ray(origin.into(), (target - origin).into());
        if let Some(hit) = PreparedRay::new(&ray).triangle(v) {
            hits += 1;
            let truth = TriangleTruth::new(&ray, v);
            assert!(!truth.surely_missed());
            let p = ray.origin.as_dvec3() + ray.direction.as_dvec3() * f64::from(hit.t);
            let off = kiloray_tests::oracle::distance_to_triangle(p, v);
            assert!(off < 64.0 * kiloray_tests::oracle::U * truth.reach, "{off}");
        }
    }
    assert!(hits > 20, "{hits}");
}

/// A ray through a shared vertex or edge: it does not leak, and of the hits that tie one is chosen, whatever the order.
#[test]
fn shared_edge_is_hit_and_the_tie_has_a_winner() {
    use kiloray_core::geometry::{Hit, Primitive};
    let [a, b, c, d] =
        [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]].map(Vec3::from);
    let square = [[a, b, c], [a, c, d]];
    for i in 0..=64 {
        let s = i as f32 / 64.0;
        let ray = prepared([s, s, 1.0], [0.0, 0.0, -1.0]);
        let hits: Vec<Hit> = square
            .iter()
            .filter_map(|&vertices| {
                let hit = ray.triangle(vertices)?;
                let primitive = Primitive::Triangle { vertices, normals: None };
                Some(Hit { t: hit.t, b1: hit.b1, b2: hit.b2, material: 0, primitive, block: 0 })
            })
            .collect();
        assert_eq!(hits.len(), 2);
        assert_ne!(hits[0].is_closer_than(&hits[1]), hits[1].is_closer_than(&hits[0]));
    }
}

/// NaN and infinity anywhere: no hit, no panic.
#[test]
fn nan_and_infinity_hit_nothing() {
    let v = [Vec3::new(-1.0, -1.0, 0.0), Vec3::X, Vec3::Y];
    for strange in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        for axis in 0..3 {
            let mut origin = [0.0, 0.0, 1.0];
            let mut direction = [0.0, 0.0, -1.0];
            origin[axis] = strange;
            assert_eq!(prepared(origin, direction).triangle(v), None);
            direction[axis] = strange;
            assert_eq!(prepared([0.0, 0.0, 1.0], direction).triangle(v), None);
            assert_eq!(prepared([0.0, 0.0, 1.0], direction).sphere(Vec3::ZERO, 0.5), None);
        }
        assert_eq!(prepared([0.0, 0.0, 1.0], [0.0, 0.0, -1.0]).sphere(Vec3::ZERO, strange), None);
        assert_eq!(
            prepared([0.0, 0.0, 1.0], [0.0, 0.0, -1.0]).sphere(Vec3::splat(strange), 1.0),
            None
        );
    }
}
