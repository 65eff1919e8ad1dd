use super::*;
use glam::Vec3;
use std::vec::Vec;

fn ray(origin: [f32; 3], direction: [f32; 3]) -> PreparedRay {
    PreparedRay::new(&Ray {
        origin: origin.into(),
        direction: direction.into(),
        t_min: 0.0,
        t_max: f32::INFINITY,
    })
}

const RIGHT: [Vec3; 3] = [Vec3::ZERO, Vec3::X, Vec3::Y];

#[test]
fn a_plain_hit_has_the_expected_numbers_on_both_sides() {
    for (z, dz) in [(2.0, -4.0), (-2.0, 4.0)] {
        let hit = ray([0.25, 0.5, z], [0.0, 0.0, dz]).triangle(RIGHT).unwrap();
        assert_eq!((hit.t, hit.b1, hit.b2), (0.5, 0.25, 0.5));
    }
    assert_eq!(ray([0.75, 0.5, 1.0], [0.0, 0.0, -1.0]).triangle(RIGHT), None);
    assert_eq!(ray([0.25, 0.5, 1.0], [0.0, 0.0, 1.0]).triangle(RIGHT), None);
}

#[test]
fn bounds_are_inclusive_and_t_is_never_negative_zero() {
    let mut r = ray([0.25, 0.25, 1.0], [0.0, 0.0, -1.0]);
    r.t_max = 1.0;
    assert_eq!(r.triangle(RIGHT).unwrap().t, 1.0);
    r.t_max = 1.0_f32.next_down();
    assert_eq!(r.triangle(RIGHT), None);
    for direction in [[0.0, 0.0, -1.0], [0.0, 0.0, 1.0], [-0.0, -0.0, -1.0], [0.1, -0.3, 1.0]] {
        let hit = ray([0.25, 0.25, 0.0], direction).triangle(RIGHT).unwrap();
        assert_eq!(hit.t.to_bits(), 0);
    }
}

#[test]
fn what_is_no_ray_hits_nothing() {
    let strange = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY];
    let sphere = (Vec3::ZERO, 10.0);
    for s in strange {
        for axis in 0..3 {
            let (mut origin, mut direction) = ([0.25, 0.25, 1.0], [0.0, 0.0, -1.0]);
            origin[axis] = s;
            let r = ray(origin, [0.0, 0.0, -1.0]);
            assert_eq!((r.triangle(RIGHT), r.sphere(sphere.0, sphere.1)), (None, None));
            direction[axis] = s;
            let r = ray([0.25, 0.25, 1.0], direction);
            assert!(r.is_none());
            assert_eq!((r.triangle(RIGHT), r.sphere(sphere.0, sphere.1)), (None, None));
        }
    }
    for d in [0.0, -0.0, 1e-30, f32::MIN_POSITIVE, 1e30] {
        assert!(ray([0.25, 0.25, 1.0], [0.0, 0.0, d]).is_none());
    }
    let mut whole = Ray { origin: Vec3::Z, direction: -Vec3::Z, t_min: f32::NAN, t_max: 1.0 };
    assert!(PreparedRay::new(&whole).is_none());
    (whole.t_min, whole.t_max) = (0.0, f32::NAN);
    assert!(PreparedRay::new(&whole).is_none());
}

#[test]
fn what_is_no_triangle_is_never_hit() {
    let r = ray([0.25, 0.25, 1.0], [0.01, 0.02, -1.0]);
    for s in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        for vertex in 0..3 {
            for axis in 0..3 {
                let mut vertices = RIGHT;
                vertices[vertex][axis] = s;
                assert_eq!(r.triangle(vertices), None, "{vertices:?}");
            }
        }
    }
    // A point, and lines that the ray crosses: degenerate triangles are not there.
    let p = Vec3::new(0.25, 0.25, 0.0);
    let r = ray([0.25, 0.25, 1.0], [0.0, 0.0, -1.0]);
    assert_eq!(r.triangle([p, p, p]), None);
    assert_eq!(r.triangle([p - Vec3::X, p + Vec3::X, p]), None);
    assert_eq!(r.triangle([p - Vec3::X, p + Vec3::X, p + Vec3::X]), None);
    assert_eq!(r.sphere(p, 0.0), None);
    assert_eq!(r.sphere(p, -1.0), None);
    assert_eq!(r.sphere(p, f32::NAN), None);
}

#[test]
fn a_sphere_is_hit_from_outside_and_from_inside() {
    let r = ray([0.0, 0.0, 3.0], [0.0, 0.0, -2.0]);
    assert_eq!(r.sphere(Vec3::ZERO, 1.0), Some(1.0));
    assert_eq!(ray([0.0, 0.0, 0.5], [0.0, 0.0, -2.0]).sphere(Vec3::ZERO, 1.0), Some(0.75));
    let beyond = PreparedRay { t_min: 1.5, ..r };
    assert_eq!(beyond.sphere(Vec3::ZERO, 1.0), Some(2.0));
    assert_eq!(PreparedRay { t_max: 0.5, ..r }.sphere(Vec3::ZERO, 1.0), None);
    assert_eq!(ray([0.0, 0.0, 3.0], [0.0, 0.0, 2.0]).sphere(Vec3::ZERO, 1.0), None);
    assert_eq!(ray([2.0, 0.0, 3.0], [0.0, 0.0, -2.0]).sphere(Vec3::ZERO, 1.0), None);
    // A small sphere far away, where the textbook quadratic in f32 has no digit left.
    let far = ray([0.0, 0.0, 1e4], [0.0, 0.0, -1.0]).sphere(Vec3::ZERO, 1e-3).unwrap();
    assert_eq!(far, (1e4_f64 - f64::from(1e-3_f32)) as f32);
}

#[test]
fn a_fan_round_a_vertex_has_no_hole_in_any_direction() {
    // Rays straight through the shared vertex and through points of the shared edges.
    let center = Vec3::new(0.1, 0.2, 0.3);
    let rim: Vec<Vec3> = (0..7)
        .map(|i| {
            let (s, c) = (i as f32 * 0.897).sin_cos();
            center + Vec3::new(c, s, 0.3 * s * c)
        })
        .collect();
    let fan: Vec<[Vec3; 3]> = (0..7).map(|i| [center, rim[i], rim[(i + 1) % 7]]).collect();
    for i in 0..10_000_u32 {
        let at = |k: u32| (path_bits(i, k) as f32) / 4_294_967_296.0 - 0.5;
        let origin = Vec3::new(at(0), at(1), 2.0 + at(2));
        let edge = rim[(i % 7) as usize];
        let target = if i % 2 == 0 { center } else { center + (edge - center) * (at(3) + 0.5) };
        let r = ray(origin.into(), (target - origin).into());
        assert!(fan.iter().any(|t| r.triangle(*t).is_some()), "ray {i} leaks");
    }
}

fn path_bits(i: u32, k: u32) -> u32 {
    crate::path::PathKey::camera(1, i, 0).scramble(k)
}
