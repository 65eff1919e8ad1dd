//! A few of the random runs of `nothing_lost`; its command runs as many as there is time for.

use kiloray_tests::nothing_lost::{Scenes, all};

#[test]
fn every_run_ends_with_the_same_bits_or_names_a_lost_block() {
    let scenes = Scenes::new().unwrap();
    if let Err(failure) = all(&scenes, 1, 0..200, 2, &|| ()) {
        panic!("{failure}");
    }
}

/// Few tiles, the first of which waited for three dead nodes of a slow machine: what else they took with them is given again in time.
#[test]
fn few_tiles_of_a_slow_machine_are_given_again_in_time() {
    let scenes = Scenes::new().unwrap();
    if let Err(failure) = all(&scenes, 1, 8481..8482, 1, &|| ()) {
        panic!("{failure}");
    }
}

/// Lines of 8 and 14 nodes that lose many packets, of a slow machine: three of 30,000 that took longer than they may, where all time limits were long,
/// and a tile was missed whenever its sub-master or the host gave two answers to one request.
#[test]
fn what_is_lost_is_asked_for_in_time() {
    let scenes = Scenes::new().unwrap();
    for (seed, run) in [(33, 1066), (34, 5395), (35, 8077)] {
        if let Err(failure) = all(&scenes, seed, run..run + 1, 1, &|| ()) {
            panic!("{failure}");
        }
    }
}

/// The last of three nodes, with the least memory: it asked the dead for a block again and again, and never had room to say that the block is lost.
#[test]
fn that_a_block_is_lost_is_told_before_it_is_asked_for_again() {
    let scenes = Scenes::new().unwrap();
    if let Err(failure) = all(&scenes, 48, 3930..3931, 1, &|| ()) {
        panic!("{failure}");
    }
}
