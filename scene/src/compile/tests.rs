//! What must hold of every compiled scene, read back from its bytes alone.

mod golden;
mod oracle;
mod parallel;
mod random;
mod shapes;
mod tables;

use glam::DVec3;
use oracle::check;

use super::{Options, Stage, compile};
use crate::model::{Material, Model, Sphere, Triangle};

const SIZES: [usize; 7] = [1 << 10, 2 << 10, 4 << 10, 8 << 10, 16 << 10, 32 << 10, 64 << 10];

/// Compiles with every size of blocks and checks each result.
fn check_all(model: &Model) {
    for block_bytes in SIZES {
        let compiled = compile(model, &Options::blocks_of(block_bytes), &mut ()).unwrap();
        check(model, &compiled);
    }
}

#[test]
fn nothing_compiles_to_an_empty_root() {
    let compiled = compile(&Model::default(), &Options::default(), &mut ()).unwrap();
    assert_eq!((compiled.header().blocks, compiled.header().primitives), (1, 0));
    check_all(&Model::default());
}

/// A square of two triangles, and what makes its positions coarse.
#[test]
fn what_lies_far_away_moves_what_is_small() {
    let corner = |x, y| DVec3::new(x, y, 0.3);
    let [a, b, c, d] = [corner(0.1, 0.2), corner(1.1, 0.2), corner(1.1, 1.2), corner(0.1, 1.2)];
    let with_sun = |far: f64, radius: f64| {
        let mut model = shapes::soup(vec![[a, b, c], [a, c, d]]);
        let center = DVec3::new(0.3, -0.3, 1.0) * far;
        model.spheres = vec![Sphere { center, radius, material: 0, inward: false }];
        check_all(&model);
        let compiled = compile(&model, &Options::default(), &mut ()).unwrap();
        let stats = compiled.stats;
        assert!(
            f64::from(compiled.summary.position_error) <= stats.coarse_error || !stats.is_coarse()
        );
        (stats.coarse, stats.is_coarse(), stats.coarse_error)
    };
    assert_eq!(with_sun(1e3, 5.0), (0, false, 0.0));
    let (coarse, is_coarse, error) = with_sun(1e7, 5e4);
    assert!(coarse == 2 && is_coarse && error > 0.1 && error < 1.0, "{coarse} {error}");
    // The sphere, small beside its distance, moves too.
    assert_eq!(with_sun(1e7, 5.0).0, 3);
}

/// Less than one of a hundred is not worth a word.
#[test]
fn a_few_tiny_surfaces_do_not_make_a_scene_coarse() {
    let mut model = shapes::field(30);
    let at = DVec3::new(29.123, 29.321, 9.7);
    let tiny = shapes::soup(vec![[at, at + DVec3::X * 1e-5, at + DVec3::Y * 1e-5]]);
    let first = model.vertices.len() as u32;
    model.vertices.extend(tiny.vertices);
    model.triangles.extend(
        tiny.triangles.into_iter().map(|triangle| Triangle {
            vertices: triangle.vertices.map(|v| v + first),
            ..triangle
        }),
    );
    let stats = compile(&model, &Options::default(), &mut ()).unwrap().stats;
    assert!(stats.coarse == 1 && !stats.is_coarse(), "{}", stats.coarse);
}

#[test]
fn one_triangle_is_one_block() {
    let model = shapes::soup(vec![[DVec3::ZERO, DVec3::X, DVec3::Y]]);
    check_all(&model);
    let compiled = compile(&model, &Options::default(), &mut ()).unwrap();
    assert_eq!(compiled.header().blocks, 1);
    assert_eq!(compiled.stats.nodes, 1);
}

#[test]
fn a_sphere_whose_centre_reads_like_its_radius_survives() {
    let sphere = |x, y, radius, inward| Sphere {
        center: DVec3::new(x, y, 0.0),
        radius,
        material: 0,
        inward,
    };
    let tiny = 2f64.powi(-60);
    // The frame is [-1, 1]: the second centre is what blocks hold of the radius.
    for spheres in [
        vec![sphere(-0.5, 0.0, 0.5, false), sphere(0.5, 0.0, 0.5, false)],
        vec![sphere(0.0, 0.0, 1.0, false), sphere(tiny, 1.0, tiny, true)],
    ] {
        check_all(&Model { spheres, materials: vec![Material::default()], ..Model::default() });
    }
}

#[test]
fn a_height_field_survives() {
    check_all(&shapes::field(60));
}

#[test]
fn blocks_of_like_objects_are_as_full_as_any() {
    for (scene, kib) in [("colour-cube:36", 4), ("colour-cube:36", 16), ("conference:20", 4)] {
        let model = crate::builtin::build(scene).unwrap();
        let stats = compile(&model, &Options::blocks_of(kib << 10), &mut ()).unwrap().stats;
        assert!(stats.fill() >= 0.9, "{scene}, {kib} KiB: {}", stats.fill());
    }
}

#[test]
fn progress_goes_on_and_never_back() {
    for (name, cut_again) in [("studio", false), ("sinc:60", true), ("sphereflake:3", true)] {
        let model = crate::builtin::build(name).unwrap();
        let mut told = Vec::new();
        let mut progress = |stage: Stage, done: u64, total: u64| {
            assert!(done <= total, "{name}: {done} of {total}");
            told.push((stage, done, total));
        };
        compile(&model, &Options::blocks_of(4096), &mut progress).unwrap();
        let order = [Stage::Surfaces, Stage::Tree, Stage::Cut, Stage::Recut, Stage::Blocks];
        let place = |stage| order.iter().position(|&s| s == stage);
        for pair in told.windows(2) {
            let [(stage, done, total), (next, more, of)] = [pair[0], pair[1]];
            let goes_on = stage == next && total == of && done <= more;
            assert!(goes_on || place(stage) < place(next), "{name}: {pair:?}");
        }
        let is_recut = told.iter().any(|t| t.0 == Stage::Recut);
        assert_eq!(is_recut, cut_again, "{name}");
    }
}
