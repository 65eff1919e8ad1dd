use glam::DVec3;
use kiloray_core::scene::{LightKind, MaterialKind, Needs};

use crate::compile::{CompileError, Compiled, Dark, Options, compile};
use crate::kilo::KiloFile;
use crate::model::{Light, Material, Model, NO_NORMAL, Triangle};

/// A square of two triangles for each material, side by side in the plane z = 0.
fn squares(materials: Vec<Material>) -> Model {
    let mut model = Model::default();
    for (i, material) in materials.into_iter().enumerate() {
        let corner = DVec3::new(2.0 * i as f64, 0.0, 0.0);
        square(&mut model, corner, DVec3::X, DVec3::Y, i as u16);
        model.materials.push(material);
    }
    model
}

fn square(model: &mut Model, corner: DVec3, u: DVec3, v: DVec3, material: u16) {
    let first = model.vertices.len() as u32;
    model.vertices.extend([corner, corner + u, corner + u + v, corner + v]);
    for vertices in [[first, first + 1, first + 2], [first, first + 2, first + 3]] {
        model.triangles.push(Triangle { vertices, normals: [NO_NORMAL; 3], material });
    }
}

fn light(kind: LightKind, position: DVec3, u: DVec3, v: DVec3) -> Light {
    Light {
        kind,
        material: None,
        reach: f64::INFINITY,
        position,
        u,
        v,
        radiance: DVec3::ONE,
        cone: None,
    }
}

fn compiled(model: &Model) -> Compiled {
    compile(model, &Options::default(), &mut ()).unwrap()
}

fn bits(material: Material) -> u32 {
    compiled(&squares(vec![material])).summary.needs.bits
}

#[test]
fn each_material_asks_for_what_it_uses() {
    let plain = Material::default();
    let kind = |kind| Material { kind, ..Material::default() };
    let half = DVec3::splat(0.5);
    assert_eq!(bits(plain.clone()), 0);
    let metal = Material { specular: half, roughness: 0.1, ..plain.clone() };
    assert_eq!(bits(metal.clone()), Needs::SPECULAR | Needs::GLOSSY);
    assert_eq!(bits(Material { roughness: 0.0, ..metal }), Needs::SPECULAR);
    assert_eq!(bits(kind(MaterialKind::Mirror)), Needs::SPECULAR);
    let dielectric = bits(kind(MaterialKind::Dielectric));
    assert_eq!(dielectric, Needs::SPECULAR | Needs::DIELECTRIC);
    let glass = Material { transmit: half, ..kind(MaterialKind::Glass) };
    assert_eq!(bits(glass), Needs::SPECULAR | Needs::TRANSPARENT);
    let trans = Material { transmit: half, transmit_specular: 1.0, ..plain };
    assert_eq!(bits(trans), Needs::SPECULAR | Needs::TRANSPARENT);
}

#[test]
fn what_nothing_uses_is_left_out_and_counted() {
    let mut model = squares(vec![Material::default(), Material::default()]);
    let spare = Material { kind: MaterialKind::Mirror, ..Material::default() };
    model.materials.insert(0, spare);
    for triangle in &mut model.triangles {
        triangle.material += 1;
    }
    let compiled = compiled(&model);
    assert_eq!((compiled.summary.materials, compiled.summary.materials_unused), (2, 1));
    assert_eq!(compiled.summary.needs.bits, 0);
    let text = compiled.summary.to_string();
    assert!(text.contains("1 unused ones left out"), "{text}");
    assert!(text.contains("needs     nothing"), "{text}");
}

#[test]
fn surfaces_of_void_are_left_out() {
    let void = Material { kind: MaterialKind::Void, ..Material::default() };
    let compiled = compiled(&squares(vec![Material::default(), void]));
    let stats = &compiled.stats;
    assert_eq!((stats.triangles, stats.void, stats.dropped), (2, 2, 0));
    assert_eq!(compiled.summary.materials, 1);
}

