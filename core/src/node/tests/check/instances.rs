//! What is searched in full: small meshes with one packet to a buffer and the least memory.

use super::super::mesh::{Faults, More, Setup};
use super::super::toy::{NO_ENDS, Toy};
use super::super::{SCHEDULES, setup};
use super::{describe, explore};
use crate::node::{PointHome, Schedule, ShadowPolicy, TaskOrder};

/// States that a search in the suite may have. `KILORAY_CHECK=1000000` looks further than the suite has time for.
fn most() -> usize {
    std::env::var("KILORAY_CHECK").ok().and_then(|most| most.parse().ok()).unwrap_or(20_000)
}

/// One shadow ray per point, blocks in one piece, a block of each node's own.
pub(super) fn mesh(topology: (&str, u32), tiles: u32, splits: u32, schedule: Schedule) -> Setup {
    let blocks = topology.1 + 1;
    let toy = Toy {
        tiles,
        blocks,
        way: 3,
        splits,
        tail: 0,
        shadows: 1,
        block_bytes: 64,
        seed: 5,
        ends: NO_ENDS,
    };
    setup(topology, schedule, toy)
}

/// Searches in full, and finds no flaw.
fn holds(setup: &Setup) {
    assert!(holds_so_far(setup), "there are more states than are searched");
}

/// Searches in full, or as far as there is time, and finds no flaw: whether it was in full.
fn holds_so_far(setup: &Setup) -> bool {
    let found = explore(setup, most());
    let Setup { topology, schedule, faults, .. } = setup;
    let Toy { tiles, splits, .. } = setup.toy;
    println!(
        "{topology:?}, {schedule:?}, {tiles} tiles, {splits} splits, {faults:?}: {} states, {} steps, at most {} deep{}",
        found.states,
        found.steps,
        found.depth,
        if found.is_full { "" } else { ", not in full" },
    );
    assert!(found.flaw.is_none(), "{}", describe(setup, &found));
    found.is_full
}

/// Of every schedule; whether all was searched in full.
fn all_hold(topology: (&str, u32), tiles: u32, splits: u32, faults: Faults) -> bool {
    let all = SCHEDULES.map(|schedule| {
        let replicas = 1 + u16::from(faults.crashes);
        let setup = mesh(topology, tiles, splits, schedule);
        holds_so_far(&Setup { faults, replicas, ..setup })
    });
    all.into_iter().all(|is_full| is_full)
}

#[test]
fn every_run_ends_and_leaves_nothing() {
    for (tiles, splits) in [(1, 0), (1, 1), (1, 2), (2, 0), (2, 1), (3, 0)] {
        assert!(all_hold(("line", 2), tiles, splits, Faults::default()));
    }
    all_hold(("line", 2), 3, 1, Faults::default());
    for (tiles, splits) in [(1, 0), (1, 1)] {
        assert!(all_hold(("ring", 3), tiles, splits, Faults::default()));
    }
    if most() > 20_000 {
        for (topology, tiles, splits) in
            [(("line", 2), 2, 2), (("line", 3), 2, 1), (("ring", 3), 2, 1), (("mesh:2x2", 4), 1, 1)]
        {
            all_hold(topology, tiles, splits, Faults::default());
        }
    }
}

#[test]
fn the_oldest_path_may_go_first() {
    for schedule in SCHEDULES {
        for (topology, tiles, splits) in [(("line", 2), 2, 1), (("ring", 3), 1, 1)] {
            holds(&Setup { order: TaskOrder::Made, ..mesh(topology, tiles, splits, schedule) });
        }
    }
}

#[test]
fn who_has_nothing_to_do_may_ask_the_lights_of_others() {
    let none = Faults::default();
    for shadow in [ShadowPolicy::Offer, ShadowPolicy::Steal] {
        for (schedule, splits) in
            [(Schedule::Demand, 0), (Schedule::Demand, 1), (Schedule::Hybrid, 1)]
        {
            for faults in [none, Faults { losses: 1, ..none }, Faults { early: 1, ..none }] {
                let more = More { rays: 1, shadows: 1, ..More::default() };
                holds_so_far(&Setup {
                    shadow,
                    more,
                    faults,
                    ..mesh(("line", 2), 2, splits, schedule)
                });
            }
        }
    }
}

#[test]
fn points_may_live_with_the_owners_of_their_blocks() {
    let none = Faults::default();
    for (schedule, splits) in [(Schedule::Demand, 0), (Schedule::Hybrid, 1), (Schedule::Data, 1)] {
        for faults in [
            none,
            Faults { losses: 1, ..none },
            Faults { crashes: 1, ..none },
            Faults { early: 1, ..none },
        ] {
            let points = PointHome::Owner;
            let replicas = 1 + u16::from(faults.crashes);
            let setup = mesh(("line", 2), 2, splits, schedule);
            holds_so_far(&Setup { points, faults, replicas, ..setup });
            if splits == 0 {
                continue;
            }
            // A point that would only pass on an answer: it asks no light, and its children are one.
            let mut setup = mesh(("ring", 3), 1, 0, schedule);
            (setup.toy.shadows, setup.toy.tail) = (0, 2);
            holds_so_far(&Setup { points, faults, replicas, ..setup });
        }
    }
}

/// A frame that others wait for comes free by a shadow ray's last look at its block: nothing else happens.
#[test]
fn who_waits_for_a_frame_goes_on_when_it_is_used() {
    holds_so_far(&mesh(("ring", 3), 1, 2, Schedule::Demand));
}

#[test]
fn a_loss_a_copy_a_crash_or_an_early_time_limit_costs_time_only() {
    let none = Faults::default();
    let one = [
        Faults { losses: 1, ..none },
        Faults { doubles: 1, ..none },
        Faults { crashes: 1, ..none },
        Faults { early: 1, ..none },
    ];
    let two = [
        Faults { losses: 1, doubles: 1, ..none },
        Faults { losses: 1, early: 1, ..none },
        Faults { doubles: 1, early: 1, ..none },
        Faults { losses: 1, crashes: 1, ..none },
        Faults { crashes: 1, early: 1, ..none },
    ];
    for (tiles, splits) in [(1, 1), (2, 0)] {
        for faults in one {
            assert!(all_hold(("line", 2), tiles, splits, faults));
        }
        for faults in two {
            all_hold(("line", 2), tiles, splits, faults);
        }
    }
    if most() > 20_000 {
        for faults in one.into_iter().chain(two) {
            for (topology, tiles, splits) in
                [(("line", 2), 1, 2), (("line", 2), 2, 1), (("ring", 3), 1, 1)]
            {
                all_hold(topology, tiles, splits, faults);
            }
        }
    }
}
