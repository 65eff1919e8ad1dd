//! Mirrors, panes, dielectrics and glossy surfaces, against closed forms and quadrature in f64.

use super::*;
use crate::geometry::Ray;

fn plastic(diffuse: f32, specular: f32, roughness: f32) -> Material {
    Material { specular: [specular; 3], roughness, ..matt(diffuse) }
}

fn looking(origin: Vec3, at: Vec3) -> Ray {
    let direction = (at - origin).normalize();
    Ray { origin, direction, t_min: 0.0, t_max: f32::INFINITY }
}

fn scene(samples: u32, bounces: u8, seed: u64) -> Scene {
    Scene {
        settings: Settings { samples, shadow_samples: 1, bounces, seed, ..Settings::default() },
        ..Scene::default()
    }
}

/// A lamp over the floor that faces down.
fn lamp(center: Vec3, size: f32, radiance: f32) -> Light {
    let (u, v) = (Vec3::Y * size, Vec3::X * size);
    light(LightKind::Parallelogram, center - (u + v) * 0.5, u, v, radiance)
}

#[test]
fn a_mirror_shows_the_lamp_and_its_back_is_dark() {
    let mut s = scene(1, 2, 0);
    floor(&mut s, Material { specular: [0.9, 0.5, 0.1], ..material(MaterialKind::Mirror) });
    s.lamp(lamp(Vec3::new(0.0, 0.5, 0.5), 0.2, 7.0));
    let (seen, counts) = s.seen(&looking(Vec3::new(0.0, -0.5, 0.5), Vec3::ZERO), 0);
    assert!((seen - Vec3::new(6.3, 3.5, 0.7)).abs().max_element() < 1e-4, "{seen}");
    // A mirror answers no light sample.
    assert_eq!((counts.specular, counts.shadow), (1, 0));
    let (behind, _) = s.seen(&looking(Vec3::new(0.0, 0.5, 1.0), Vec3::new(0.0, 0.5, 0.5)), 0);
    assert_eq!(behind, Vec3::ZERO);
}

/// Ward's lobe and Lambert under a rectangle, by midpoints in f64: the paper's formula, not ours.
fn quadrature(from: Vec3, eye: Vec3, lamp: &Light, diffuse: f64, specular: f64, alpha: f64) -> f64 {
    let n = 500;
    let (p, u, v) = (Vec3::from(lamp.position), Vec3::from(lamp.u), Vec3::from(lamp.v));
    let normal = u.cross(v).as_dvec3();
    let o = (eye - from).as_dvec3().normalize();
    let mut sum = 0.0;
    for a in 0..n {
        for b in 0..n {
            let (a, b) = ((f64::from(a) + 0.5) / f64::from(n), (f64::from(b) + 0.5) / f64::from(n));
            let to = p.as_dvec3() + u.as_dvec3() * a + v.as_dvec3() * b - from.as_dvec3();
            let i = to.normalize();
            let h = i + o;
            let tan2 = (h.x * h.x + h.y * h.y) / (h.z * h.z);
            let pi = core::f64::consts::PI;
            let gloss = specular * (-tan2 / (alpha * alpha)).exp() / (pi * alpha * alpha)
                * h.dot(h)
                / h.z.powi(4);
            sum += (diffuse / pi + gloss) * i.z * -i.dot(normal) / to.dot(to);
        }
    }
    sum / f64::from(n * n) * f64::from(lamp.radiance[0])
}

/// Both ways to the light together, or light sampling alone, bring what the integral says: whatever the roughness, the size of the
/// lamp and what chance leaves out.
#[test]
fn a_glossy_surface_counts_each_light_once() {
    let eye = Vec3::new(0.1, -0.5, 0.5);
    for (roughness, size, bounces, noise) in [
        (0.02, 0.3, 3, 0.02),
        (0.02, 0.02, 3, 0.03),
        (0.1, 0.3, 3, 0.01),
        (0.1, 0.3, 0, 0.02),
        (0.1, 0.02, 3, 0.01),
        (0.5, 0.3, 3, 0.01),
        (0.5, 0.3, 0, 0.01),
    ] {
        // The last is so weak that its rays are left to chance, and alone.
        for (diffuse, specular) in [(0.2, 0.7), (0.2, 0.02), (0.0, 0.003)] {
            let mut s = scene(4096, bounces, 11);
            floor(&mut s, plastic(diffuse, specular, roughness));
            let lamp = lamp(Vec3::new(-0.1, 0.55, 0.5), size, 3.0);
            s.lamp(lamp);
            let (seen, _) = s.seen(&looking(eye, Vec3::ZERO), 3);
            let (d, g) = (f64::from(diffuse), f64::from(specular));
            let exact = quadrature(Vec3::ZERO, eye, &lamp, d, g, f64::from(roughness));
            let error = (f64::from(seen.x) / exact - 1.0).abs();
            assert!(
                error < noise,
                "roughness {roughness} lamp {size} specular {specular} bounces {bounces}: {} {exact}",
                seen.x
            );
        }
    }
}

