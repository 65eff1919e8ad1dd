//! From what was typed of a mesh to how a run is divided.

use std::iter::successors;

use kiloray_core::{block::KiloView, network::Topology, node, shade::Settings};
use kiloray_mesh::MeshOptions;
use serde::Serialize;
use serde_json::{Value, json};

use crate::{
    args::{self, BLOCK_MIN, Bounds, Common, Division, size::typed},
    failure::{Failure, Outcome},
    memory,
};

/// Size of the nodes' memory.
pub(super) fn memory(common: &Common) -> u64 {
    common.memory.unwrap_or(args::MESH_MEMORY)
}

/// Size of a block where nothing is said, for nodes of this memory: the least whose square is twice the memory, from 1 to 16 KiB. Great blocks leave few
/// frames and fill links; small ones come often, each with its message (`docs/measurements.md`, "The size of a block").
pub(super) fn default_block(memory: u64) -> u32 {
    sizes().find(|&block| memory <= suited_by(block)).unwrap_or(BLOCK_MAX)
}

/// The greatest block where nothing is said.
const BLOCK_MAX: u32 = 16 << 10;

/// The sizes of blocks where nothing is said.
pub(super) fn sizes() -> impl Iterator<Item = u32> {
    successors(Some(BLOCK_MIN), |size| size.checked_mul(2)).take_while(|&size| size <= BLOCK_MAX)
}

/// The greatest memory that blocks of this size suit.
pub(super) fn suited_by(block: u32) -> u64 {
    if block >= BLOCK_MAX { u64::MAX } else { u64::from(block).pow(2) / 2 }
}

/// How a picture is divided among the nodes of a topology.
pub(super) fn options(
    common: &Common,
    division: &Division,
    bounds: Bounds,
    topology: Topology,
    file: &KiloView<'_>,
) -> Outcome<MeshOptions> {
    memory::for_picture(bounds.width, bounds.height)?;
    let mut options = MeshOptions::new(bounds.width, bounds.height, topology);
    options.settings = Settings {
        samples: common.samples,
        shadow_samples: common.shadow_samples.unwrap_or(0),
        lights: common.lights_per_point,
        bounces: common.bounces as u8,
        seed: common.seed,
    };
    options.memory = usize::try_from(self::memory(common))
        .map_err(|_| Failure::usage("--memory is more than can be addressed"))?;
    with(options, division, file)
}

/// The same with what is said of the division, the topology apart.
pub(super) fn with(
    mut options: MeshOptions,
    division: &Division,
    file: &KiloView<'_>,
) -> Outcome<MeshOptions> {
    if let Some(packet) = division.packet {
        options.packet = self::packet(packet as u16, file)?;
    }
    options.schedule = division.schedule;
    options.shadow = division.shadow.unwrap_or(options.shadow);
    options.points = division.points.unwrap_or(options.points);
    options.dealing = division.placement;
    let block_bytes = u64::from(file.header().block_bytes);
    options.top = division.top.map(|top| top.blocks(block_bytes));
    options.replicas = replicas(division.block_replicas, options.topology.nodes())?;
    options.prefetch = division.prefetch.unwrap_or(options.prefetch);
    options.order = division.task_order.unwrap_or(options.order);
    options.group = division.group.map_or(options.group, |nodes| nodes as u16);
    if let Some(refusals) = division.refusals {
        options.refusals = refusals as u8;
    }
    options.tile = division.tile.map(|side| side as u16);
    if let Some(rom) = division.rom {
        let placement = options.placement(file);
        options.top = Some(limited(placement, rom, block_bytes, division.top.is_some())?.top);
    }
    Ok(options)
}

/// A packet in which a block can be sent.
fn packet(packet: u16, file: &KiloView<'_>) -> Outcome<u16> {
    let block_bytes = file.header().block_bytes;
    let least = MeshOptions::packet_min(block_bytes as usize);
    if packet < least {
        return Err(Failure::usage(format_args!(
            "--packet {}: blocks of {} need at least {least}B",
            typed(packet.into()),
            typed(block_bytes.into()),
        )));
    }
    Ok(packet)
}

/// The same blocks on nodes whose read-only memory has so many bytes; less of the tree's top lies with all of them if it must be, unless its size was said.
pub(super) fn limited(
    placement: node::Placement,
    rom: u64,
    block_bytes: u64,
    top_is_said: bool,
) -> Outcome<node::Placement> {
    let most = u32::try_from(rom / block_bytes.max(1)).unwrap_or(u32::MAX);
    let held = placement.most_blocks();
    let limited = if top_is_said && held > most { Err(held) } else { placement.within(most) };
    limited.map_err(|least| {
        let ways = [
            (true, "give more"),
            (u32::from(placement.nodes) < placement.blocks, "more --nodes"),
            (block_bytes > BLOCK_MIN.into(), "smaller blocks with --block"),
            (top_is_said, "a smaller --top"),
        ];
        let ways: Vec<_> = ways.iter().filter_map(|&(can, way)| can.then_some(way)).collect();
        Failure::new(format_args!(
            "--rom {}: a node owns up to {least} {}, {}; {}",
            typed(rom),
            if least == 1 { "block" } else { "blocks" },
            typed(u64::from(least) * block_bytes),
            ways.join(", or "),
        ))
    })
}

/// So many copies of each block, where there are as many nodes.
pub(super) fn replicas(copies: u32, nodes: u16) -> Outcome<u16> {
    u16::try_from(copies).ok().filter(|&copies| copies <= nodes).ok_or_else(|| {
        Failure::usage(format_args!(
            "--block-replicas {copies}: {nodes} nodes hold at most {nodes} copies of a block"
        ))
    })
}

/// Adds the mesh to the options of a report: what was typed of it, and what was found where nothing was said.
pub(super) fn add_json(
    all: &mut Value,
    typed: &impl Serialize,
    options: &MeshOptions,
    topology: &str,
) {
    if let (Some(all), Value::Object(typed)) = (all.as_object_mut(), json!(typed)) {
        all.extend(typed);
    }
    all["memory"] = json!(options.memory);
    all["nodes"] = json!(options.topology.nodes());
    all["topology"] = json!(topology);
    all["prefetch"] = json!(prefetch(options.prefetch));
    all["shadow"] = json!(options.shadow);
    all["points"] = json!(options.points);
    all["task_order"] = json!(options.order);
    all["packet"] = json!(options.packet);
    all["tile"] = json!(options.tile);
    all["top"] = json!(options.top);
    all["group"] = json!(options.group);
    all["refusals"] = json!(options.refusals);
}

/// `all`, or a number.
pub(super) fn prefetch(prefetch: node::Prefetch) -> String {
    match prefetch {
        node::Prefetch::All => "all".into(),
        node::Prefetch::Nearest(blocks) => blocks.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::default_block;

    #[test]
    fn a_block_is_as_great_as_its_square_is_twice_the_memory() {
        for (memory, block) in [
            (0, 1),
            (64, 1),
            (512, 1),
            (513, 2),
            (2 << 10, 2),
            (3 << 10, 4),
            (8 << 10, 4),
            (32 << 10, 8),
            (33 << 10, 16),
            (u64::MAX >> 10, 16),
        ] {
            assert_eq!(default_block(memory << 10), block << 10, "{memory} KiB");
        }
    }
}
