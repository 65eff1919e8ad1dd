//! Rules broken on purpose: the search, or a random run, finds each.

use super::super::mesh::{Broken, Faults, Setup};
use super::instances::mesh;
use super::wander::{first_flaw, wander};
use super::{Kind, describe, explore};
use crate::node::rules::Rule;
use crate::node::{PointHome, Schedule};

/// Nothing goes on, or it never ends.
const STUCK: [Kind; 3] = [Kind::DeadEnd, Kind::NoWayOut, Kind::Endless];

/// The search finds a flaw of one of these kinds.
fn fails(setup: &Setup, broken: Broken, kinds: &[Kind]) {
    let setup = Setup { broken: Some(broken), ..*setup };
    let found = explore(&setup, 200_000);
    let Some(flaw) = &found.flaw else { panic!("{broken:?} does no harm: {found:?}") };
    assert!(kinds.contains(&flaw.kind), "{}", describe(&setup, &found));
    println!("{broken:?}: {:?}, {} steps: {:?}", flaw.kind, flaw.steps.len(), flaw.steps);
}

/// Random runs find such a flaw, and the same run with the rule kept ends well.
fn is_found(broken: Broken, kinds: &[Kind]) {
    is_found_where(broken, kinds, |setup| setup);
}

/// The same in meshes like those.
fn is_found_where(broken: Broken, kinds: &[Kind], like: fn(Setup) -> Setup) {
    let Some((seed, setup, flaw)) = first_flaw(broken, kinds, like) else {
        panic!("{broken:?} does no harm")
    };
    println!("{broken:?}, seed {seed}: {:?}, {} steps, {setup:?}", flaw.kind, flaw.steps.len());
    let kept = Setup { broken: None, ..setup };
    assert!(wander(&kept, seed).is_ok(), "{broken:?}, seed {seed}");
}

#[test]
fn one_channel_for_requests_and_replies() {
    is_found(Broken::OneChannel, &STUCK);
}

#[test]
fn a_ring_without_a_dateline() {
    is_found(Broken::NoDateline, &STUCK);
}

#[test]
fn credit_that_is_lost_stays_lost_if_nobody_asks() {
    let lossy = |setup| Setup { faults: Faults { losses: 2, ..Faults::default() }, ..setup };
    is_found_where(Broken::NoReminder, &STUCK, lossy);
}

#[test]
fn a_reply_waits_until_there_is_room_to_go_on() {
    is_found(Broken::Node(Rule::ConsumeReplies), &STUCK);
}

#[test]
fn bundles_leave_only_when_they_are_full() {
    is_found(Broken::Node(Rule::Flush), &STUCK);
}

#[test]
fn without_a_reserve_no_child_finds_a_slot() {
    fails(&mesh(("line", 1), 1, 3, Schedule::Demand), Broken::Node(Rule::Reserve), &STUCK);
}

#[test]
fn one_slot_in_reserve_for_all_depths() {
    is_found(Broken::Node(Rule::ReserveByDepth), &STUCK);
}

#[test]
fn rays_may_be_refused_for_ever() {
    is_found(Broken::Node(Rule::RefusalLimit), &STUCK);
}

#[test]
fn a_refused_ray_needs_another_slot() {
    is_found(Broken::Node(Rule::HomeSlot), &STUCK);
}

#[test]
fn a_block_is_asked_for_before_it_has_a_frame() {
    is_found(Broken::Node(Rule::FrameFirst), &STUCK);
}

#[test]
fn rays_keep_their_frames_while_they_wait() {
    is_found(Broken::Node(Rule::FrameFree), &STUCK);
}

#[test]
fn an_answer_is_known_by_its_slot_alone() {
    is_found(Broken::Node(Rule::AnswerByKey), &[Kind::WrongSum]);
}

#[test]
fn who_finds_a_hit_adds_a_part_of_what_its_ray_brings() {
    // A late answer meets the same ray of a tile that was given again: rare where few tiles are.
    let like = |setup: Setup| {
        let faults = Faults { losses: 2, overdue: 4, ..setup.faults };
        Setup { points: PointHome::Owner, group: 0, faults, ..setup }
    };
    is_found_where(Broken::Node(Rule::WholeAnswer), &[Kind::WrongSum], like);
}

#[test]
fn a_sub_master_answers_a_repeated_request_with_another_tile() {
    is_found(Broken::Node(Rule::OneAnswer), &STUCK);
}

#[test]
fn the_time_limit_stops_while_a_copy_is_believed_alive() {
    is_found(Broken::Node(Rule::Timer), &STUCK);
}
