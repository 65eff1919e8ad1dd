mod mesh;
mod toy;

use self::mesh::{Action, Setup, World, memory};
use self::toy::Toy;
use super::Schedule;
use crate::network::Topology;
use crate::store::Chunk;
use std::vec::Vec;

fn setup(topology: (&str, u32), schedule: Schedule) -> Setup {
    let toy =
        Toy { tiles: 6, blocks: 7, way: 4, splits: 2, tail: 1, shadows: 3, block_bytes: 1024 };
    Setup {
        topology: Topology::parse(topology.0, topology.1).unwrap(),
        toy,
        schedule,
        top: 1,
        replicas: 1,
        refusals: 1,
        group: 0,
        plan: |_| {},
    }
}

/// Runs a mesh, choosing among all that can happen by a seed: the number of steps.
fn run(setup: &Setup, seed: u64, loss: u32, double: u32, crash: Option<(u16, u32)>) -> u32 {
    let (mut chunks, blocks): (Vec<Vec<Chunk>>, Vec<u8>) = memory(setup);
    let mut world = World::new(setup, &mut chunks, &blocks);
    let mut random = fastrand::Rng::with_seed(seed);
    for step in 0..3_000_000 {
        if let Some((node, at)) = crash
            && step == at
        {
            world.crash(node);
        }
        if world.is_complete() {
            for (tile, sum) in world.sums.iter().enumerate() {
                assert_eq!(*sum, Some(setup.toy.expected(tile as u32)), "seed {seed}");
            }
            return step;
        }
        let actions = world.actions();
        if actions.is_empty() {
            let nodes: Vec<_> = world.nodes().iter().map(super::Node::summary).collect();
            panic!("seed {seed}: nothing can happen after {step} steps: {nodes:#?}");
        }
        let action = actions[random.usize(..actions.len())];
        let action = match action {
            Action::Deliver(n, p) if loss > 0 && random.u32(..loss) == 0 => Action::Drop(n, p),
            Action::Deliver(n, p) if double > 0 && random.u32(..double) == 0 => {
                Action::Double(n, p)
            }
            other => other,
        };
        world.act(action);
    }
    let stuck: Vec<_> = world.nodes().iter().map(super::Node::summary).collect();
    let mut last = Vec::new();
    for _ in 0..30 {
        let actions = world.actions();
        let action = actions[random.usize(..actions.len())];
        last.push((world.now.0, action));
        world.act(action);
    }
    panic!("seed {seed}: not complete: {stuck:#?} {last:?}");
}

#[test]
fn all_is_rendered_in_the_least_memory() {
    for topology in [("line", 1), ("line", 2), ("ring", 4), ("mesh:2x2", 4), ("torus:3x3", 9)] {
        for schedule in [Schedule::Hybrid, Schedule::Demand, Schedule::Data] {
            for seed in 0..10 {
                run(&setup(topology, schedule), seed, 0, 0, None);
            }
        }
    }
}

#[test]
fn lost_and_doubled_packets_cost_time_only() {
    for topology in [("line", 2), ("ring", 4), ("mesh:2x2", 4)] {
        for schedule in [Schedule::Hybrid, Schedule::Demand, Schedule::Data] {
            for seed in 0..10 {
                run(&setup(topology, schedule), seed, 20, 20, None);
            }
        }
    }
}

#[test]
fn a_dead_node_costs_time_only_while_its_blocks_live_elsewhere() {
    for schedule in [Schedule::Hybrid, Schedule::Demand, Schedule::Data] {
        for seed in 0..20 {
            let setup = Setup { replicas: 2, ..setup(("ring", 4), schedule) };
            run(&setup, seed, 0, 0, Some((1 + (seed % 3) as u16, 40 * seed as u32)));
        }
    }
}

#[test]
fn sub_masters_give_tiles_away() {
    for seed in 0..10 {
        run(&Setup { group: 2, ..setup(("mesh:2x2", 4), Schedule::Hybrid) }, seed, 0, 0, None);
    }
}
