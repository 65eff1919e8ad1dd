//! Larger meshes, where a seed chooses what happens next: every run ends, and one that does not is made short.

use super::super::mesh::{Action, Broken, Faults, More, Setup, World, memory};
use super::super::toy::{NO_ENDS, Toy};
use super::super::{POINTS, SCHEDULES, SHADOWS, setup};
use super::{Flaw, Found, Kind, describe};
use crate::node::TaskOrder;
use std::panic::{AssertUnwindSafe, catch_unwind};

/// Steps after which a run counts as endless.
const ENDLESS: usize = 500_000;

/// Reminders after which credit is not on its way but kept by packets that cannot go on.
const REMINDERS: usize = 3;

/// What a seed makes of a mesh.
pub(super) fn drawn(seed: u64) -> Setup {
    let mut random = fastrand::Rng::with_seed(seed);
    let topologies = [
        ("line", 1),
        ("line", 2),
        ("line", 3),
        ("ring", 3),
        ("ring", 4),
        ("mesh:2x2", 4),
        ("hypercube", 8),
        ("torus:3x3", 9),
    ];
    let topology = topologies[random.usize(..topologies.len())];
    let schedule = SCHEDULES[random.usize(..3)];
    let pieces = random.usize(1..3);
    let toy = Toy {
        tiles: random.u32(1..=6),
        blocks: 1 + random.u32(1..=2) * topology.1,
        way: random.u32(1..=5),
        splits: random.u32(0..=3),
        tail: random.u32(0..=1),
        shadows: random.u32(0..=3),
        block_bytes: [0, 64, 320][pieces],
        seed: random.u32(..),
        ends: NO_ENDS,
    };
    let mut some = |most: usize| random.usize(..=most).saturating_sub(random.usize(..=most));
    let more = More {
        rays: some(4),
        visits: some(3),
        shadows: some(3),
        fetches: some(2),
        frames: some(2),
        bundles: some(2),
        tiles: some(2),
    };
    let mut few = || random.u8(..4).saturating_sub(2);
    let [losses, doubles, crashes, early] = [(); 4].map(|()| few());
    let faults = Faults { losses, doubles, crashes: crashes.min(1), early, overdue: 0 };
    let crash = topology.1 > 2 && faults.crashes > 0;
    let mut drawn = Setup {
        more,
        faults: Faults { crashes: crash.into(), ..faults },
        replicas: if crash { 2 } else { 1 },
        top: random.u32(0..=1),
        refusals: random.u8(..3),
        hasty: random.bool(),
        fused: random.bool(),
        order: if random.bool() { TaskOrder::Made } else { TaskOrder::Ready },
        group: random.u16(..4),
        shadow: SHADOWS[random.usize(..3)],
        points: POINTS[random.usize(..2)],
        ..setup(topology, schedule, toy)
    };
    drawn.faults.overdue = random.u8(..6).saturating_sub(3);
    drawn
}

/// Lets a seed choose until nothing is left to do.
pub(super) fn wander(setup: &Setup, seed: u64) -> Result<usize, Flaw> {
    let (mut chunks, blocks) = memory(setup);
    let mut world = World::new(setup, &mut chunks, &blocks);
    let mut random = fastrand::Rng::with_seed(seed);
    let mut steps = Vec::new();
    let mut idle = 0;
    loop {
        let mut actions = world.actions();
        idle = if actions == [Action::Remind] { idle + 1 } else { 0 };
        if idle > REMINDERS {
            return Err(Flaw { kind: Kind::DeadEnd, steps });
        }
        if random.u8(..16) == 0 && !actions.is_empty() {
            actions.extend(world.faults());
        }
        let Some(&action) = actions.get(random.usize(..actions.len().max(1))) else {
            return match world.is_finished() {
                true => Ok(steps.len()),
                false => Err(Flaw { kind: Kind::DeadEnd, steps }),
            };
        };
        steps.push(action);
        let acted = catch_unwind(AssertUnwindSafe(|| world.act(action)));
        let kind = match acted {
            Err(_) => Kind::Panic,
            Ok(()) if world.wrong => Kind::WrongSum,
            Ok(()) if world.lost.is_some() => Kind::Lost,
            Ok(()) if steps.len() == ENDLESS => Kind::Endless,
            Ok(()) => continue,
        };
        return Err(Flaw { kind, steps });
    }
}

