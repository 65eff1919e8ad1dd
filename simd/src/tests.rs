//! The tests of `kiloray-core`'s traversal, with these lanes.

// The shared files name their modules as they do in `kiloray-core`.
#[path = "../../core/src/trace/tests/mod.rs"]
mod shared;

use kiloray_core::trace::Scalar;
use proptest::prelude::*;
use shared::{agree, bundles, frames, trails};

#[test]
fn every_layout_gives_the_hits_of_brute_force() {
    agree::layouts_agree(crate::Auto::detect());
}

#[test]
fn scenes_far_smaller_and_away_from_the_origin() {
    agree::scales_agree(crate::Auto::detect());
}

#[test]
fn what_is_no_ray_hits_nothing() {
    agree::no_ray_hits(crate::Auto::detect());
}

#[cfg(target_arch = "x86_64")]
#[test]
fn slots_enclose_the_intervals_of_own_boxes() {
    // A machine without these lanes never uses them.
    if let Some(lanes) = crate::Avx2::detect() {
        frames::enclose(lanes);
    }
}

#[test]
fn bundles_find_the_hits_of_single_rays() {
    bundles::agree(crate::Auto::detect());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn rays_of_a_bundle_stop_at_missing_blocks_and_go_on(seed: u64, of_256 in 0_u32..=256) {
        bundles::stop_and_go_on(crate::Auto::detect(), seed, of_256);
    }

    #[test]
    fn parked_rays_find_what_others_find(case in trails::cases()) {
        trails::agree(&case, crate::Auto::detect(), crate::Auto::detect());
    }

    #[test]
    fn parked_rays_go_on_with_other_lanes(case in trails::cases()) {
        trails::agree(&case, crate::Auto::detect(), Scalar);
    }

    #[test]
    fn any_bytes_are_a_harmless_trail(
        case in trails::cases(),
        damage in prop::collection::vec((0_usize..20, any::<u8>()), 0..6),
        bytes in any::<[u8; 20]>(),
    ) {
        trails::hostile(&case, &damage, bytes, crate::Auto::detect());
    }
}
