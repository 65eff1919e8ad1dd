//! Shadow rays in lanes are those that are made one by one, to the bit: of all kinds of lights, materials and media.

use bytemuck::Zeroable;
use glam::Vec3;
use kiloray_core::geometry::{Hit, Primitive, Ray};
use kiloray_core::path::PathKey;
use kiloray_core::scene::{Light, LightKind, Material, MaterialKind, Needs};
use kiloray_core::shade::{
    Bundle, Counts, FewRays, LightRows, Memo, Path, Point, Settings, Shader, ShadowRays, Tables,
};
use kiloray_core::trace::{Scalar, Tracer};
use proptest::prelude::*;

use crate::Auto;

/// What is lit, and by what.
#[derive(Debug, Clone)]
struct Case {
    settings: Settings,
    material: Material,
    normals: Option<[u32; 3]>,
    lights: Vec<Light>,
    medium: bool,
    scale: f32,
    sample: u32,
}

fn vector(size: f32) -> impl Strategy<Value = [f32; 3]> {
    prop::array::uniform3(-size..size)
}

fn parts() -> impl Strategy<Value = [f32; 3]> {
    prop_oneof![Just([0.0; 3]), prop::array::uniform3(0f32..1.0)]
}

fn lights(scale: f32) -> impl Strategy<Value = Light> {
    let kinds = [
        LightKind::Parallelogram,
        LightKind::Triangle,
        LightKind::Disc,
        LightKind::Sphere,
        LightKind::Point,
        LightKind::Spot,
        LightKind::Distant,
    ];
    let turned = prop_oneof![Just(-1f32), -1f32..1.0];
    (
        prop::sample::select(kinds.to_vec()),
        (vector(2.0), vector(1.5), vector(1.5), vector(1.0)),
        prop::array::uniform3(0.01f32..10.0),
        turned,
        prop_oneof![Just(0f32), 0f32..2.0],
        any::<bool>(),
    )
        .prop_map(move |(kind, (position, u, v, cone), radiance, cone_cos, focus, square)| {
            let [position, u, v, cone] = [position, u, v, cone].map(Vec3::from);
            // Edges at right angles are sampled otherwise than others.
            let v = if square || kind == LightKind::Disc { u.cross(v) } else { v };
            let unit = |v: Vec3| v.try_normalize().unwrap_or(Vec3::Z);
            let (u, v) = match kind {
                LightKind::Sphere => (Vec3::X * u.length(), Vec3::ZERO),
                LightKind::Spot => (unit(u), Vec3::X * cone_cos),
                // Its cosine, or what is left of it to 1.
                LightKind::Distant if square => (unit(u), Vec3::X * cone_cos),
                LightKind::Distant => (unit(u), Vec3::Y * 1e-5),
                LightKind::Disc => (u, unit(v) * u.length()),
                _ => (u, v),
            };
            let size = match kind {
                LightKind::Spot | LightKind::Distant => 1.0,
                _ => scale,
            };
            Light {
                kind: kind as u32,
                material: if square { 1 } else { u32::MAX },
                reach: f32::INFINITY,
                position: (position * scale).into(),
                u: (u * size).into(),
                v: (v * size).into(),
                radiance,
                cone_cos,
                cone: unit(cone).into(),
                focus: focus * scale,
            }
        })
}

fn cases() -> impl Strategy<Value = Case> {
    let scale = prop::sample::select(vec![1.0f32, 1e-6, 1e6]);
    scale.prop_flat_map(|scale| {
        let material = (parts(), parts(), parts(), prop_oneof![Just(0f32), 0f32..0.5], 0f32..1.0)
            .prop_map(|(diffuse, specular, transmit, roughness, transmit_specular)| Material {
                kind: MaterialKind::Opaque as u32,
                roughness,
                diffuse,
                specular,
                transmit,
                transmit_specular,
                ..Material::zeroed()
            });
        let settings = (0_u16..=64, 1_u16..4, 1_u32..64, any::<u64>()).prop_map(
            |(shadow_samples, lights, samples, seed)| Settings {
                samples,
                shadow_samples,
                lights,
                bounces: 8,
                seed,
            },
        );
        // Few are looked at closely at once, of many the first ones together.
        let count = prop_oneof![6 => 1_usize..4, 3 => 5_usize..20, 1 => 63_usize..67];
        let lights = count.prop_flat_map(move |count| prop::collection::vec(lights(scale), count));
        ((settings, material, any::<Option<[u32; 3]>>()), (lights, any::<bool>(), 0_u32..64))
            .prop_map(move |((settings, material, normals), (lights, medium, sample))| Case {
                settings,
                material,
                normals,
                lights,
                medium,
                scale,
                sample,
            })
    })
}

