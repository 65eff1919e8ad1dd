use std::cell::Cell;

use kiloray_core::geometry::PreparedRay;
use kiloray_tests::oracle::{POINT_BOUND, TriangleTruth, distance_to_triangle};
use proptest::prelude::*;

use crate::cases::{is_in_range, ray_at, runner, triangle};

#[test]
fn hits_and_misses_agree_with_the_oracle_within_its_bounds() {
    let (sure_hits, sure_misses, near) = (Cell::new(0), Cell::new(0), Cell::new(0));
    let count = |n: &Cell<u32>| n.set(n.get() + 1);
    let strategy = triangle().prop_flat_map(|v| (Just(v), ray_at(v)));
    let test = |(vertices, ray)| {
        let truth = TriangleTruth::new(&ray, vertices);
        if !is_in_range(&ray, truth.reach) {
            return Ok(());
        }
        let found = PreparedRay::new(&ray).triangle(vertices);
        if let Some(hit) = found {
            prop_assert!(!truth.surely_missed(), "{truth:?}");
            prop_assert!(hit.t >= ray.t_min && hit.t <= ray.t_max);
            // The point on the ray and the point of the weights are one and the same on the triangle.
            let point = ray.origin.as_dvec3() + ray.direction.as_dvec3() * f64::from(hit.t);
            let bound = POINT_BOUND * truth.reach;
            let off = distance_to_triangle(point, vertices);
            prop_assert!(off <= bound, "{} of the bound, {truth:?}", off / bound);
            let (b1, b2) = (f64::from(hit.b1), f64::from(hit.b2));
            let [v0, v1, v2] = vertices.map(|v| v.as_dvec3());
            let of_weights = v0 + (v1 - v0) * b1 + (v2 - v0) * b2;
            let apart = (of_weights - point).length();
            prop_assert!(apart <= 2.0 * bound, "{} of the bound, {truth:?}", apart / bound);
            let tiny = 1e-6;
            prop_assert!(b1 >= -tiny && b2 >= -tiny && b1 + b2 <= 1.0 + tiny, "{hit:?}");
        }
        if truth.surely_missed() {
            count(&sure_misses);
        } else if truth.surely_hit() {
            count(&sure_hits);
            let (lo, hi) = (truth.t - truth.t_error, truth.t + truth.t_error);
            let inside = lo >= f64::from(ray.t_min) && hi <= f64::from(ray.t_max);
            prop_assert!(found.is_some() || !inside, "{truth:?}");
            let outside = hi < f64::from(ray.t_min) || lo > f64::from(ray.t_max);
            prop_assert!(found.is_none() || !outside, "{truth:?}");
        } else {
            count(&near);
        }
        Ok(())
    };
    runner(80_000).run(&strategy, test).unwrap();
    let counts = (sure_hits.get(), sure_misses.get(), near.get());
    assert!(counts.0 > 10_000 && counts.1 > 10_000 && counts.2 > 3_000, "{counts:?}");
}

#[test]
fn a_triangle_and_its_ray_may_be_turned_over_and_scaled() {
    // What does not change the rounded numbers does not change the hit: the order of the axes, a point reflection. Powers of two
    // and the order of the vertices do not change hit or miss.
    let strategy = triangle().prop_flat_map(|v| (Just(v), ray_at(v), -20..20_i32));
    let test = |(vertices, ray, e)| {
        let truth = TriangleTruth::new(&ray, vertices);
        // Away from the least numbers of f32, where scaling rounds.
        let whole = |v: &glam::Vec3| v.to_array().iter().all(|x| *x == 0.0 || x.abs() > 1e-18);
        let numbers = vertices.iter().chain([&ray.origin, &ray.direction]).all(whole);
        if !is_in_range(&ray, truth.reach) || truth.reach > 1e12 || !numbers {
            return Ok(());
        }
        let found = PreparedRay::new(&ray).triangle(vertices);
        let scale = 2_f32.powi(e);
        let mut scaled = ray;
        scaled.origin *= scale;
        scaled.direction *= scale;
        if is_in_range(&scaled, truth.reach) {
            let again = PreparedRay::new(&scaled).triangle(vertices.map(|v| v * scale));
            // The same numbers but for their exponents; tiny ones are tested in f64.
            let bound = 2.0 * truth.t_error;
            let near = match (found, again) {
                (Some(a), Some(b)) => f64::from(a.t - b.t).abs() <= bound || a.t == b.t,
                (None, None) => true,
                _ => ray.t_max.is_finite(),
            };
            prop_assert!(near, "{found:?} {again:?}");
        }
        let turned = |v: glam::Vec3| glam::Vec3::new(v.y, v.z, v.x);
        let mut turned_ray = ray;
        turned_ray.origin = turned(ray.origin);
        turned_ray.direction = turned(ray.direction);
        let again = PreparedRay::new(&turned_ray).triangle(vertices.map(turned));
        let a = ray.direction.abs();
        if a.x != a.y && a.y != a.z && a.z != a.x {
            prop_assert_eq!(found, again);
        }
        let mut mirrored = ray;
        mirrored.origin = -ray.origin;
        mirrored.direction = -ray.direction;
        let again = PreparedRay::new(&mirrored).triangle(vertices.map(|v| -v));
        prop_assert_eq!(found.map(|h| h.t), again.map(|h| h.t));
        let [a, b, c] = vertices;
        let again = PreparedRay::new(&ray).triangle([a, c, b]);
        // Another order of a sum: the last place of t may differ, which the ends of the ray can see.
        let apart = truth.t.abs() > truth.t_error;
        let near_an_end = ray.t_max.is_finite() || !apart;
        prop_assert!(near_an_end || found.is_some() == again.is_some());
        Ok(())
    };
    runner(30_000).run(&strategy, test).unwrap();
}
