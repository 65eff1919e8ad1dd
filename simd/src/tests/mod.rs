//! The tests of `kiloray-core`'s traversal, with all lanes that this machine has.

/// Something of all eight lanes that this machine has. One without the others never uses them.
macro_rules! of_all {
    (|$lanes:ident| $what:expr) => {
        let $lanes = crate::Portable;
        $what;
        #[cfg(target_arch = "x86_64")]
        if let Some($lanes) = crate::Avx2::detect() {
            $what;
        }
        #[cfg(avx512)]
        if let Some($lanes) = crate::Avx512::detect() {
            $what;
        }
    };
}

// The shared files name their modules as they do in `kiloray-core`.
#[cfg(target_arch = "x86_64")]
mod portable;
mod real;
mod shadows;
#[path = "../../../core/src/trace/tests/shared/mod.rs"]
mod shared;

use kiloray_core::trace::Scalar;
use proptest::prelude::*;
use shared::{agree, bundles, frames, trails};

use crate::Auto;

#[test]
fn every_layout_gives_the_hits_of_brute_force() {
    Auto::all().for_each(agree::layouts_agree);
}

#[test]
fn scenes_far_smaller_and_away_from_the_origin() {
    Auto::all().for_each(agree::scales_agree);
}

#[test]
fn what_is_no_ray_hits_nothing() {
    Auto::all().for_each(agree::no_ray_hits);
}

#[test]
fn slots_enclose_the_intervals_of_own_boxes() {
    of_all!(|lanes| frames::enclose(lanes));
}

#[test]
fn groups_and_beams_enclose_the_intervals_of_own_boxes() {
    of_all!(|lanes| frames::groups_enclose(lanes));
}

#[test]
fn lists_are_selected_from_in_their_order() {
    of_all!(|lanes| frames::lists_select(lanes));
}

#[test]
fn bundles_find_the_hits_of_single_rays() {
    Auto::all().for_each(bundles::agree);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn rays_of_a_bundle_stop_at_missing_blocks_and_go_on(seed: u64, of_256 in 0_u32..=256) {
        Auto::all().for_each(|tracer| bundles::stop_and_go_on(tracer, seed, of_256));
    }

    #[test]
    fn parked_rays_go_on_with_any_lanes(case in trails::cases()) {
        for tracer in Auto::all() {
            trails::agree(&case, tracer, Auto::detect());
            trails::agree(&case, tracer, Scalar);
        }
    }

    #[test]
    fn any_bytes_are_a_harmless_trail(
        case in trails::cases(),
        damage in prop::collection::vec((0_usize..20, any::<u8>()), 0..6),
        bytes in any::<[u8; 20]>(),
    ) {
        Auto::all().for_each(|tracer| trails::hostile(&case, &damage, bytes, tracer));
    }
}
