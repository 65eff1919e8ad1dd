//! Several rays in flight: a block that was fetched serves all that want it.
//!
//! A source that holds all blocks gets its rays one after the other. (Taking them in turns, with the next node or record
//! asked for in advance, was measured a third slower on a PC with AVX2: the state of a single ray stays in registers.)

use super::code::{EMPTY, INDEX, is_leaf, is_node, is_ref};
use super::cursor::{Cursor, Levels, Place, Run, TraceError};
use super::lanes::Lanes;
use super::leaf::leaf;
use super::octant::{Octants, first_octants};
use super::query::{AnyInto, ClosestInto, Query};
use super::visit::{take, visit};
use super::walk::{any, closest};
use crate::block::{BlockSource, NO_HEADER};
use crate::geometry::{Hit, PreparedRay, Ray};

/// How many rays are in flight.
pub const FLIGHTS: usize = 8;

/// Room for the rays in flight of a batch: 19 KiB.
#[derive(Debug, Clone)]
pub struct Batch {
    levels: [Levels; FLIGHTS],
    single: Cursor,
}

impl Default for Batch {
    fn default() -> Self {
        Self::new()
    }
}

impl Batch {
    /// Room for batches.
    #[must_use]
    pub const fn new() -> Self {
        Self { levels: [const { Levels::new() }; FLIGHTS], single: Cursor::new() }
    }
}

/// The closest hits of many rays, `hits[i]` that of `rays[i]`. The shorter slice counts.
///
/// # Errors
/// [`TraceError`]: the hits are then incomplete, and the batch begins anew.
#[inline(always)]
pub fn closest_batch<L: Lanes, S: BlockSource>(
    lanes: L,
    room: &mut Batch,
    source: &mut S,
    rays: &[Ray],
    hits: &mut [Option<Hit>],
) -> Result<(), TraceError<S::Error>> {
    if source.holds_all() {
        for (ray, hit) in rays.iter().zip(hits) {
            *hit = closest(lanes, &mut room.single, source, ray)?;
        }
        return Ok(());
    }
    hits.iter_mut().for_each(|hit| *hit = None);
    let rays = rays.get(..hits.len()).unwrap_or(rays);
    fly(lanes, room, source, rays, &mut ClosestOf(hits))
}

/// Whether each of many rays hits anything. The shorter slice counts.
///
/// # Errors
/// As [`closest_batch`].
#[inline(always)]
pub fn any_batch<L: Lanes, S: BlockSource>(
    lanes: L,
    room: &mut Batch,
    source: &mut S,
    rays: &[Ray],
    hits: &mut [bool],
) -> Result<(), TraceError<S::Error>> {
    if source.holds_all() {
        for (ray, hit) in rays.iter().zip(hits) {
            *hit = any(lanes, &mut room.single, source, ray)?;
        }
        return Ok(());
    }
    hits.fill(false);
    let rays = rays.get(..hits.len()).unwrap_or(rays);
    fly(lanes, room, source, rays, &mut AnyOf(hits))
}

/// The answers of a batch, by ray.
pub(super) trait Answers {
    type Query<'a>: Query
    where
        Self: 'a;

    fn query(&mut self, ray: usize) -> Option<Self::Query<'_>>;
}

pub(super) struct ClosestOf<'h>(pub(super) &'h mut [Option<Hit>]);

impl Answers for ClosestOf<'_> {
    type Query<'a>
        = ClosestInto<'a>
    where
        Self: 'a;

    #[inline(always)]
    fn query(&mut self, ray: usize) -> Option<ClosestInto<'_>> {
        self.0.get_mut(ray).map(ClosestInto)
    }
}

pub(super) struct AnyOf<'h>(pub(super) &'h mut [bool]);

impl Answers for AnyOf<'_> {
    type Query<'a>
        = AnyInto<'a>
    where
        Self: 'a;

    #[inline(always)]
    fn query(&mut self, ray: usize) -> Option<AnyInto<'_>> {
        self.0.get_mut(ray).map(AnyInto)
    }
}

/// A ray in flight.
struct Flight<L: Lanes> {
    /// It has a ray.
    flying: bool,
    index: usize,
    at: Place,
    ray: PreparedRay,
    octants: &'static Octants,
    prepared: L::Ray,
    /// In the frame of the block `framed`.
    frame: L::Frame,
    framed: u32,
}

