//! Light that a glossy surface finds in two ways, or in one alone: none is lost, and none counted twice.

use super::*;

/// A sky of this half angle about an axis.
fn sky(axis: Vec3, half: f32) -> Light {
    light(LightKind::Distant, Vec3::ZERO, axis, Vec3::X * libm::cosf(half), 1.0)
}

fn metal(roughness: f32) -> Material {
    Material { specular: [1.0; 3], roughness, ..matt(0.0) }
}

fn scene(samples: u32, bounces: u8) -> Scene {
    let settings = Settings { samples, shadow_samples: 1, bounces, seed: 5, ..Settings::default() };
    Scene { settings, ..Scene::default() }
}

/// From above, not quite straight down.
fn seen(scene: &Scene) -> f64 {
    let direction = Vec3::new(0.1, 0.2, -1.0).normalize();
    let ray = Ray { origin: -direction * 0.1, direction, t_min: 0.0, t_max: f32::INFINITY };
    f64::from(scene.seen(&ray, 1).0.x)
}

#[test]
fn light_that_comes_through_a_clear_pane_is_the_light() {
    // Neither reflects anything, and both take nothing.
    let glass = Material { ior: 1.0, transmit: [1.0; 3], ..material(MaterialKind::Glass) };
    let sheet = Material { transmit: [1.0; 3], transmit_specular: 1.0, ..matt(0.0) };
    let lamp = |size: f32, at: Vec3| {
        let (u, v) = (Vec3::Y * size, Vec3::X * size);
        light(LightKind::Parallelogram, at - (u + v) * 0.5, u, v, 1.0)
    };
    for (roughness, bound) in [(0.05, 0.02), (0.2, 0.01), (0.5, 0.01)] {
        for pane in [glass, sheet, material(MaterialKind::Void)] {
            // Shadow rays pass more panes than a path may bounce.
            for (panes, bounces) in [(1, 6), (3, 6), (1, 1), (3, 2)] {
                let lit = |panes: u32, to: &dyn Fn(&mut Scene)| {
                    let mut scene = scene(4096, bounces);
                    floor(&mut scene, metal(roughness));
                    for k in 0..panes {
                        let of = scene.material(pane);
                        let corner = Vec3::new(-9.0, -8.0, 0.2 + 0.1 * k as f32);
                        scene.rectangle(of, corner, Vec3::X * 17.3, Vec3::Y * 17.1);
                    }
                    to(&mut scene);
                    seen(&scene)
                };
                let with_sky = |scene: &mut Scene| scene.lights.push(sky(Vec3::Z, 1.5));
                let with_lamp = |scene: &mut Scene| scene.lamp(lamp(0.6, Vec3::new(0.1, 0.2, 1.0)));
                for to in [&with_sky as &dyn Fn(&mut Scene), &with_lamp] {
                    let (found, exact) = (lit(panes, to), lit(0, to));
                    let error = (found / exact - 1.0).abs();
                    assert!(error < bound, "{roughness} {panes} of {}: {found} {exact}", pane.kind);
                }
            }
        }
    }
}

#[test]
fn a_distant_glow_is_seen_and_lights_nothing() {
    let mut glow = sky(Vec3::Z, 1.0);
    glow.reach = 0.0;
    let mut dark = scene(16, 4);
    floor(&mut dark, matt(0.5));
    dark.lights.push(glow);
    assert_eq!(seen(&dark), 0.0);
    // What reflects sees all of it, as of one that is sampled as well.
    for roughness in [0.0, 0.1, 0.3] {
        let lit = |light: Light| {
            let mut scene = scene(4096, 4);
            floor(&mut scene, metal(roughness));
            scene.lights.push(light);
            seen(&scene)
        };
        let (found, exact) = (lit(glow), lit(sky(Vec3::Z, 1.0)));
        assert!((found / exact - 1.0).abs() < 0.01, "{roughness}: {found} {exact}");
    }
}

#[test]
fn a_camera_sees_no_sky_behind_its_aft_plane() {
    let mut scene = scene(1, 0);
    scene.lights.push(sky(Vec3::Z, 3.0));
    let ray = Ray { direction: Vec3::Z, ..down(0.0, 0.0) };
    assert_eq!(scene.seen(&ray, 0).0, Vec3::ONE);
    assert_eq!(scene.seen(&Ray { t_max: 5.0, ..ray }, 0).0, Vec3::ZERO);
    // Nor through what it sees before it.
    for kind in [MaterialKind::Glass, MaterialKind::Void, MaterialKind::Dielectric] {
        let mut scene = self::scene(1, 4);
        scene.lights.push(sky(Vec3::Z, 3.0));
        let pane = scene.material(Material { ior: 1.0, transmit: [1.0; 3], ..material(kind) });
        scene.rectangle(pane, Vec3::new(-9.0, -8.0, 3.0), Vec3::X * 17.3, Vec3::Y * 17.1);
        let seen = |t_max| scene.seen(&Ray { t_max, ..ray }, 1).0.x;
        assert!((seen(f32::INFINITY) - 1.0).abs() < 1e-5);
        assert_eq!(seen(5.0), 0.0);
    }
}

