//! A scene that fits on a sheet of paper.

use glam::DVec3;
use kiloray_core::block::format::{BlockHeader, Child};

use crate::compile::{Options, compile};
use crate::kilo::KiloFile;
use crate::model::{Material, Model, NO_NORMAL, Triangle};

/// A pyramid without a base in each corner of the cube [-8, 8]³: 4 triangles, 5 vertices.
fn pyramids() -> Model {
    let mut model = Model { materials: vec![Material::default()], ..Model::default() };
    for corner in 0..8 {
        let sign = |bit: u32| if corner >> bit & 1 == 1 { 1.0 } else { -1.0 };
        let apex = DVec3::new(sign(2), sign(1), sign(0)) * 8.0;
        let first = model.vertices.len() as u32;
        model.vertices.push(apex);
        for (x, y) in [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)] {
            // Towards the middle.
            let to = DVec3::new(x, y, 1.0) * apex.signum();
            model.vertices.push(apex - to);
        }
        for i in 0..4 {
            let vertices = [first, first + 1 + i, first + 1 + (i + 1) % 4];
            model.triangles.push(Triangle { vertices, normals: [NO_NORMAL; 3], material: 0 });
        }
    }
    model
}

#[test]
fn eight_pyramids_are_eight_full_records_of_one_node() {
    let compiled = compile(&pyramids(), &Options::blocks_of(1024), &mut ()).unwrap();
    let stats = &compiled.stats;
    assert_eq!((stats.triangles, stats.blocks, stats.nodes, stats.records), (32, 1, 1, 8));
    assert_eq!((stats.vertices, stats.refs, stats.depth, stats.nesting), (40, 0, 1, 1));
    // Header, vertices, records, node; the records begin at a multiple of 16.
    assert_eq!(stats.used_bytes, 64 + 40 * 12 + 8 * 16 + 128);
    // Every line through the cube meets the root; each pyramid's box is 1 x 1 x 1 of 16³.
    assert!((stats.expected_nodes - 1.0).abs() < 1e-6);
    assert!((stats.expected_records - 8.0 / 256.0).abs() < 1e-6);

    let file = KiloFile::from_compiled(compiled);
    let view = file.view();
    let header = view.header();
    assert_eq!((header.frame.center, header.frame.exponent), ([0.0; 3], 3));
    assert_eq!((header.lo, header.hi, header.primitives), ([-1.0; 3], [1.0; 3], 32));
    let block = view.trusted_block(0).unwrap();
    let BlockHeader { origin, scale, height, nesting, .. } = *block.header();
    // 2 / 65535 is a little above 2⁻¹⁵.
    assert_eq!((origin, scale), ([-1.0; 3], [2f32.powi(-14); 3]));
    assert_eq!((height, nesting), (1, 1));
    let node = block.node(0).unwrap();
    // 1 of 16 input units is 2048 of 32768 steps.
    let upper = |slot: usize| {
        let side = |axis: usize| match (node.lo[axis][slot], node.hi[axis][slot]) {
            (0, 2048) => 0,
            (30720, 32768) => 1,
            other => panic!("slot {slot}, axis {axis}: {other:?}"),
        };
        [side(0), side(1), side(2)]
    };
    let mut corners = Vec::new();
    // Behind the header and 40 vertices.
    let records_at = (64 + 40 * 12) / 16;
    for slot in 0..8 {
        assert_eq!(
            Child::decode(node.child[slot]),
            Child::Leaf { at: records_at + slot as u16, count: 1 }
        );
        corners.push(upper(slot));
    }
    corners.sort_unstable();
    corners.dedup();
    assert_eq!(corners.len(), 8);
    // Whatever the axes of the cuts: the corner that the rays come from is first, the opposite one last.
    for (signs, &order) in node.order.iter().enumerate() {
        let near = [signs & 1, signs >> 1 & 1, 0];
        assert_eq!(upper((order & 7) as usize), near);
        assert_eq!(upper((order >> 21 & 7) as usize), near.map(|side| 1 - side));
    }
}

#[test]
fn ever_smaller_triangles_stay_within_the_depth() {
    // Down to 2⁻¹³⁴ of the scene on both sides of its centre: the heuristic alone cuts off the
    // largest few, and again, and again.
    let mut model = Model { materials: vec![Material::default()], ..Model::default() };
    for i in 0..3_000 {
        let size = 0.94f64.powi(i / 2) * if i % 2 == 0 { 1.0 } else { -1.0 };
        let first = model.vertices.len() as u32;
        model.vertices.extend([DVec3::X, DVec3::Y, DVec3::Z].map(|p| p * size));
        let vertices = [first, first + 1, first + 2];
        model.triangles.push(Triangle { vertices, normals: [NO_NORMAL; 3], material: 0 });
    }
    let options = Options::blocks_of(1024);
    let compiled = compile(&model, &options, &mut ()).unwrap();
    super::oracle::check(&model, &compiled);
    assert!(compiled.stats.triangles > 2_900 && compiled.stats.depth <= 32);
}