/// The same light in many pieces of one material: the ray must find out which it has hit.
#[test]
fn pieces_of_a_light_are_the_light() {
    let eye = Vec3::new(0.1, -0.5, 0.5);
    let whole = lamp(Vec3::new(-0.1, 0.55, 0.5), 0.3, 3.0);
    let mut s = scene(4096, 3, 11);
    floor(&mut s, plastic(0.2, 0.7, 0.1));
    s.lamp(whole);
    let shared = s.lights[0].material;
    s.lights.clear();
    let (p, u, v) = (Vec3::from(whole.position), Vec3::from(whole.u), Vec3::from(whole.v));
    for i in 0..4 {
        for half in 0..2 {
            let corner = p + u * (0.25 * i as f32);
            let (u, v) = (u * 0.25, v);
            let (corner, u, v) = if half == 0 { (corner, u, v) } else { (corner + u + v, -u, -v) };
            let piece = light(LightKind::Triangle, corner, u, v, 3.0);
            s.lights.push(Light { material: shared, ..piece });
        }
    }
    let (seen, _) = s.seen(&looking(eye, Vec3::ZERO), 3);
    let exact = quadrature(Vec3::ZERO, eye, &whole, 0.2, 0.7, 0.1);
    assert!((f64::from(seen.x) / exact - 1.0).abs() < 0.01, "{} {exact}", seen.x);
}

#[test]
fn what_chance_leaves_out_others_stand_for() {
    // A mirror that brings a 400th of the pixel: four of five rays are not sent.
    let mut s = scene(1 << 12, 2, 0);
    floor(&mut s, Material { specular: [0.0025; 3], ..material(MaterialKind::Mirror) });
    s.lamp(lamp(Vec3::new(0.0, 0.5, 0.5), 0.2, 400.0));
    let (seen, counts) = s.seen(&looking(Vec3::new(0.0, -0.5, 0.5), Vec3::ZERO), 0);
    assert!((seen.x - 1.0).abs() < 1e-3, "{seen}");
    assert!(counts.specular < (1 << 12) / 4 && counts.specular > (1 << 12) / 6);
    assert_eq!(counts.specular + counts.specular_by_chance, 1 << 12);
}

/// Deep in a hall of mirrors one child of two is chosen, and few are sent: the mean is the sum of the series.
#[test]
fn long_paths_keep_their_mean() {
    // Two half-silvered panes face each other, a lamp between them would be seen again and again. Instead: sheets
    // of trans stacked above a lamp; each reflects .4 and passes .5.
    let sheet = Material {
        specular: [0.4; 3],
        transmit: [0.5; 3],
        transmit_specular: 1.0,
        ..material(MaterialKind::Opaque)
    };
    let sheets = 3;
    let mut s = scene(1 << 15, 30, 5);
    let of = s.material(sheet);
    for k in 0..sheets {
        let corner = Vec3::new(-40.0, -40.0, 0.2 + 0.1 * k as f32);
        s.rectangle(of, corner, Vec3::X * 81.0, Vec3::Y * 83.0);
    }
    // A glow that only is seen.
    let glow = s.material(Material { emission: [1.0; 3], ..material(MaterialKind::Light) });
    s.rectangle(glow, Vec3::new(-40.0, -40.0, 0.0), Vec3::X * 81.0, Vec3::Y * 83.0);
    let (seen, counts) = s.seen(&looking(Vec3::new(0.0, 0.1, 1.0), Vec3::ZERO), 0);
    // Adding doubling: sheets in a row over a black emitter (what comes down to it is lost).
    let (mut r, mut t) = (0.4_f64, 0.5_f64);
    for _ in 1..sheets {
        let rest = 1.0 - 0.4 * r;
        (r, t) = (0.4 + 0.5 * 0.5 * r / rest, t * 0.5 / rest);
    }
    assert!((f64::from(seen.x) / t - 1.0).abs() < 0.01, "{} {t} ({r})", seen.x);
    assert!(counts.specular_by_chance > 0);
}