impl Case {
    /// The point of a floor, and all bundles of its light sampling.
    fn bundles<T: Tracer>(&self, tracer: T, shader: &Shader<'_>) -> Option<(Point, Vec<Bundle>)> {
        let corners = [Vec3::ZERO, Vec3::X, Vec3::Y].map(|v| v * self.scale);
        let primitive = Primitive::Triangle { vertices: corners, normals: self.normals };
        let hit = Hit { t: self.scale, b1: 0.3, b2: 0.4, material: 0, primitive, block: 0 };
        let origin = Vec3::new(0.3, 0.4, 1.0) * self.scale;
        let ray = Ray { origin, direction: Vec3::NEG_Z, t_min: 0.0, t_max: f32::INFINITY };
        let key = PathKey::camera(self.settings.seed, 5, self.sample);
        let medium = if self.medium { 1 } else { Path::AIR };
        let path = Path { medium, ..Path::camera(key) };
        let (_, point) = shader.arrive(&path, &ray, Some(&hit));
        let point = point?;
        let (mut memo, mut counts) = (Memo::new(), Counts::default());
        let mut direct = shader.direct(tracer, &point, &mut memo);
        let next = || shader.next_bundle(tracer, &point, &mut direct, &memo, &mut counts);
        Some((point, std::iter::from_fn(next).collect()))
    }
}

/// How many rays there were.
fn agree(case: &Case, tracer: Auto) -> Result<usize, TestCaseError> {
    let medium = Material {
        kind: MaterialKind::Dielectric as u32,
        ior: 1.5,
        absorption: [0.0, 0.3 / case.scale, 5.0 / case.scale],
        emission: [1.0; 3],
        ..Material::zeroed()
    };
    let materials = [case.material, medium];
    let needs =
        Needs { bits: Needs::SPECULAR | Needs::GLOSSY | Needs::DISTANT, radiance_max: 10.0 };
    let tables = Tables::new(&materials, &case.lights, needs);
    let rows = LightRows::new(&case.lights);
    let shader = Shader::new(tables, case.settings);
    let mut rays = 0;
    let Some((point, bundles)) = case.bundles(tracer, &shader.with_rows(&rows)) else {
        return Ok(0);
    };
    let single = case.bundles(Scalar, &shader);
    prop_assert_eq!(&single, &Some((point, bundles.clone())), "{}", tracer.name());
    for mut bundle in bundles {
        let mut single = bundle;
        let mut together = ShadowRays::NONE;
        // Some have been made before: what follows begins anywhere.
        let mut j = (rays as u32 % 5).min(bundle.len);
        for i in 0..j {
            let made = shader.shadow_ray(&point, &mut bundle, i);
            prop_assert_eq!(made, shader.shadow_ray(&point, &mut single, i));
        }
        while j < bundle.len {
            shader.shadow_rays(tracer, &point, &mut bundle, j, &mut together);
            let mut lit = together.lit();
            for at in 0..together.len() {
                let here = together.next(at).filter(|(place, _)| *place == at);
                let ray = here.map(|(_, ray)| *ray);
                if ray.is_some() {
                    prop_assert_eq!(lit.next().copied(), ray);
                }
                let exact = shader.shadow_ray(&point, &mut single, j + at);
                prop_assert_eq!(
                    format!("{:?}", ray),
                    format!("{:?}", exact),
                    "{}: {}",
                    tracer.name(),
                    j + at
                );
                rays += usize::from(exact.is_some());
            }
            prop_assert!(lit.next().is_none());
            prop_assert_eq!(together.dark(), together.len() - together.lit().count() as u32);
            j += together.len();
        }
        prop_assert_eq!(bundle, single);
    }
    Ok(rays)
}

