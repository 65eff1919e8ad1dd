//! White furnaces: in an even light nothing may be brighter than it, and what reflects all of it cannot be seen.

use super::*;

/// A sky of radiance 1 all around.
fn furnace(samples: u32, bounces: u8) -> Scene {
    let mut scene = Scene {
        settings: Settings { samples, shadow_samples: 0, bounces, seed: 3, ..Settings::default() },
        ..Scene::default()
    };
    let sky = light(LightKind::Distant, Vec3::ZERO, Vec3::Y, Vec3::new(-1.0, 2.0, 0.0), 1.0);
    scene.lights.push(sky);
    scene
}

/// A ray to the origin, from above, at an angle to the z axis.
fn slanted(theta: f32) -> Ray {
    let (sin, cos) = libm::sincosf(theta);
    let out = Vec3::new(sin * 0.6, sin * 0.8, cos);
    Ray { origin: out, direction: -out, t_min: 0.0, t_max: f32::INFINITY }
}

#[test]
fn a_diffuse_surface_reflects_its_part_exactly() {
    for reflectance in [0.0, 0.18, 1.0] {
        let mut scene = furnace(4, 0);
        floor(&mut scene, matt(reflectance));
        let (seen, _) = scene.seen(&slanted(0.7), 0);
        // The hemisphere is sampled by its cosine: every sample brings the same.
        assert!((seen - Vec3::splat(reflectance)).abs().max_element() < 1e-6, "{seen}");
    }
}

#[test]
fn a_diffuse_sheet_splits_light_between_its_sides() {
    let mut scene = furnace(16, 0);
    floor(&mut scene, Material { transmit: [0.3, 0.5, 0.0], ..matt(0.5) });
    let (seen, _) = scene.seen(&slanted(0.2), 0);
    assert!((seen - Vec3::new(0.8, 1.0, 0.5)).abs().max_element() < 1e-5, "{seen}");
}

#[test]
fn a_small_sky_is_a_form_factor() {
    // A cap of half angle a round the normal brings sin² a; one of 90° at the horizon half of it all.
    for (axis, cos, expected) in [
        (Vec3::Z, 0.9_f32, 1.0 - 0.81_f32),
        (Vec3::Z, 0.25, 1.0 - 0.0625),
        (Vec3::Y, 0.0, 0.5),
        (Vec3::new(0.6, 0.0, 0.8), 0.999, 0.8 * (1.0 - 0.999 * 0.999)),
    ] {
        let mut scene = furnace(256, 0);
        scene.lights[0].u = axis.into();
        scene.lights[0].v = [cos, 0.0, 0.0];
        floor(&mut scene, matt(1.0));
        let (seen, _) = scene.seen(&slanted(0.5), 1);
        assert!((seen.x / expected - 1.0).abs() < 4e-3, "{axis} {cos}: {} {expected}", seen.x);
    }
}

#[cfg(feature = "specular")]
mod specular {
    use super::*;
    use crate::material::Ward;
    use crate::random::Sequence;

    #[test]
    fn what_keeps_all_light_cannot_be_seen() {
        let clear = Material { transmit: [1.0; 3], ..material(MaterialKind::Glass) };
        let mirror = Material { specular: [1.0; 3], ..material(MaterialKind::Mirror) };
        for theta in [0.0, 0.6, 1.4] {
            for of in [clear, mirror] {
                let mut scene = furnace(64, 8);
                floor(&mut scene, of);
                let (seen, _) = scene.seen(&slanted(theta), 5);
                assert!((seen - Vec3::ONE).abs().max_element() < 1e-3, "{of:?} {theta}: {seen}");
            }
        }
    }

    /// They lose what goes round inside longer than the path may be.
    #[cfg(feature = "sphere")]
    #[test]
    fn glass_balls_cannot_be_seen() {
        for offset in [0.0, 0.3, 0.45] {
            let mut scene = furnace(4096, 40);
            let ball = scene.material(material(MaterialKind::Dielectric));
            scene.sphere(ball, Vec3::ZERO, 0.5);
            let ray = Ray { origin: Vec3::new(offset, 0.0, 3.0), ..down(0.0, 0.0) };
            let (seen, _) = scene.seen(&ray, 5);
            assert!((seen.x - 1.0).abs() < 0.01, "{offset}: {seen}");
        }
    }

    /// Light sampling and glossy rays share the sky: together they bring the lobe's albedo, whatever the path may do.
    #[test]
    fn glossy_surfaces_bring_their_albedo_and_no_more() {
        for (roughness, theta) in [(0.02, 0.3), (0.15, 0.9), (0.15, 1.4), (0.6, 0.5)] {
            for bounces in [0, 3] {
                let mut scene = furnace(4096, bounces);
                let specular = [0.9, 0.04, 0.01];
                floor(&mut scene, Material { specular, roughness, ..matt(0.05) });
                let ray = slanted(theta);
                let (seen, _) = scene.seen(&ray, 5);
                let ward = Ward { normal: Vec3::Z, alpha: roughness };
                let n = 1 << 14;
                let albedo = (0..n)
                    .filter_map(|k| ward.sample(Sequence::from_seed(9).point(k), -ray.direction))
                    .map(|(_, weight)| weight)
                    .sum::<f32>()
                    / n as f32;
                for (seen, part) in seen.to_array().into_iter().zip(specular) {
                    let expected = 0.05 + part * albedo;
                    let noise = if roughness < 0.1 && bounces == 0 { 0.4 } else { 0.01 };
                    assert!(
                        (seen / expected - 1.0).abs() < noise,
                        "roughness {roughness} theta {theta} bounces {bounces}: {seen} {expected}"
                    );
                }
            }
        }
    }
}