#[test]
fn many_small_lights_are_asked_by_turns() {
    let mut s = scene(1 << 12, 0, 1);
    floor(&mut s, matt(1.0));
    let mut exact = 0.0;
    for k in 0..300 {
        let [a, b] = crate::random::Sequence::from_seed(77).point(k);
        let at = Vec3::new(4.0 * a - 2.0, 4.0 * b - 2.0, 0.2 + 0.5 * a * b);
        let power = 0.1 + (k % 7) as f32;
        s.lights.push(light(LightKind::Point, at, Vec3::ZERO, Vec3::ZERO, power));
        let d2 = f64::from(at.length_squared());
        exact += f64::from(power * at.z) / (d2 * d2.sqrt()) / core::f64::consts::PI;
    }
    // Noise grows as fewer are asked.
    for (lights, bound) in [(64, 2e-3), (8, 0.01), (1, 0.03)] {
        s.settings.lights = lights;
        let (seen, counts) = s.seen(&down(0.0, 0.0), 0);
        assert!((f64::from(seen.x) / exact - 1.0).abs() < bound, "{lights}: {} {exact}", seen.x);
        let most = u64::from(lights) * 5 / 4 + 1;
        assert!(counts.shadow <= most << 12, "{lights}: {counts:?}");
        assert_eq!(counts.shadow + counts.lights_by_chance, 300 << 12);
    }
}

#[test]
fn points_spots_and_reach() {
    let at = Vec3::new(0.3, 0.0, 0.4);
    let expected = 2.0 * 0.8 / 0.25 * core::f32::consts::FRAC_1_PI;
    let mut s = scene(1, 0, 1);
    floor(&mut s, matt(1.0));
    let seen = |s: &mut Scene, l: Light| {
        s.lights = std::vec![l];
        s.seen(&down(0.0, 0.0), 0)
    };
    let point = light(LightKind::Point, at, Vec3::ZERO, Vec3::ZERO, 2.0);
    let found = seen(&mut s, point).0.x;
    assert!((found - expected).abs() < 1e-4, "{found} {expected}");
    let (dark, counts) = seen(&mut s, Light { reach: 0.49, ..point });
    assert_eq!((dark, counts.lights_out_of_reach, counts.shadow), (Vec3::ZERO, 1, 0));
    assert!(seen(&mut s, Light { reach: 0.51, ..point }).0.x > 0.0);
    let aimed = |axis: Vec3, cos: f32| {
        light(LightKind::Spot, at, axis.normalize(), Vec3::new(cos, 0.0, 0.0), 2.0)
    };
    assert!((seen(&mut s, aimed(-at, 0.999)).0.x - expected).abs() < 1e-4);
    let (dark, counts) = seen(&mut s, aimed(Vec3::NEG_Z, 0.9));
    assert_eq!((dark, counts.lights_facing_away), (Vec3::ZERO, 1));
    let (dark, counts) = seen(&mut s, Light { position: [0.0, 0.1, -0.2], ..point });
    assert_eq!((dark, counts.lights_below), (Vec3::ZERO, 1));
    // A lamp whose cone does not hold the direction is dark, for light sampling and for the eye.
    let narrow = Light { cone: [0.0, 0.0, -1.0], cone_cos: 0.9, ..lamp(at, 0.01, 2.0) };
    assert_eq!(seen(&mut s, narrow).0, Vec3::ZERO);
    let mut s = scene(1, 0, 1);
    s.lamp(narrow);
    assert_eq!(s.seen(&looking(Vec3::ZERO, at), 0).0, Vec3::ZERO);
    assert_eq!(s.seen(&looking(Vec3::new(0.3, 0.0, 0.0), at), 0).0.x, 2.0);
}

