//! Direct light of one lamp on a plane, against form factors (Howell's catalogue), in f64.

use super::*;
use crate::light::{Aim, Dark, Look, Seen};
use crate::trace::Scalar;
use core::f64::consts::PI;
use std::vec;

/// From a point on the plane z = 0 at the origin to a horizontal rectangle at height `h`, `[x0, x1] × [y0, y1]`: four corners of
/// Howell's B-3 (element parallel to a rectangle, its normal through a corner), which holds with signs.
pub(super) fn rectangle_above([x0, x1]: [f64; 2], [y0, y1]: [f64; 2], h: f64) -> f64 {
    let corner = |a: f64, b: f64| {
        let (a, b) = (a / h, b / h);
        let (p, q) = ((1.0 + a * a).sqrt(), (1.0 + b * b).sqrt());
        (a / p * (b / p).atan() + b / q * (a / q).atan()) / (2.0 * PI)
    };
    corner(x1, y1) - corner(x0, y1) - corner(x1, y0) + corner(x0, y0)
}

/// To a horizontal disc of radius `r` at height `h`, its axis at distance `a` (Howell B-13).
fn disc_above(r: f64, h: f64, a: f64) -> f64 {
    if a == 0.0 {
        return r * r / (r * r + h * h);
    }
    let (h, r) = (h / a, r / a);
    let z = 1.0 + h * h + r * r;
    0.5 * (1.0 - (1.0 + h * h - r * r) / (z * z - 4.0 * r * r).sqrt())
}

/// To a sphere of radius `r` wholly above the plane, its centre at `c`: sin² of its half angle times cosine.
pub(super) fn sphere_above(r: f64, c: [f64; 3]) -> f64 {
    let d2 = c.iter().map(|x| x * x).sum::<f64>();
    r * r / d2 * c[2] / d2.sqrt()
}

/// The point of the floor below the middle of the picture, and its first bundle.
pub(super) fn first_bundle(scene: &Scene, seed: u64) -> (Point, Bundle) {
    let shader = scene.shader();
    let path = Path::camera(PathKey::camera(seed, 7, 0));
    let ray = down(0.0, 0.0);
    let hit = Brute(scene).closest(&ray).unwrap();
    let (_, point) = shader.arrive(&path, &ray, hit.as_ref());
    let point = point.unwrap();
    let mut memo = Memo::new();
    let mut direct = shader.direct(Scalar, &point, &mut memo);
    let mut counts = Counts::default();
    let bundle = shader.next_bundle(Scalar, &point, &mut direct, &memo, &mut counts).unwrap();
    (point, bundle)
}

/// A white floor under a lamp of radiance 1 reflects exactly the form factor.
fn error(lamp: Light, exact: f64, n: u32, seeds: u64) -> f64 {
    let mut square = 0.0;
    for seed in 0..seeds {
        let mut scene = Scene {
            settings: Settings {
                samples: 1,
                shadow_samples: 0,
                bounces: 0,
                seed,
                ..Settings::default()
            },
            ..Scene::default()
        };
        floor(&mut scene, matt(1.0));
        if lamp.kind == LightKind::Disc as u32 {
            scene.lights.push(lamp)
        } else {
            scene.lamp(lamp)
        }
        let shader = scene.shader();
        let (point, bundle) = first_bundle(&scene, seed);
        let mut bundle = bundle.resized(n);
        let mut sum = Sum::ZERO;
        for j in 0..n {
            let Some(shadow) = shader.shadow_ray(&point, &mut bundle, j) else { continue };
            let mut depth = [OpticalDepth::CLEAR];
            Brute(&scene).depths(&[shadow.ray], &mut depth).unwrap();
            assert_eq!(depth, [OpticalDepth::CLEAR], "the lamp shades itself");
            sum.add(shader.unit().quantise(shadow.light));
        }
        let found = f64::from(shader.unit().resolve(sum, 1).x);
        square += (found - exact).powi(2);
    }
    (square / seeds as f64).sqrt()
}

/// Error falls at least as N^-0.75 from 4 to 4096, and is below a bound at 1024.
fn converges(name: &str, lamp: Light, exact: f64, at_1024: f64) {
    assert!(exact > 0.0003, "{name}");
    let seeds = 24;
    let errors: Vec<_> = [4, 16, 64, 256, 1024, 4096]
        .into_iter()
        .map(|n| (n, error(lamp, exact, n, seeds)))
        .collect();
    // What f32 leaves of directions, areas and the light's own corners.
    let floor = 1e-6;
    let (_, first) = errors[0];
    for &(n, error) in &errors {
        let bound = first * (f64::from(n) / 4.0).powf(-0.75) * 1.3 + floor;
        assert!(error <= bound, "{name}: {errors:?}");
    }
    assert!(errors[4].1 < at_1024, "{name}: {errors:?}");
}

pub(super) fn horizontal(kind: LightKind, x: [f32; 2], y: [f32; 2], h: f32) -> Light {
    // u × v points down.
    let u = Vec3::Y * (y[1] - y[0]);
    let v = Vec3::X * (x[1] - x[0]);
    light(kind, Vec3::new(x[0], y[0], h), u, v, 1.0)
}

