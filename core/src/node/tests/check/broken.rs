//! Rules broken on purpose: the search finds each.

use super::super::mesh::{Broken, Faults, Setup};
use super::instances::mesh;
use super::{Kind, describe, explore};
use crate::node::Schedule;
use crate::node::rules::Rule;

/// Finds a flaw of one of these kinds that is not there while the rule is kept.
fn fails(setup: &Setup, broken: Broken, kinds: &[Kind]) {
    let setup = Setup { broken: Some(broken), ..*setup };
    let found = explore(&setup, 200_000);
    let Some(flaw) = &found.flaw else { panic!("{broken:?} does no harm: {found:?}") };
    assert!(kinds.contains(&flaw.kind), "{}", describe(&setup, &found));
    println!(
        "{broken:?}: {:?} after {} steps, {} states",
        flaw.kind,
        flaw.steps.len(),
        found.states
    );
}

#[test]
fn without_a_reserve_no_child_finds_a_slot() {
    let setup = mesh(("line", 1), 1, 3, Schedule::Demand);
    fails(&setup, Broken::Node(Rule::Reserve), &[Kind::DeadEnd]);
}

#[test]
fn credit_that_is_lost_stays_lost_if_nobody_asks() {
    let faults = Faults { losses: 1, ..Faults::default() };
    let setup = Setup { faults, ..mesh(("line", 2), 1, 0, Schedule::Demand) };
    fails(&setup, Broken::NoReminder, &[Kind::DeadEnd]);
}