/// As Radiance's `srcray` (`source.c`): the solid angle is that at the distance and the focal length.
#[test]
fn a_focal_length_dims_what_is_near() {
    let at = Vec3::new(0.3, 0.0, 0.4);
    let (distance, focus) = (0.5_f32, 0.25_f32);
    let part = (distance / (distance + focus)).powi(2);
    // Points, lamps that shadow rays find, and lamps that glossy rays find as often.
    let glossy = Material { specular: [0.5; 3], roughness: 0.2, ..matt(0.0) };
    let small = lamp(at, 0.02, 2.0);
    let point = light(LightKind::Point, at, Vec3::ZERO, Vec3::ZERO, 2.0);
    let great = lamp(at, 0.12, 2.0);
    let eye = Vec3::new(-0.3, 0.0, 0.4);
    for (material, lamp, within) in [
        (matt(1.0), point, 1e-5),
        (matt(1.0), small, 1e-3),
        (glossy, small, 5e-3),
        (glossy, great, 0.02),
    ] {
        let seen = |focus: f32| {
            let mut s = scene(1 << 14, 1, 1);
            floor(&mut s, material);
            let lamp = Light { focus, ..lamp };
            if LightKind::from_u32(lamp.kind) == Some(LightKind::Point) {
                s.lights.push(lamp);
            } else {
                s.lamp(lamp);
            }
            // To the eye it is as bright as ever.
            let looked_at = s.seen(&looking(Vec3::new(0.3, 0.0, 0.1), at), 0).0.x;
            assert!(looked_at == 2.0 || lamp.kind == LightKind::Point as u32);
            s.seen(&looking(eye, Vec3::ZERO), 0).0.x
        };
        let found = seen(focus) / seen(0.0);
        assert!((found / part - 1.0).abs() < within, "{found} {part} {within}");
    }
}

/// Radiance's normal.c: what a smooth highlight of .04 or more takes towards the horizon is missing from all else, for light that comes
/// and for light that leaves.
#[test]
fn smooth_highlights_take_more_aslant() {
    let fresnel = |cos: f64| (-5.85 * cos).exp() - 0.002_029_430_64;
    let floor_of = |specular: f32, roughness: f32| {
        let sheet = Material { transmit: [0.3; 3], transmit_specular: 1.0, ..matt(0.5) };
        Material { specular: [specular; 3], roughness, ..sheet }
    };
    // From 60 degrees a lamp at 72.5 is seen, in the mirror the sky, and through the sheet another.
    let (eye, lamp) = (Vec3::new(-0.866_025_4, 0.0, 0.5), Vec3::new(0.953_939_2, 0.0, 0.3));
    let seen = |specular: f32, roughness: f32, lit: [f32; 3]| {
        let mut s = scene(1, 1, 1);
        floor(&mut s, floor_of(specular, roughness));
        s.lights.push(light(LightKind::Point, lamp, Vec3::ZERO, Vec3::ZERO, lit[0]));
        for (up, radiance) in [(Vec3::Z, lit[1]), (Vec3::NEG_Z, lit[2])] {
            // Seen only.
            let half = light(LightKind::Distant, Vec3::ZERO, up, Vec3::ZERO, radiance);
            s.lights.push(Light { reach: 0.0, ..half });
        }
        f64::from(s.seen(&looking(eye, Vec3::ZERO), 0).0.x)
    };
    let (from, to) = (fresnel(f64::from(lamp.z)), fresnel(0.5));
    let matt = 0.5 * f64::from(lamp.z) / core::f64::consts::PI;
    let close = |a: f64, b: f64| assert!((a / b - 1.0).abs() < 1e-5, "{a} {b}");
    close(seen(0.04, 0.0, [1.0, 0.0, 0.0]), matt * (1.0 - from) * (1.0 - to));
    close(seen(0.04, 0.0, [0.0, 1.0, 0.0]), 0.04 + 0.96 * to);
    close(seen(0.04, 0.0, [0.0, 0.0, 1.0]), 0.3 * (1.0 - to));
    close(seen(0.015, 0.0, [1.0, 0.0, 0.0]), matt);
    close(seen(0.015, 0.0, [0.0, 1.0, 0.0]), 0.015);
    // Shadow rays as well: from below, aslant by 60 degrees.
    let through = |specular: f32| {
        let mut s = scene(1, 0, 1);
        floor(&mut s, super::matt(1.0));
        let sheet = s.material(floor_of(specular, 0.0));
        s.rectangle(sheet, Vec3::new(-1.0, -1.0, 0.1), Vec3::X * 2.0, Vec3::Y * 2.0);
        let at = Vec3::new(0.866_025_4, 0.0, 0.5);
        s.lights.push(light(LightKind::Point, at, Vec3::ZERO, Vec3::ZERO, 1.0));
        f64::from(s.seen(&down(0.0, 0.0), 0).0.x)
    };
    // They begin a little above the great floor.
    let passed = through(0.04) / through(0.015);
    assert!((passed / (1.0 - to) - 1.0).abs() < 1e-4, "{passed}");
}