#[test]
fn rectangles_near_and_far_agree_with_their_form_factors() {
    for (x, y, h, bound) in [
        ([-0.1, 0.1], [-0.1, 0.1], 0.95, 1e-4),
        ([0.3, 0.7], [-0.2, 0.5], 0.5, 1e-4),
        // Nearly all of the hemisphere: the cosine varies from 0 to 1. This is the error of samples alone; what is rendered of it is right to 1e-5 with any
        // number of rays (`unshadowed`).
        ([-0.5, 0.5], [-0.5, 0.5], 0.1, 3e-4),
        ([0.2, 1.2], [0.1, 0.4], 0.2, 1e-4),
        ([-1.0, 1.0], [-0.02, 0.02], 0.3, 1e-4),
    ] {
        let exact = rectangle_above(x.map(f64::from), y.map(f64::from), f64::from(h));
        converges("rectangle", horizontal(LightKind::Parallelogram, x, y, h), exact, bound);
    }
}

#[test]
fn triangles_agree_with_halves_of_squares_seen_along_their_diagonal() {
    for (size, h) in [(0.2_f32, 0.9), (1.0, 0.4)] {
        // A square over the point, cut through its centre: both halves bring the same.
        let x = [-size / 2.0, size / 2.0];
        let exact = rectangle_above(x.map(f64::from), x.map(f64::from), f64::from(h)) / 2.0;
        converges("triangle", horizontal(LightKind::Triangle, x, x, h), exact, 1e-4);
    }
}

#[test]
fn discs_agree_with_their_form_factors() {
    for (r, h, a) in [(0.1, 0.8, 0.3), (0.3, 0.5, 0.0), (0.5, 0.25, 0.4)] {
        let lamp = light(LightKind::Disc, Vec3::new(0.0, a, h), Vec3::Y * r, Vec3::X * r, 1.0);
        let exact = disc_above(f64::from(r), f64::from(h), f64::from(a));
        converges("disc", lamp, exact, 1e-4);
    }
}

#[test]
fn spheres_agree_with_their_form_factors() {
    for (r, c) in [
        (0.1, [0.2, 0.3, 0.7]),
        (0.4, [0.0, 0.0, 0.5]),
        (0.001, [0.0, 0.01, 0.005]),
        (0.3, [0.8, 0.1, 0.31]),
    ] {
        let lamp = light(LightKind::Sphere, Vec3::from(c), Vec3::X * r, Vec3::ZERO, 1.0);
        converges("sphere", lamp, sphere_above(f64::from(r), c.map(f64::from)), 1e-4);
    }
}