#[test]
fn lights_that_light_nothing_are_left_out() {
    let mut model = squares(vec![Material::default()]);
    let z = DVec3::Z;
    let up = light(LightKind::Parallelogram, z, DVec3::X, DVec3::Y);
    let down = light(LightKind::Parallelogram, z, DVec3::Y, DVec3::X);
    let far = Light { reach: 0.5, ..light(LightKind::Point, z * 3.0, DVec3::ZERO, DVec3::ZERO) };
    let near = Light { reach: 3.5, ..far };
    let off = Light { radiance: DVec3::ZERO, ..near };
    let narrow = DVec3::new(0.99, 0.0, 0.0);
    let away = light(LightKind::Spot, z * 9.0, z, narrow);
    let towards = light(LightKind::Spot, z * 9.0, -z, narrow);
    let flat = light(LightKind::Triangle, z, DVec3::X, DVec3::X * 2.0);
    model.lights = vec![up, down, far, near, off, away, towards, flat];
    // Only those that light something count.
    let limited =
        |lights_max| compile(&model, &Options { lights_max, ..Options::blocks_of(1024) }, &mut ());
    let error = limited(2).unwrap_err();
    assert_eq!(error, CompileError::Lights { count: 3, limit: 2 });
    let compiled = limited(3).unwrap();
    let dark: Vec<_> = compiled.summary.lights_dark.clone().into_iter().collect();
    assert_eq!(dark, [(Dark::Off, 2), (Dark::FacesAway, 2), (Dark::TooFar, 1)]);
    let file = KiloFile::from_compiled(compiled);
    let kinds: Vec<_> = file.view().lights().iter().map(|l| LightKind::from_u32(l.kind)).collect();
    let kept = [LightKind::Parallelogram, LightKind::Point, LightKind::Spot];
    assert_eq!(kinds, kept.map(Some));
}

#[test]
fn a_light_in_the_plane_of_a_wall_shines_into_the_room() {
    // The lamp is the topmost surface: the scene's box ends at its plane.
    let mut model = squares(vec![Material::default()]);
    let (u, v) = (DVec3::Y, DVec3::X);
    square(&mut model, DVec3::Z * 2.0, u, v, 0);
    model.lights = vec![
        light(LightKind::Parallelogram, DVec3::Z * 2.0, u, v),
        light(LightKind::Parallelogram, DVec3::Z * 2.0, v, u),
    ];
    let dark: Vec<_> = compiled(&model).summary.lights_dark.into_iter().collect();
    assert_eq!(dark, [(Dark::FacesAway, 1)]);
}

#[test]
fn each_lamp_gets_a_material_of_its_own() {
    let lamp = Material { kind: MaterialKind::Light, emission: DVec3::ONE, ..Material::default() };
    let mut model = squares(vec![Material::default(), lamp]);
    for i in 0..3 {
        let corner = DVec3::new(f64::from(i) * 0.7, 0.0, 2.0);
        square(&mut model, corner, DVec3::Y * 0.5, DVec3::X * 0.5, 1);
        let kind = LightKind::Parallelogram;
        let mut of_lamp = light(kind, corner, DVec3::Y * 0.5, DVec3::X * 0.5);
        of_lamp.material = Some(1);
        model.lights.push(of_lamp);
    }
    // The square in the plane z = 0 shines as well, but no light stands for it.
    let shared = compiled(&model);
    assert_eq!(shared.summary.materials, 2);
    model.triangles.retain(|t| t.material == 0 || t.vertices[0] >= 8);
    let file = KiloFile::from_compiled(compiled(&model));
    let view = file.view();
    assert_eq!(view.materials().len(), 4);
    for (i, light) in view.lights().iter().enumerate() {
        assert_eq!(light.material as usize, i + 1);
        assert_eq!(view.materials()[i + 1].light as usize, i + 1);
    }
    let block = view.trusted_block(0).unwrap();
    let mut materials: Vec<_> = block.records().iter().map(|r| r.material).collect();
    materials.sort_unstable();
    assert_eq!(materials, [0, 1, 2, 3]);
}

#[test]
fn the_brightest_radiance_is_that_of_a_surface_or_near_a_point() {
    let lamp = Material { emission: DVec3::new(1.0, 7.0, 2.0), ..Material::default() };
    let mut model = squares(vec![lamp]);
    assert_eq!(compiled(&model).summary.needs.radiance_max, 7.0);
    // A square of size 1 is scaled by 2: at 4 above it, a point is 8 away and 4 times as intense.
    let mut point = light(LightKind::Point, DVec3::new(0.5, 0.5, 4.0), DVec3::ZERO, DVec3::ZERO);
    point.radiance = DVec3::splat(16.0 * 100.0 * std::f64::consts::PI);
    model.lights = vec![point];
    let brightest = compiled(&model).summary.needs.radiance_max;
    assert!((brightest - 100.0).abs() < 1e-3, "{brightest}");
}