#[test]
fn shadow_rays_lose_in_panes_what_the_panes_take() {
    let sheet = Material {
        transmit: [0.8, 0.5, 0.0],
        transmit_specular: 0.5,
        ..material(MaterialKind::Opaque)
    };
    let glass = Material { ior: 1.52, transmit: [0.96; 3], ..material(MaterialKind::Glass) };
    let lit = |panes: &[Material]| {
        let mut s = scene(1, 0, 1);
        floor(&mut s, matt(1.0));
        s.lights.push(light(LightKind::Point, Vec3::Z, Vec3::ZERO, Vec3::ZERO, 1.0));
        for (k, pane) in panes.iter().enumerate() {
            let of = s.material(*pane);
            let corner = Vec3::new(-1.0, -1.1, 0.2 + 0.1 * k as f32);
            s.rectangle(of, corner, Vec3::X * 2.3, Vec3::Y * 2.1);
        }
        s.seen(&down(0.0, 0.0), 0).0 * core::f32::consts::PI
    };
    let close = |a: Vec3, b: Vec3| assert!((a - b).abs().max_element() < 1e-4, "{a} {b}");
    close(lit(&[]), Vec3::ONE);
    close(lit(&[sheet]), Vec3::new(0.4, 0.25, 0.0));
    let (_, t) = crate::material::fresnel::pane(1.0, 1.52, Vec3::splat(0.96));
    close(lit(&[glass, sheet]), t * Vec3::new(0.4, 0.25, 0.0));
    assert_eq!(lit(&[glass, sheet, glass]), lit(&[sheet, glass, glass]));
    close(lit(&[material(MaterialKind::Void)]), Vec3::ONE);
    // The far side of a ball weakens light as well as the near one, unless the light is within.
    let through_ball = |radius: f32| {
        let mut s = scene(1, 0, 1);
        floor(&mut s, matt(1.0));
        s.lights.push(light(LightKind::Point, Vec3::Z, Vec3::ZERO, Vec3::ZERO, 1.0));
        let of = s.material(glass);
        s.sphere(of, Vec3::Z * 0.7, radius);
        s.seen(&down(0.0, 0.0), 0).0 * core::f32::consts::PI
    };
    close(through_ball(0.2), t * t);
    close(through_ball(0.4), t);
    for blocks in [
        matt(0.0),
        material(MaterialKind::Dielectric),
        Material { roughness: 0.1, ..sheet },
        material(MaterialKind::Light),
    ] {
        assert_eq!(lit(&[glass, blocks]), Vec3::ZERO);
    }
}

/// A slab of coloured glass before a glow: the series of its inner reflections.
#[test]
fn a_slab_absorbs_over_the_way_inside() {
    let absorption = [0.0, 2.0, 30.0];
    let mut s = scene(1 << 12, 30, 2);
    let of = s.material(Material { absorption, ..material(MaterialKind::Dielectric) });
    let corner = Vec3::new(-40.0, -40.0, 0.2);
    s.rectangle(of, corner, Vec3::Y * 81.0, Vec3::X * 83.0);
    s.rectangle(of, corner + Vec3::Z * 0.1, Vec3::X * 81.0, Vec3::Y * 83.0);
    let glow = s.material(Material { emission: [1.0; 3], ..material(MaterialKind::Light) });
    s.rectangle(glow, Vec3::new(-40.0, -40.0, 0.0), Vec3::X * 81.0, Vec3::Y * 83.0);
    let theta = 0.8_f64;
    let eye = Vec3::new(theta.sin() as f32, 0.0, theta.cos() as f32);
    let (seen, _) = s.seen(&looking(eye, Vec3::ZERO), 0);
    let inside = (theta.sin() / 1.5).asin();
    let rs = ((theta - inside).sin() / (theta + inside).sin()).powi(2);
    let rp = ((theta - inside).tan() / (theta + inside).tan()).powi(2);
    // Unpolarised at each interface, as rays without polarisation must have it.
    let r = 0.5 * (rs + rp);
    for (seen, a) in seen.to_array().into_iter().zip(absorption) {
        let pass = (-f64::from(a) * 0.1 / inside.cos()).exp();
        let exact = (1.0 - r).powi(2) * pass / (1.0 - r * r * pass * pass);
        assert!((f64::from(seen) / exact - 1.0).abs() < 0.01, "{seen} {exact}");
    }
}

