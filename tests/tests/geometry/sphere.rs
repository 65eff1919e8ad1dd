use std::cell::Cell;

use glam::Vec3;
use kiloray_core::geometry::{PreparedRay, Ray};
use kiloray_tests::oracle::{SHELL_BOUND, SphereTruth};
use proptest::prelude::*;

use crate::cases::{decade, direction, is_in_range, point, runner, unit};

/// A sphere and a ray that begins outside, on it or inside, and passes through it, by its rim, or beside it.
fn case() -> impl Strategy<Value = (Vec3, f32, Ray)> {
    let sphere = (decade(-18, 18), point(), prop_oneof![Just(0.0_f32), Just(1.0), Just(1e4)]);
    let beside = prop_oneof![4 => unit(), 2 => (-20..20_i32).prop_map(|i| 1.0 + i as f32 * f32::EPSILON), 1 => 1.0_f32..3.0];
    let start = prop_oneof![3 => decade(-1, 4), 1 => decade(-6, 0), 1 => Just(0.0_f32)];
    (
        sphere,
        beside,
        start,
        direction(),
        point(),
        prop_oneof![Just((0.0, f32::INFINITY)), Just((0.5, 2.0))],
    )
        .prop_map(|((radius, at, offset), beside, start, d, aside, (t_min, t_max))| {
            let center = at * offset * radius;
            let across = d.cross(aside).normalize_or_zero();
            let origin = center + across * (beside * radius) - d * (start * radius);
            (center, radius, Ray { origin, direction: d, t_min, t_max })
        })
}

#[test]
fn both_roots_agree_with_the_oracle() {
    let (hits, misses, near) = (Cell::new(0), Cell::new(0), Cell::new(0));
    let count = |n: &Cell<u32>| n.set(n.get() + 1);
    let test = |(center, radius, mut ray): (Vec3, f32, Ray)| {
        if ray.t_max.is_finite() {
            let at = (center - ray.origin).length() / ray.direction.length();
            (ray.t_min, ray.t_max) = (ray.t_min * at, ray.t_max * at);
        }
        let truth = SphereTruth::new(&ray, center, radius);
        if !is_in_range(&ray, truth.reach) {
            return Ok(());
        }
        let found = PreparedRay::new(&ray).sphere(center, radius);
        let (t_min, t_max) = (f64::from(ray.t_min), f64::from(ray.t_max));
        if let Some(t) = found {
            prop_assert!(!truth.surely_missed(), "{truth:?}");
            let t = f64::from(t);
            prop_assert!(t >= t_min && t <= t_max);
            let p = ray.origin.as_dvec3() + ray.direction.as_dvec3() * t - center.as_dvec3();
            let off = (p.length() - f64::from(radius)).abs() / (SHELL_BOUND * truth.reach);
            prop_assert!(off <= 1.0, "{off} of the bound, {truth:?}");
        }
        if truth.surely_missed() {
            count(&misses);
        } else if truth.surely_hit() {
            count(&hits);
            let bound = SHELL_BOUND * truth.reach / ray.direction.as_dvec3().length();
            let half = (truth.t[1] - truth.t[0]) * 0.5 * ray.direction.as_dvec3().length();
            let slope = (half / f64::from(radius)).max(1e-6);
            let bound = bound / slope + bound;
            let first = truth.t.iter().find(|&&t| t > t_min + bound && t < t_max - bound);
            if let Some(&first) = first {
                let t = found.map(f64::from);
                // A root near an end of the ray may be taken before.
                let earlier = truth.t.iter().any(|&t| t < first && (t - t_min).abs() <= bound);
                prop_assert!(t.is_some(), "{truth:?}");
                let same = t.is_some_and(|t| (t - first).abs() <= bound);
                prop_assert!(same || earlier, "{t:?} {first} {bound} {truth:?}");
            }
        } else {
            count(&near);
        }
        Ok(())
    };
    runner(40_000).run(&case(), test).unwrap();
    let counts = (hits.get(), misses.get(), near.get());
    assert!(counts.0 > 10_000 && counts.1 > 3_000, "{counts:?}");
}
