//! Lamps whose light is known without shadows: what the rays of a bundle share is exactly that.

use super::direct::{first_bundle, horizontal, rectangle_above, sphere_above};
use super::*;

/// What a bundle of a white floor brings: the sum of its rays if nothing is in the way, which is what is said of it before, and of those that pass `is_seen`.
fn bring(lamp: Light, shadow_samples: u16, seed: u64, is_seen: impl Fn(Vec3) -> bool) -> [f64; 2] {
    let settings = Settings { samples: 1, shadow_samples, bounces: 0, seed, ..Settings::default() };
    let mut scene = Scene { settings, ..Scene::default() };
    floor(&mut scene, matt(1.0));
    scene.lights.push(lamp);
    let shader = scene.shader();
    let (point, mut bundle) = first_bundle(&scene, seed);
    assert!(bundle.len > 1);
    let known = shader.unit().quantise(bundle.unshadowed().expect("known"));
    let (mut all, mut seen) = (Sum::ZERO, Sum::ZERO);
    for j in 0..bundle.len {
        let Some(shadow) = shader.shadow_ray(&point, &mut bundle, j) else { continue };
        let light = shader.unit().quantise(shadow.light);
        all.add(light);
        if is_seen(shadow.ray.direction) {
            seen.add(light);
        }
    }
    assert_eq!(all, known, "the parts are the whole, to the bit");
    [all, seen].map(|sum| f64::from(shader.unit().resolve(sum, 1).x))
}

#[test]
fn what_is_known_is_the_form_factor() {
    for (x, y, h) in [
        ([-0.1, 0.1], [-0.1, 0.1], 0.95),
        ([0.3, 0.7], [-0.2, 0.5], 0.5),
        ([-0.5, 0.5], [-0.5, 0.5], 0.1),
    ] {
        let exact = rectangle_above(x.map(f64::from), y.map(f64::from), f64::from(h));
        let lamp = horizontal(LightKind::Parallelogram, x, y, h);
        let [all, ..] = bring(lamp, 16, 3, |_| true);
        assert!((all - exact).abs() < 1e-5 * exact, "{all} {exact}");
    }
    let (r, c) = (0.4, [0.1, 0.0, 0.6]);
    let lamp = light(LightKind::Sphere, Vec3::from(c), Vec3::X * r, Vec3::ZERO, 1.0);
    let exact = sphere_above(f64::from(r), c.map(f64::from));
    let [all, ..] = bring(lamp, 16, 3, |_| true);
    assert!((all - exact).abs() < 1e-5 * exact, "{all} {exact}");
}

#[test]
fn a_lamp_that_is_half_hidden_brings_its_other_half() {
    // Near the point, so that its parts weigh differently, and far.
    for (x, h, bounds) in
        [([-0.3, 0.9], 0.3, [2e-3, 5e-4, 5e-4]), ([-0.2, 0.4], 0.9, [2e-3, 5e-4, 5e-4])]
    {
        let y = [-0.2, 0.5];
        let lamp = horizontal(LightKind::Parallelogram, x, y, h);
        let exact = rectangle_above([0.0, f64::from(x[1])], y.map(f64::from), f64::from(h));
        for (shadow_samples, bound) in [4, 16, 64].into_iter().zip(bounds) {
            let seeds = 4000;
            let one = |seed| bring(lamp, shadow_samples, seed, |to| to.x > 0.0)[1];
            let mean = (0..seeds).map(one).sum::<f64>() / seeds as f64;
            assert!((mean / exact - 1.0).abs() < bound, "{shadow_samples}: {mean} {exact}");
        }
    }
}

/// The part of a lamp that brings most, or all but that, is hidden: what is in the way has much to do with how bright the samples are.
#[test]
fn a_lamp_is_right_in_the_mean_where_its_brightest_part_is_hidden() {
    let (x, y, h) = ([0.0, 0.6], [-0.02, 0.02], 0.3);
    let lamp = horizontal(LightKind::Parallelogram, x, y, h);
    let part = |x: [f64; 2]| rectangle_above(x, y.map(f64::from), f64::from(h));
    for shadow_samples in [2, 4, 16, 64] {
        let seeds = 60_000;
        let [mut near, mut far] = [0.0; 2];
        for seed in 0..seeds {
            near += bring(lamp, shadow_samples, seed, |to| to.x < 0.2)[1] / seeds as f64;
            far += bring(lamp, shadow_samples, seed, |to| to.x > 0.2)[1] / seeds as f64;
        }
        for (mean, exact) in [(near, part([0.0, 0.2])), (far, part([0.2, 0.6]))] {
            assert!((mean / exact - 1.0).abs() < 6e-3, "{shadow_samples}: {mean} {exact}");
        }
    }
}

/// Where a sample may bring all of a light, nothing is dealt out.
#[test]
fn of_a_long_lamp_close_by_nothing_is_known() {
    let lamp = horizontal(LightKind::Parallelogram, [0.0, 4.0], [-0.02, 0.02], 0.05);
    let settings = Settings { samples: 1, shadow_samples: 64, ..Settings::default() };
    let mut scene = Scene { settings, ..Scene::default() };
    floor(&mut scene, matt(1.0));
    scene.lights.push(lamp);
    let (_, bundle) = first_bundle(&scene, 1);
    assert_eq!(bundle.unshadowed(), None);
}