/// Bundles of few rays, of which some go together. How many rays did.
fn few_agree(cases: &[Case], tracer: Auto) -> Result<usize, TestCaseError> {
    let mut few = FewRays::new();
    let (mut rays, mut expected, mut together) = (ShadowRays::NONE, Vec::new(), 0);
    let check = |few: &mut FewRays, rays: &mut ShadowRays, expected: &mut Vec<_>| {
        few.make(tracer, rays);
        prop_assert_eq!(rays.len() as usize, expected.len());
        for (lane, exact) in (0..).zip(expected.drain(..)) {
            let made = rays.next(lane).filter(|(place, _)| *place == lane).map(|(_, ray)| *ray);
            let owner = few.owner(lane);
            prop_assert_eq!(format!("{:?}", (owner, made)), exact, "{}", tracer.name());
        }
        few.clear();
        Ok(())
    };
    for (case, pixel) in cases.iter().zip(0_u16..) {
        let medium = Material { kind: MaterialKind::Dielectric as u32, ..Material::zeroed() };
        let materials = [case.material, medium];
        let needs =
            Needs { bits: Needs::SPECULAR | Needs::GLOSSY | Needs::DISTANT, radiance_max: 10.0 };
        let tables = Tables::new(&materials, &case.lights, needs);
        let rows = LightRows::new(&case.lights);
        let shader = Shader::new(tables, case.settings);
        let bundles = case.bundles(tracer, &shader.with_rows(&rows));
        let Some((point, bundles)) = bundles else { continue };
        for mut bundle in bundles {
            if few.are_in_the_way_of(&bundle) {
                check(&mut few, &mut rays, &mut expected)?;
            }
            if !few.put(&point, &bundle, pixel) {
                continue;
            }
            for j in 0..bundle.len {
                let exact = shader.shadow_ray(&point, &mut bundle, j);
                together += usize::from(exact.is_some());
                expected.push(format!("{:?}", ((bundle.light, pixel), exact)));
            }
        }
    }
    check(&mut few, &mut rays, &mut expected)?;
    Ok(together)
}

#[test]
fn few_rays_of_many_points_are_those_made_one_by_one() {
    let mut runner = proptest::test_runner::TestRunner::new(ProptestConfig::with_cases(1500));
    let rays = std::cell::Cell::new(0);
    // One ray, or two that share a known light, of lights that mostly look small and surfaces that mostly reflect diffusely.
    let plain = (cases(), 0..4, 1_u16..8).prop_map(|(mut case, kind, samples)| {
        case.settings.shadow_samples = samples;
        if kind > 0 {
            for light in &mut case.lights {
                light.kind = if kind > 1 { light.kind % 2 } else { light.kind };
                light.position[2] = light.position[2].abs();
                let area = [0, 1].contains(&light.kind);
                let size = if area { 0.02 * samples as f32 } else { 1.0 };
                (light.u, light.v) = (light.u.map(|x| x * size), light.v.map(|x| x * size));
                if area {
                    (light.cone_cos, light.focus) = (-1.0, 0.0);
                }
            }
            case.material = Material {
                kind: MaterialKind::Opaque as u32,
                diffuse: case.material.diffuse,
                ..Material::zeroed()
            };
            (case.normals, case.medium) = (None, false);
        }
        case
    });
    runner
        .run(&prop::collection::vec(plain, 1..12), |cases| {
            for tracer in Auto::all() {
                rays.set(rays.get() + few_agree(&cases, tracer)?);
            }
            Ok(())
        })
        .unwrap();
    assert!(rays.get() > 2000, "{}", rays.get());
}

#[test]
fn rays_made_in_lanes_are_those_made_one_by_one() {
    let mut runner = proptest::test_runner::TestRunner::new(ProptestConfig::with_cases(1500));
    let rays = std::cell::Cell::new(0);
    runner
        .run(&cases(), |case| {
            for tracer in Auto::all() {
                rays.set(rays.get() + agree(&case, tracer)?);
            }
            Ok(())
        })
        .unwrap();
    assert!(rays.get() > 20_000, "{}", rays.get());
}