/// Lamps whose first corner is their sharp one.
#[test]
fn thin_triangles_count_once() {
    let corners =
        [Vec3::new(-0.5, 0.2, 0.7), Vec3::new(0.5, 0.2, 0.7), Vec3::new(0.5, 0.2005, 0.7)];
    let lit = |first: usize| {
        let [a, b, c] = [0, 1, 2].map(|k| corners[(first + k) % 3]);
        let mut scene = scene(4096, 2);
        floor(&mut scene, metal(0.15));
        scene.lamp(light(LightKind::Triangle, a, c - a, b - a, 1000.0));
        seen(&scene)
    };
    let [a, b, c] = [0, 1, 2].map(lit);
    assert!(a > 0.01 && (a / b - 1.0).abs() < 0.02 && (b / c - 1.0).abs() < 0.02, "{a} {b} {c}");
}

/// An illum stands for what is behind it: its pane, and a sky that is seen alone.
#[test]
fn what_an_illum_stands_for_is_not_seen_in_gloss_as_well() {
    let (corner, u, v) = (Vec3::new(-30.0, 30.0, 3.0), Vec3::X * 60.0, Vec3::Y * -60.0);
    let lit = |is_lamp: bool| {
        let mut scene = scene(4096, 4);
        floor(&mut scene, metal(0.2));
        let window = light(LightKind::Parallelogram, corner, u, v, 1.0);
        if is_lamp {
            scene.lamp(window);
        } else {
            let glass = Material { ior: 1.0, transmit: [1.0; 3], ..material(MaterialKind::Glass) };
            let pane = scene.material(Material { light: 1, ..glass });
            scene.rectangle(pane, corner, u, v);
            scene.lights.push(Light { material: pane.into(), ..window });
            scene.lights.push(Light { reach: 0.0, ..sky(Vec3::Z, 1.5) });
        }
        seen(&scene)
    };
    let (found, exact) = (lit(false), lit(true));
    assert!((found / exact - 1.0).abs() < 0.02, "{found} {exact}");
}

/// The inside of a ball of a lamp's material is no lamp: rays alone find it.
#[test]
fn what_is_of_a_lamps_material_and_no_lamp_brings_all_its_light() {
    let mut scene = scene(4096, 2);
    floor(&mut scene, metal(0.2));
    scene.lamp(light(LightKind::Sphere, Vec3::Z * -9.0, Vec3::X, Vec3::ZERO, 10.0));
    let lamp = (scene.materials.len() - 1) as u16;
    let corner = Vec3::new(-30.0, 30.0, 3.0);
    scene.rectangle(lamp, corner, Vec3::X * 60.0, Vec3::Y * -60.0);
    let found = seen(&scene);
    assert!((found / 10.0 - 1.0).abs() < 0.08, "{found}");
}

/// Radiance's formula for the direction of light that passes rough `trans`: the part within an angle of the straight way on.
#[test]
fn the_roughness_of_what_passes_is_that_of_its_direction() {
    for alpha in [0.05, 0.1, 0.2] {
        for degrees in [5.0_f32, 10.0] {
            let half = degrees.to_radians();
            let mut scene = scene(4096, 2);
            let trans = Material { transmit: [1.0; 3], transmit_specular: 1.0, ..metal(alpha) };
            floor(&mut scene, Material { specular: [0.0; 3], ..trans });
            // From above, and aslant: the way on is as straight.
            for slant in [0.0_f32, 0.8, 1.2] {
                let direction = Vec3::new(slant.sin(), 0.0, -slant.cos());
                scene.lights = vec![sky(direction, half)];
                let ray = Ray { origin: -direction, direction, t_min: 0.0, t_max: f32::INFINITY };
                let found = f64::from(scene.seen(&ray, 1).0.x);
                let chord = 2.0 * (f64::from(half) / 2.0).sin() / f64::from(alpha);
                let exact = 1.0 - (-chord * chord).exp();
                let error = (found / exact - 1.0).abs();
                assert!(error < 0.02, "{alpha} {degrees} {slant}: {found} {exact}");
            }
        }
    }
}