/// What comes of these steps, without those that cannot be taken.
fn replay(setup: &Setup, steps: &[Action]) -> Option<Flaw> {
    let (mut chunks, blocks) = memory(setup);
    let mut world = World::new(setup, &mut chunks, &blocks);
    let mut taken = Vec::new();
    for &action in steps {
        let mut can = world.actions();
        can.extend(world.faults());
        if !can.contains(&action) {
            continue;
        }
        taken.push(action);
        let acted = catch_unwind(AssertUnwindSafe(|| world.act(action)));
        let kind = match acted {
            Err(_) => Kind::Panic,
            Ok(()) if world.wrong => Kind::WrongSum,
            Ok(()) if world.lost.is_some() => Kind::Lost,
            Ok(()) => continue,
        };
        return Some(Flaw { kind, steps: taken });
    }
    for _ in 0..REMINDERS {
        if world.actions() == [Action::Remind] {
            world.act(Action::Remind);
        }
    }
    let left = world.actions();
    let is_stuck = (left.is_empty() || left == [Action::Remind]) && !world.is_finished();
    is_stuck.then_some(Flaw { kind: Kind::DeadEnd, steps: taken })
}

/// Leaves out steps, many at a time and then one by one, as long as the flaw stays (Zeller & Hildebrandt 2002).
pub(super) fn shrunk(setup: &Setup, mut flaw: Flaw) -> Flaw {
    let mut part = flaw.steps.len() / 2;
    while part > 0 && flaw.kind != Kind::Endless {
        let mut at = 0;
        while at < flaw.steps.len() {
            let mut fewer = flaw.steps.clone();
            fewer.drain(at..(at + part).min(fewer.len()));
            match replay(setup, &fewer).filter(|found| found.kind == flaw.kind) {
                Some(found) if found.steps.len() < flaw.steps.len() => flaw = found,
                _ => at += part,
            }
        }
        part /= 2;
    }
    flaw
}

/// The first flaw of these kinds that seeds find in small meshes `like` those with a broken rule, made short, and its seed.
pub(super) fn first_flaw(
    broken: Broken,
    kinds: &[Kind],
    like: fn(Setup) -> Setup,
) -> Option<(u64, Setup, Flaw)> {
    (0..40_000).find_map(|seed| {
        let setup = Setup { broken: Some(broken), fused: true, ..like(drawn(seed)) };
        if setup.topology.nodes() > 4 {
            return None;
        }
        let flaw = wander(&setup, seed).err().filter(|flaw| kinds.contains(&flaw.kind))?;
        let is_short = flaw.steps.len() < 400;
        Some((seed, setup, if is_short { shrunk(&setup, flaw) } else { flaw }))
    })
}

#[test]
fn every_random_run_ends_and_leaves_nothing() {
    let runs = std::env::var("KILORAY_RUNS").ok().and_then(|runs| runs.parse().ok());
    let first = std::env::var("KILORAY_SEED").ok().and_then(|seed| seed.parse().ok()).unwrap_or(0);
    for seed in first..first + runs.unwrap_or(300) {
        let setup = drawn(seed);
        if let Err(flaw) = wander(&setup, seed) {
            let flaw = shrunk(&setup, flaw);
            let found = Found { states: 0, steps: 0, depth: 0, is_full: false, flaw: Some(flaw) };
            panic!("seed {seed}: {setup:?}: {}", describe(&setup, &found));
        }
    }
}
