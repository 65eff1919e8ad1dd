//! A word on memories in which so few blocks are at hand that most rays fetch them again.

use std::iter::successors;

use kiloray_core::{block::KiloView, network::NodeId, node::Time};
use kiloray_mesh::{MeshLayout, MeshOptions};
use kiloray_render::Options;

use crate::args::size::typed;

/// So many times the frames below which there is a note are advised.
const ADVISED: usize = 2;
/// The advice is a whole number of these \[bytes\], found in steps of an eighth.
const ROUND: usize = 1 << 10;
const STEPS: usize = 8;

/// Frames of a node, and the blocks that may come into them.
#[derive(Debug, Clone, Copy)]
struct Room {
    frames: usize,
    blocks: usize,
}

/// What is to say of a node that is alone; nothing where it reads blocks in place.
pub(super) fn of_node(file: &KiloView<'_>, options: &Options) -> Option<String> {
    let blocks = file.blocks() as usize;
    let room = |memory| {
        let options = Options { memory: Some(memory), ..*options };
        let plan = kiloray_render::plan(file, &options);
        plan.ok().map(|plan| Room { frames: plan.frames, blocks }).into_iter().collect()
    };
    note(nesting(file), options.memory?, room)
}

/// The same of the nodes of a mesh, which these options divide like this.
pub(super) fn of_mesh(
    file: &KiloView<'_>,
    options: &MeshOptions,
    layout: &MeshLayout,
) -> Option<String> {
    let blocks = file.blocks() as usize;
    let of = |layout: &MeshLayout| -> Vec<_> {
        let nodes = layout.plans.iter().zip(0..);
        let owned = |node| layout.owned(NodeId(node)) as usize;
        nodes
            .map(|(plan, node)| Room { frames: plan.frames, blocks: blocks - owned(node) })
            .collect()
    };
    let rooms = |memory| {
        if memory == options.memory {
            return of(layout);
        }
        let options = MeshOptions { memory, ..*options };
        let other = MeshLayout::new(file, &options, |_| (Time(0), Time(0)));
        other.as_ref().map(of).unwrap_or_default()
    };
    note(nesting(file), options.memory, rooms)
}

/// How many blocks lie within each other, at most: so many a ray goes down through.
fn nesting(file: &KiloView<'_>) -> usize {
    file.trusted_block(0).map_or(0, |root| root.header().nesting.into())
}

/// With fewer frames than blocks lie within each other, a ray that has come to the last has lost the first.
fn note(nesting: usize, memory: usize, rooms: impl Fn(usize) -> Vec<Room>) -> Option<String> {
    let fewest = |memory, enough: usize| {
        let few = |room: &Room| room.frames < room.blocks.min(enough);
        rooms(memory).into_iter().filter(few).map(|room| room.frames).min()
    };
    let frames = fewest(memory, nesting)?;
    let more = |memory: &usize| Some((memory + memory / STEPS).next_multiple_of(ROUND));
    let advised = successors(Some(memory), more)
        .find(|&memory| fewest(memory, nesting.saturating_mul(ADVISED)).is_none())?;
    Some(format!(
        "a node of {} has room for {frames} fetched {}, and rays go down through up to {nesting}: the same ones are fetched again and again, which takes long; give {}",
        typed(memory as u64),
        if frames == 1 { "block" } else { "blocks" },
        typed(advised as u64),
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of two nodes the first has a frame for each KiB beyond 8, the second one for each block of others.
    fn rooms(memory: usize) -> Vec<Room> {
        [Room { frames: memory / 1024 - 8, blocks: 20 }, Room { frames: 2, blocks: 2 }].into()
    }

    #[test]
    fn fewer_frames_than_blocks_within_each_other_are_noted_with_twice_as_many() {
        let told = note(5, 12 << 10, rooms).expect("four are too few");
        assert!(told.starts_with("a node of 12KiB has room for 4 fetched blocks"), "{told}");
        let (_, advised) = told.rsplit_once("give ").expect("what to give");
        assert_eq!(advised, "18KiB");
        let one = note(5, 9 << 10, rooms).expect("one is too little");
        assert!(one.contains("room for 1 fetched block, "), "{one}");
    }

    #[test]
    fn enough_frames_or_frames_for_all_are_not() {
        assert_eq!(note(5, 13 << 10, rooms), None);
        assert_eq!(note(5, 64 << 10, |_| vec![Room { frames: 0, blocks: 0 }]), None);
    }
}