/// The form factor of any polygon above the horizon of a point at the origin, z up: Lambert's formula, a sum over edges.
fn polygon_above(corners: &[[f64; 3]]) -> f64 {
    let unit = |v: [f64; 3]| {
        let len = v.iter().map(|x| x * x).sum::<f64>().sqrt();
        v.map(|x| x / len)
    };
    let mut sum = 0.0;
    for (i, &a) in corners.iter().enumerate() {
        let (a, b) = (unit(a), unit(corners[(i + 1) % corners.len()]));
        let cross =
            [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
        let sin = cross.iter().map(|x| x * x).sum::<f64>().sqrt();
        let cos = a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        sum += sin.atan2(cos) * cross[2] / sin;
    }
    (sum / (2.0 * PI)).abs()
}

#[test]
fn lights_of_any_shape_and_attitude_agree_with_lamberts_formula() {
    let corner = Vec3::new(0.2, -0.3, 0.4);
    let (across, up) = (Vec3::new(0.1, 0.7, 0.05), Vec3::new(-0.2, 0.1, 0.5));
    let square = across.cross(up.cross(across)).normalize() * 0.5;
    for (kind, u, v) in [
        (LightKind::Parallelogram, across, up),
        (LightKind::Parallelogram, across, square),
        (LightKind::Triangle, across, up),
        (LightKind::Triangle, across * 0.1, up * 0.1),
        (LightKind::Parallelogram, across * 0.1, square * 0.1),
    ] {
        // Turned so that it shines towards the origin.
        let (u, v) = if u.cross(v).dot(corner) < 0.0 { (u, v) } else { (v, u) };
        let mut corners = vec![corner, corner + u, corner + u + v, corner + v];
        if kind == LightKind::Triangle {
            corners.remove(2);
        }
        let corners: Vec<_> = corners.into_iter().map(|c| c.to_array().map(f64::from)).collect();
        converges("polygon", light(kind, corner, u, v, 1.0), polygon_above(&corners), 1e-4);
    }
}

/// The solid angle of a flat lamp seen from the origin of z = 0, and the same times cosine, in f64, by the middles of many small parts.
fn size_of(lamp: &Light) -> [f64; 2] {
    let kind = LightKind::from_u32(lamp.kind).unwrap();
    let [position, u, v] = [lamp.position, lamp.u, lamp.v].map(|p| Vec3::from(p).as_dvec3());
    let normal = u.cross(v);
    let (n, disc) = (48, kind == LightKind::Disc);
    let mut sums = [0.0; 2];
    for k in 0..n * n {
        let [a, b] = [k % n, k / n].map(|i| (f64::from(i) + 0.5) / f64::from(n));
        let [a, b] = [a, b].map(|x| if disc { 2.0 * x - 1.0 } else { x });
        let inside = match kind {
            LightKind::Triangle => a + b <= 1.0,
            LightKind::Disc => a * a + b * b <= 1.0,
            _ => true,
        };
        let to = position + u * a + v * b;
        let cell = if disc { 4.0 } else { 1.0 } / f64::from(n * n);
        let part = if inside { cell * -to.dot(normal) / to.length().powi(3) } else { 0.0 };
        sums = [sums[0] + part, sums[1] + part * to.z.abs() / to.length()];
    }
    sums
}

/// The quick look at a light that is far away says what the whole one says, and no less than half of what it is worth, at any scale.
#[test]
fn lights_far_away_are_worth_what_a_quick_look_says() {
    let mut scene = Scene::default();
    floor(&mut scene, matt(1.0));
    scene.lights.push(horizontal(LightKind::Parallelogram, [0.0, 1.0], [0.0, 1.0], 1.0));
    let mut surface = first_bundle(&scene, 0).0.surface;
    surface.position = Vec3::ZERO;
    let numbers = crate::random::Sequence::from_seed(5);
    let (mut least, mut most, mut alike) = (1.0_f64, 1.0_f64, 0);
    for k in 0..8_000 {
        let [a, b] = numbers.point(6 * k);
        let [c, d] = numbers.point(6 * k + 1);
        let scale = [1.0, 1e-6, 1e6][k as usize % 3];
        let kinds = [LightKind::Parallelogram, LightKind::Triangle, LightKind::Disc];
        let kind = kinds[k as usize / 3 % 3];
        let u = Vec3::new(0.3 * a, 0.1, 0.05) * scale;
        let v = Vec3::new(0.1, -0.3 * b, 0.1) * scale;
        let v = if kind == LightKind::Disc { u.any_orthogonal_vector() } else { v };
        let at = Vec3::new(4.0 * c - 2.0, 4.0 * d - 2.0, 3.0 * a - 0.5) * scale;
        let lamp = Light { reach: 2.0 * scale, ..light(kind, at, u, v, 3.0) };
        let answers = [[true, false], [false, true], [true, true]][k as usize % 7 % 3];
        let quick = match Look::new(&lamp, &surface, answers).seen() {
            Seen::Near => continue,
            Seen::Far(estimate) => Ok(estimate),
            Seen::Dark(dark) => Err(dark),
        };
        match (quick, Aim::new(&lamp, &surface, answers)) {
            (Ok(quick), Ok(_)) => {
                let [solid_angle, projected] = size_of(&lamp).map(|exact| 3.0 * exact);
                least = least.min(f64::from(quick) / projected);
                most = most.max(f64::from(quick) / solid_angle);
                alike += 1;
            }
            // The quick one may think the light larger.
            (Ok(_), Err(Dark::Below)) => {}
            (quick, whole) => assert_eq!(quick.err(), whole.err(), "{lamp:?}"),
        }
    }
    assert!(alike > 1_000 && least > 0.8 && most < 1.5, "{alike} {least} {most}");
}

/// However few of many small lamps are asked, near and far, they stand for all: the mean is that of all form factors.
#[test]
fn few_of_many_lamps_stand_for_all() {
    let settings =
        Settings { samples: 1 << 13, shadow_samples: 1, bounces: 0, ..Settings::default() };
    let mut scene = Scene { settings, ..Scene::default() };
    floor(&mut scene, matt(1.0));
    let mut exact = 0.0;
    for k in 0..60 {
        let [a, b] = crate::random::Sequence::from_seed(3).point(k);
        let (x, y) = (3.0 * a - 1.5, 3.0 * b - 1.5);
        let (side, h) = (0.05 + 0.1 * (k % 4) as f32, 0.1 + 0.9 * a * b);
        let (x, y) = ([x, x + side], [y, y + 2.0 * side]);
        let kind = [LightKind::Parallelogram, LightKind::Triangle][k as usize % 2];
        scene.lights.push(horizontal(kind, x, y, h));
        exact += match kind {
            LightKind::Triangle => {
                let corner = |x: f32, y: f32| [x, y, h].map(f64::from);
                polygon_above(&[corner(x[0], y[0]), corner(x[0], y[1]), corner(x[1], y[0])])
            }
            _ => rectangle_above(x.map(f64::from), y.map(f64::from), f64::from(h)),
        };
    }
    for (lights, bound) in [(64, 2e-3), (8, 5e-3), (1, 0.02)] {
        scene.settings.lights = lights;
        let (seen, counts) = scene.seen(&down(0.0, 0.0), 0);
        let error = f64::from(seen.x) / exact - 1.0;
        assert!(error.abs() < bound, "{lights}: {error}");
        let asked = (60 << 13) - counts.lights_by_chance;
        assert!(asked <= u64::from(lights + 2) << 13, "{lights}: {counts:?}");
    }
}
