use proptest::prelude::*;

use super::shared::scenes::{Random, clutter};
use super::shared::writer::write;
use super::shared::{Resident, Visit, agree, bundles, erased, frames, trails};
use crate::block::BlockView;
use crate::geometry::{PreparedRay, Primitive, Ray};
use crate::trace::{BoxFrame, BoxRay, Cursor, Scalar, Tracer, Visited};

#[test]
fn every_layout_gives_the_hits_of_brute_force() {
    agree::layouts_agree(Scalar);
}

#[test]
fn scenes_far_smaller_and_away_from_the_origin() {
    agree::scales_agree(Scalar);
}

#[test]
fn what_is_no_ray_hits_nothing() {
    agree::no_ray_hits(Scalar);
}

#[test]
fn bundles_find_the_hits_of_single_rays() {
    bundles::agree(Scalar);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn rays_of_a_bundle_stop_at_missing_blocks_and_go_on(seed: u64, of_256 in 0_u32..=256) {
        bundles::stop_and_go_on(Scalar, seed, of_256);
    }
}

#[test]
fn slots_enclose_the_intervals_of_own_boxes() {
    frames::enclose(Scalar);
}

#[test]
fn groups_and_beams_enclose_the_intervals_of_own_boxes() {
    frames::groups_enclose(Scalar);
}

#[test]
fn lists_are_selected_from_in_their_order() {
    frames::lists_select(Scalar);
}

#[test]
fn no_box_decides_anything_for_a_wild_ray() {
    let mut random = Random(5);
    let items = clutter(20, false, &mut random);
    let blocks = write(&items, 1 << 12, 4, 99);
    let mut header = *BlockView::trusted(blocks.get(0).unwrap()).header();
    header.scale = [2.0_f32.powi(-80); 3];
    let ray = Ray {
        origin: glam::Vec3::splat(1e30),
        direction: glam::Vec3::new(1e-20, 1e-20, -1e-20),
        t_min: 0.0,
        t_max: f32::INFINITY,
    };
    let ray = BoxRay::new(&PreparedRay::new(&ray));
    let frame = BoxFrame::new(&ray, &header);
    assert_eq!((frame.near, frame.far), ([f32::NEG_INFINITY; 3], [f32::INFINITY; 3]));
    assert!(frame.inv.iter().all(|i| i.abs() == header.scale[0]));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn parked_rays_find_what_others_find(case in trails::cases()) {
        trails::agree(&case, Scalar, Scalar);
    }

    #[test]
    fn any_bytes_are_a_harmless_trail(
        case in trails::cases(),
        damage in prop::collection::vec((0_usize..20, any::<u8>()), 0..6),
        bytes in any::<[u8; 20]>(),
    ) {
        trails::hostile(&case, &damage, bytes, Scalar);
    }
}

#[test]
fn what_was_visited_is_counted() {
    let mut random = Random(41);
    // A single triangle: one node, one record, one block.
    let items = clutter(1, false, &mut random);
    let blocks = write(&items, 1 << 10, 1, 1);
    let at = match items[0].0 {
        Primitive::Triangle { vertices: [a, b, c], .. } => (a + b + c) / 3.0,
        Primitive::Sphere { center, .. } => center,
    };
    let ray = Ray {
        origin: glam::Vec3::splat(-0.9),
        direction: at + 0.9,
        t_min: 0.0,
        t_max: f32::INFINITY,
    };
    let mut cursor = Cursor::new();
    for rays in 1..4 {
        let visit: Visit<'_> = &mut |_| false;
        Scalar.every(&mut cursor, &mut erased(&mut Resident(&blocks)), &ray, visit).unwrap();
        let visited = cursor.visited();
        assert_eq!([visited.nodes, visited.leaves, visited.blocks], [rays; 3]);
    }
    assert_eq!(cursor.take_visited().nodes, 3);
    assert_eq!(cursor.visited(), Visited::default());
}
