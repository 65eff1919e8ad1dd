//! The oracle itself: it accepts what is right, and finds what is wrong.

use glam::Vec3;
use kiloray_core::geometry::{Hit, PreparedRay, Primitive, Ray};
use kiloray_tests::oracle::{Scene, Verdict, Wrong};
use proptest::prelude::*;

use crate::cases::{direction, point, runner, unit};

fn scene() -> impl Strategy<Value = Scene> {
    let triangle = (point(), point(), point(), unit()).prop_map(|(a, b, c, s)| {
        Primitive::Triangle { vertices: [a, a + b * s, a + c * s], normals: None }
    });
    let sphere = (point(), 0.01_f32..0.5).prop_map(|(center, radius)| Primitive::Sphere {
        center,
        radius,
        inward: false,
    });
    let primitive = (prop_oneof![3 => triangle, 1 => sphere], 0..3_u16);
    prop::collection::vec(primitive, 1..30).prop_map(|primitives| Scene { primitives })
}

fn closest(scene: &Scene, ray: &Ray) -> Option<Hit> {
    let prepared = PreparedRay::new(ray);
    let mut best: Option<Hit> = None;
    for &(primitive, material) in &scene.primitives {
        let found = match primitive {
            Primitive::Triangle { vertices, .. } => {
                prepared.triangle(vertices).map(|h| (h.t, h.b1, h.b2))
            }
            Primitive::Sphere { center, radius, .. } => {
                prepared.sphere(center, radius).map(|t| (t, 0.0, 0.0))
            }
        };
        let Some((t, b1, b2)) = found else { continue };
        let hit = Hit { t, b1, b2, material, primitive, block: 0 };
        if best.is_none_or(|best| hit.is_closer_than(&best)) {
            best = Some(hit);
        }
    }
    best
}

fn ray() -> impl Strategy<Value = Ray> {
    (point(), prop_oneof![direction().prop_map(Err), point().prop_map(Ok)]).prop_map(|(p, aim)| {
        Ray {
            origin: p * 2.0,
            direction: match aim {
                Ok(target) if target != p * 2.0 => target - p * 2.0,
                Ok(_) => Vec3::X,
                Err(direction) => direction,
            },
            t_min: 0.0,
            t_max: f32::INFINITY,
        }
    })
}

#[test]
fn the_closest_of_the_reference_is_never_wrong_and_seldom_near_a_bound() {
    let right = std::cell::Cell::new(0);
    let hits = std::cell::Cell::new(0);
    let test = |(scene, ray): (Scene, Ray)| {
        let hit = closest(&scene, &ray);
        let verdict = scene.judge(&ray, hit.as_ref());
        prop_assert!(!matches!(verdict, Verdict::Wrong(_)), "{verdict:?} {hit:?}");
        right.set(right.get() + u32::from(verdict == Verdict::Right));
        hits.set(hits.get() + u32::from(hit.is_some()));
        Ok(())
    };
    runner(4_000).run(&(scene(), ray()), test).unwrap();
    assert!(right.get() > 3_000 && hits.get() > 500, "{} {}", right.get(), hits.get());
}

#[test]
fn a_wrong_hit_is_found() {
    let front = Primitive::Triangle { vertices: [Vec3::ZERO, Vec3::X, Vec3::Y], normals: None };
    let ball =
        Primitive::Sphere { center: Vec3::new(0.25, 0.25, -1.0), radius: 0.25, inward: false };
    let scene = Scene { primitives: vec![(front, 1), (ball, 2)] };
    let ray = Ray {
        origin: Vec3::new(0.25, 0.25, 1.0),
        direction: -Vec3::Z,
        t_min: 0.0,
        t_max: f32::INFINITY,
    };
    let hit = closest(&scene, &ray).unwrap();
    assert_eq!(hit.t, 1.0);
    assert_eq!(scene.judge(&ray, Some(&hit)), Verdict::Right);
    assert_eq!(scene.judge(&ray, None), Verdict::Wrong(Wrong::Behind { primitive: 0 }));
    let behind = Hit { t: 1.75, material: 2, primitive: ball, ..hit };
    assert_eq!(scene.judge(&ray, Some(&behind)), Verdict::Wrong(Wrong::Behind { primitive: 0 }));
    let off = Hit { t: 1.00001, ..hit };
    assert!(matches!(scene.judge(&ray, Some(&off)), Verdict::Wrong(Wrong::Off { .. })));
    let other = Hit { material: 2, ..hit };
    assert_eq!(scene.judge(&ray, Some(&other)), Verdict::Wrong(Wrong::NotThere));
    let short = Ray { t_max: 0.5, ..ray };
    assert_eq!(scene.judge(&short, Some(&hit)), Verdict::Wrong(Wrong::OutOfRange));
    assert_eq!(scene.judge(&short, None), Verdict::Right);
    let beside = Ray { origin: Vec3::new(2.0, 0.25, 1.0), ..ray };
    assert!(matches!(scene.judge(&beside, Some(&hit)), Verdict::Wrong(Wrong::Missed { .. })));
    let edge = Ray { origin: Vec3::new(0.25, 0.0, 1.0), ..ray };
    assert_eq!(scene.judge(&edge, None), Verdict::WithinBounds);
}