#[test]
fn light_inside_a_medium_is_absorbed_on_both_ways() {
    // A camera, a floor and a lamp under water.
    let mut s = scene(1, 2, 2);
    floor(&mut s, matt(1.0));
    let of =
        s.material(Material { absorption: [1.0, 0.0, 3.0], ..material(MaterialKind::Dielectric) });
    s.lights.push(light(LightKind::Point, Vec3::Z * 0.5, Vec3::ZERO, Vec3::ZERO, 1.0));
    let shader = s.shader();
    let ray = Ray { origin: Vec3::Z * 0.25, ..down(0.0, 0.0) };
    let path = Path { medium: of, ..Path::camera(crate::path::PathKey::camera(0, 0, 0)) };
    let Ok(sum) = shader.trace(&mut Brute(&s), &ray, path, &mut Counts::default());
    let seen = shader.unit().resolve(sum, 1);
    for (seen, a) in seen.to_array().into_iter().zip([1.0_f32, 0.0, 3.0]) {
        let expected = (-a * 0.75).exp() * 4.0 / core::f32::consts::PI;
        assert!((seen / expected - 1.0).abs() < 1e-5, "{seen} {expected}");
    }
}

#[test]
fn bent_normals_leak_no_light_and_make_none() {
    use crate::block::octahedral::encode;
    for tilt in [0.3_f32, 0.9, 1.4] {
        for of in [matt(1.0), plastic(0.0, 1.0, 0.2), plastic(0.0, 1.0, 0.0)] {
            let mut s = scene(256, 4, 3);
            s.settings.shadow_samples = 0;
            let of = s.material(of);
            let code = encode(Vec3::new(tilt.sin(), 0.0, tilt.cos()));
            s.primitives.push((
                of,
                Primitive::Triangle {
                    vertices: [Vec3::new(-9.0, -9.0, 0.0), Vec3::X * 9.0, Vec3::Y * 9.0],
                    normals: Some([code; 3]),
                },
            ));
            // All light comes from below the real horizon, and would be above the shaded one.
            let below =
                light(LightKind::Point, Vec3::new(9.5, 0.0, -0.5), Vec3::ZERO, Vec3::ZERO, 9.0);
            s.lights.push(below);
            for eye in [Vec3::new(-0.7, 0.0, 0.2), Vec3::new(0.7, 0.1, 0.2), Vec3::Z] {
                assert_eq!(s.seen(&looking(eye, Vec3::ZERO), 0).0, Vec3::ZERO);
            }
            s.lights[0] = light(LightKind::Distant, Vec3::ZERO, Vec3::Z, Vec3::NEG_X, 1.0);
            for eye in [Vec3::new(-0.7, 0.0, 0.2), Vec3::new(0.7, 0.1, 0.2), Vec3::Z] {
                let (seen, _) = s.seen(&looking(eye, Vec3::ZERO), 0);
                assert!(seen.x > 0.0 && seen.x <= 1.01, "{tilt} {eye}: {seen}");
            }
        }
    }
}

#[test]
fn radiance_grows_by_the_square_of_the_index_inside() {
    let mut s = scene(4096, 1, 2);
    let of = s.material(material(MaterialKind::Dielectric));
    s.rectangle(of, Vec3::new(-4.0, -4.0, 0.2), Vec3::X * 8.1, Vec3::Y * 8.3);
    let glow = s.material(Material { emission: [1.0; 3], ..material(MaterialKind::Light) });
    s.rectangle(glow, Vec3::new(-4.0, -4.0, 0.4), Vec3::Y * 8.3, Vec3::X * 8.1);
    let (seen, _) = s.seen(&looking(Vec3::new(0.1, 0.2, 0.0), Vec3::new(0.1, 0.2, 1.0)), 0);
    assert!((seen.x / (0.96 * 2.25) - 1.0).abs() < 1e-3, "{seen}");
}
