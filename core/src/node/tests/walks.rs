//! Runs in which a seed chooses what happens next, with time.

use super::mesh::{Action, Setup, World, memory};
use super::toy::{NO_ENDS, Toy};
use super::{POINTS, SCHEDULES, Schedule};

fn setup(topology: (&str, u32), schedule: Schedule) -> Setup {
    let toy = Toy {
        tiles: 6,
        blocks: 7,
        way: 4,
        splits: 2,
        tail: 1,
        shadows: 3,
        block_bytes: 1024,
        seed: 5,
        ends: NO_ENDS,
    };
    Setup { timed: true, fused: false, ..super::setup(topology, schedule, toy) }
}

/// Runs a mesh, choosing among all that can happen by a seed: the number of steps.
fn run(setup: &Setup, seed: u64, loss: u32, double: u32, crash: Option<(u16, u32)>) -> u32 {
    let (mut chunks, blocks) = memory(setup);
    let mut world = World::new(setup, &mut chunks, &blocks);
    let mut random = fastrand::Rng::with_seed(seed);
    for step in 0..3_000_000 {
        if let Some((node, at)) = crash
            && step == at
        {
            world.act(Action::Crash(node));
        }
        assert!(!world.wrong, "seed {seed}");
        if world.is_complete() {
            return step;
        }
        let actions = world.actions();
        if actions.is_empty() {
            let nodes = world.summary();
            panic!("seed {seed}: nothing can happen after {step} steps: {nodes:#?}");
        }
        let action = actions[random.usize(..actions.len())];
        let action = match action {
            Action::Deliver(n, p) if loss > 0 && random.u32(..loss) == 0 => Action::Lose(n, p),
            Action::Deliver(n, p) if double > 0 && random.u32(..double) == 0 => {
                Action::Double(n, p)
            }
            other => other,
        };
        world.act(action);
    }
    panic!("seed {seed}: not complete: {:#?}", world.summary());
}

#[test]
fn all_is_rendered_in_the_least_memory() {
    for topology in [("line", 1), ("line", 2), ("ring", 4), ("mesh:2x2", 4), ("torus:3x3", 9)] {
        for schedule in SCHEDULES {
            for seed in 0..10 {
                let points = POINTS[seed as usize % 2];
                run(&Setup { points, ..setup(topology, schedule) }, seed, 0, 0, None);
            }
        }
    }
}

#[test]
fn lost_and_doubled_packets_cost_time_only() {
    for topology in [("line", 2), ("ring", 4), ("mesh:2x2", 4)] {
        for schedule in SCHEDULES {
            for seed in 0..10 {
                let points = POINTS[seed as usize % 2];
                run(&Setup { points, ..setup(topology, schedule) }, seed, 20, 20, None);
            }
        }
    }
}

#[test]
fn a_dead_node_costs_time_only_while_its_blocks_live_elsewhere() {
    for schedule in SCHEDULES {
        for seed in 0..20 {
            let points = POINTS[seed as usize / 3 % 2];
            let setup = Setup { replicas: 2, points, ..setup(("ring", 4), schedule) };
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
