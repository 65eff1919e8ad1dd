//! All runs of small meshes: the real transition functions, searched in full.
//!
//! A state is the bytes of [`World::snapshot`]; the search goes breadth first from the start, over every choice of what happens next. The graph
//! of states is then searched for those from which the end cannot be reached, and for cycles.

use super::mesh::{Action, Setup, World, memory};
use crate::tests::snapshot::Snapshot;
use std::collections::hash_map::{DefaultHasher, Entry};
use std::collections::{HashMap, VecDeque};
use std::hash::Hasher;
use std::panic::{AssertUnwindSafe, catch_unwind};

/// What a search has found.
#[derive(Debug)]
pub(super) struct Found {
    pub(super) states: usize,
    pub(super) steps: usize,
    /// Steps of the longest of the shortest ways to a state.
    pub(super) depth: u32,
    /// All was searched.
    pub(super) is_full: bool,
    pub(super) flaw: Option<Flaw>,
}

/// What must not be, and the shortest way to it.
#[derive(Debug)]
pub(super) struct Flaw {
    pub(super) kind: Kind,
    pub(super) steps: Vec<Action>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    /// Nothing can happen, and the picture is not complete or something is left.
    DeadEnd,
    /// The end cannot be reached any more.
    NoWayOut,
    /// A tile has come to something else than it should.
    WrongSum,
    /// An invariant does not hold.
    Panic,
    /// A block counts as lost.
    Lost,
    /// Something can go on for ever.
    Endless,
}

#[derive(Clone, Copy)]
struct Edge {
    from: u32,
    to: u32,
    is_fault: bool,
}

fn fingerprint(state: &[u8]) -> u64 {
    let mut hasher = DefaultHasher::new();
    hasher.write(state);
    hasher.finish()
}

fn save(world: &mut World<'_>) -> Vec<u8> {
    let mut snapshot = Snapshot::new();
    world.snapshot(&mut snapshot);
    snapshot.into_bytes()
}

fn load(world: &mut World<'_>, state: Vec<u8>) {
    world.snapshot(&mut Snapshot::of(state));
}

/// Searches at most so many states.
pub(super) fn explore(setup: &Setup, most: usize) -> Found {
    let (mut chunks, blocks) = memory(setup);
    let mut world = World::new(setup, &mut chunks, &blocks);
    let start = save(&mut world);
    let mut known = HashMap::from([(fingerprint(&start), 0_u32)]);
    // Before each state, the step to it, and how far it is.
    let mut before: Vec<(u32, Option<Action>, u32)> = vec![(0, None, 0)];
    let mut edges: Vec<Edge> = Vec::new();
    let mut finished: Vec<u32> = Vec::new();
    let mut queue = VecDeque::from([start]);
    let mut flaw = None;
    let mut at = 0;
    while let Some(state) = queue.pop_front() {
        load(&mut world, state.clone());
        let regular = world.actions();
        let faults = world.faults();
        if world.is_finished() {
            finished.push(at);
        } else if regular.is_empty() {
            flaw = Some((Kind::DeadEnd, at, None));
            break;
        }
        let count = regular.len();
        for (i, action) in regular.into_iter().chain(faults).enumerate() {
            load(&mut world, state.clone());
            let acted = catch_unwind(AssertUnwindSafe(|| world.act(action)));
            let kind = match acted {
                Err(_) => Some(Kind::Panic),
                Ok(()) if world.wrong => Some(Kind::WrongSum),
                Ok(()) if world.lost.is_some() => Some(Kind::Lost),
                Ok(()) => None,
            };
            if let Some(kind) = kind {
                flaw = Some((kind, at, Some(action)));
                break;
            }
            let next = save(&mut world);
            let count_known = known.len() as u32;
            let to = match known.entry(fingerprint(&next)) {
                Entry::Occupied(entry) => *entry.get(),
                Entry::Vacant(entry) => {
                    entry.insert(count_known);
                    let depth = before[at as usize].2 + 1;
                    before.push((at, Some(action), depth));
                    queue.push_back(next);
                    count_known
                }
            };
            edges.push(Edge { from: at, to, is_fault: i >= count });
        }
        if flaw.is_some() || known.len() > most {
            break;
        }
        at += 1;
    }
    let is_full = flaw.is_none() && queue.is_empty();
    if is_full {
        let stuck = no_way_out(before.len(), &edges, &finished);
        flaw = match stuck {
            Some(stuck) => Some((Kind::NoWayOut, stuck, None)),
            None => in_cycle(before.len(), &edges).map(|at| (Kind::Endless, at, None)),
        };
    }
    let flaw = flaw.map(|(kind, mut at, last)| {
        let mut steps = Vec::from_iter(last);
        while let (from, Some(action), _) = before[at as usize] {
            steps.push(action);
            at = from;
        }
        steps.reverse();
        Flaw { kind, steps }
    });
    let depth = before.iter().map(|&(.., depth)| depth).max().unwrap_or(0);
    Found { states: before.len(), steps: edges.len(), depth, is_full, flaw }
}

/// The first state from which no finished one can be reached without faults.
fn no_way_out(states: usize, edges: &[Edge], finished: &[u32]) -> Option<u32> {
    let mut back: Vec<Edge> = edges.iter().copied().filter(|edge| !edge.is_fault).collect();
    back.sort_unstable_by_key(|edge| edge.to);
    let mut good = vec![false; states];
    let mut queue = finished.to_vec();
    finished.iter().for_each(|&state| good[state as usize] = true);
    while let Some(to) = queue.pop() {
        let first = back.partition_point(|edge| edge.to < to);
        for edge in back[first..].iter().take_while(|edge| edge.to == to) {
            if !core::mem::replace(&mut good[edge.from as usize], true) {
                queue.push(edge.from);
            }
        }
    }
    good.iter().position(|&good| !good).map(|state| state as u32)
}

/// A state on, or behind, a cycle: what is left when states without a step into them are taken away, one after the other.
fn in_cycle(states: usize, edges: &[Edge]) -> Option<u32> {
    let mut into = vec![0_u32; states];
    // A step that changes nothing is no cycle.
    let mut edges: Vec<Edge> = edges.iter().copied().filter(|edge| edge.from != edge.to).collect();
    edges.sort_unstable_by_key(|edge| edge.from);
    edges.iter().for_each(|edge| into[edge.to as usize] += 1);
    let mut queue: Vec<u32> = (0..states as u32).filter(|&at| into[at as usize] == 0).collect();
    let mut left = states;
    while let Some(from) = queue.pop() {
        left -= 1;
        let first = edges.partition_point(|edge| edge.from < from);
        for edge in edges[first..].iter().take_while(|edge| edge.from == from) {
            into[edge.to as usize] -= 1;
            if into[edge.to as usize] == 0 {
                queue.push(edge.to);
            }
        }
    }
    (left > 0).then(|| into.iter().position(|&count| count > 0).unwrap_or(0) as u32)
}

/// What is in the way of a flaw, step by step.
pub(super) fn describe(setup: &Setup, found: &Found) -> String {
    let Some(flaw) = &found.flaw else { return format!("{found:?}") };
    let (mut chunks, blocks) = memory(setup);
    let mut world = World::new(setup, &mut chunks, &blocks);
    for &action in &flaw.steps {
        let _ = catch_unwind(AssertUnwindSafe(|| world.act(action)));
    }
    let Found { states, .. } = found;
    format!("{flaw:?} after {states} states: {:#?}", world.summary())
}

mod broken;
mod instances;
mod wander;