/// What became of a flight in one step.
#[derive(PartialEq, Eq)]
enum Step {
    Going,
    Landed,
    Corrupt,
}

#[inline(always)]
fn fly<L: Lanes, S: BlockSource, A: Answers>(
    lanes: L,
    room: &mut Batch,
    source: &mut S,
    rays: &[Ray],
    answers: &mut A,
) -> Result<(), TraceError<S::Error>> {
    let mut queue = rays.iter().enumerate();
    let none = PreparedRay::NONE;
    let prepared = lanes.ray(&none);
    let frame = lanes.frame(&prepared, &NO_HEADER);
    let mut flights = [(); FLIGHTS].map(|()| Flight {
        flying: false,
        index: 0,
        at: Place::ROOT,
        ray: none,
        octants: first_octants(&none),
        prepared,
        frame,
        framed: u32::MAX,
    });
    let mut flying = 0;
    for (flight, levels) in flights.iter_mut().zip(&mut room.levels) {
        flying += usize::from(launch(lanes, flight, levels, &mut queue));
    }
    // One block after the other, each for as many rays as want it.
    while flying > 0 {
        let block = flights.iter().find(|f| f.flying).map_or(0, |f| f.at.block);
        for (flight, levels) in flights.iter_mut().zip(&mut room.levels) {
            while flight.flying && flight.at.block == block {
                match step(lanes, source, flight, levels, answers)? {
                    Step::Going => {}
                    Step::Landed => {
                        flying -= usize::from(!launch(lanes, flight, levels, &mut queue));
                    }
                    Step::Corrupt => {
                        return Err(TraceError::Corrupt { block: flight.at.block });
                    }
                }
            }
        }
    }
    Ok(())
}

/// Gives a flight the next ray, if there is one.
#[inline(always)]
fn launch<'r, L: Lanes>(
    lanes: L,
    flight: &mut Flight<L>,
    levels: &mut Levels,
    queue: &mut impl Iterator<Item = (usize, &'r Ray)>,
) -> bool {
    for (index, ray) in queue {
        let Run { ray, at } = Run::new(ray);
        if ray.is_none() {
            continue;
        }
        levels.live = 0;
        flight.flying = true;
        flight.index = index;
        flight.at = at;
        flight.octants = first_octants(&ray);
        flight.prepared = lanes.ray(&ray);
        flight.ray = ray;
        flight.framed = u32::MAX;
        return true;
    }
    flight.flying = false;
    false
}

/// One visit: of a node, a leaf or a reference.
#[inline(always)]
fn step<L: Lanes, S: BlockSource, A: Answers>(
    lanes: L,
    source: &mut S,
    flight: &mut Flight<L>,
    levels: &mut Levels,
    answers: &mut A,
) -> Result<Step, TraceError<S::Error>> {
    let view = source.block(flight.at.block).map_err(TraceError::Source)?;
    let at = &mut flight.at;
    let child = at.child;
    let mut next = EMPTY;
    if is_node(child) {
        if flight.framed != at.block {
            flight.frame = lanes.frame(&flight.prepared, view.header());
            flight.framed = at.block;
        }
        let Some(node) = view.node(child & INDEX) else { return Ok(Step::Corrupt) };
        if at.spent() {
            return Ok(Step::Corrupt);
        }
        next = visit(lanes, &flight.frame, node, at, levels, &flight.ray, flight.octants);
        at.depth += 1;
    } else if is_leaf(child) {
        let Some(mut query) = answers.query(flight.index) else { return Ok(Step::Corrupt) };
        if leaf(lanes, &view, child, &flight.prepared, &mut flight.ray, &mut query) {
            return Ok(Step::Landed);
        }
    } else if is_ref(child) {
        let Some(to) = view.reference(child & INDEX) else { return Ok(Step::Corrupt) };
        at.enter(to);
        return Ok(Step::Going);
    }
    if next != EMPTY {
        at.child = next;
        return Ok(Step::Going);
    }
    let Some(taken) = take(levels, flight.ray.t_max) else { return Ok(Step::Landed) };
    at.depth = taken.depth;
    at.child = taken.child;
    at.block = taken.block;
    Ok(Step::Going)
}
