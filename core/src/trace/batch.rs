//! Several rays in flight: a block that was fetched serves all that want it.
//!
//! A source that holds all blocks gets its rays one after the other. (Taking them in turns, with the next node or record
//! asked for in advance, was measured a third slower on a PC with AVX2: the state of a single ray stays in registers. So was
//! taking 4, 8 or 16 of them in waves, all that visit a node, then all that test a leaf and so on, without a branch that waits for
//! the step before it: nothing waits any more, but the steps take a quarter more instructions, and the processor does no more of them at once.)

use super::code::{INDEX, is_leaf, is_node, is_ref};
use super::cursor::{Cursor, TraceError};
use super::group::Crossings;
use super::lanes::Lanes;
use super::leaf::leaf;
use super::query::Query;
use super::stack::{Next, Stack};
use super::tracer::Search;
use super::turn::Turn;
use super::walk::Run;
use crate::block::{BlockSource, NO_HEADER};
use crate::geometry::{PreparedRay, Ray};

/// How many rays are in flight.
pub const FLIGHTS: usize = 8;

/// Room for the rays in flight of a batch: 19 KiB.
#[derive(Debug, Clone)]
pub struct Batch {
    stacks: [Stack; FLIGHTS],
    pub(super) single: Cursor,
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
        Self { stacks: [const { Stack::new() }; FLIGHTS], single: Cursor::new() }
    }
}

/// A search of many rays, as many in flight as there is room for.
pub(super) struct Many;

impl Search for Many {
    type Room = Batch;
    type Rays = [Ray];
    type Queries<Q> = [Q];

    #[inline(always)]
    fn run<L: Lanes, S: BlockSource, Q: Query>(
        lanes: L,
        room: &mut Batch,
        source: &mut S,
        rays: &[Ray],
        queries: &mut [Q],
    ) -> Result<(), TraceError<S::Error>> {
        fly(lanes, room, source, rays, queries)
    }
}

/// A ray in flight.
struct Flight<L: Lanes> {
    /// It has a ray.
    flying: bool,
    index: usize,
    ray: PreparedRay,
    run: Run,
    turn: Turn,
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
fn fly<L: Lanes, S: BlockSource, Q: Query>(
    lanes: L,
    room: &mut Batch,
    source: &mut S,
    rays: &[Ray],
    queries: &mut [Q],
) -> Result<(), TraceError<S::Error>> {
    let mut queue = rays.iter().enumerate();
    let none = PreparedRay::NONE;
    let prepared = lanes.ray(&none);
    let frame = lanes.frame(&prepared, &NO_HEADER);
    let mut flights = [(); FLIGHTS].map(|()| Flight {
        flying: false,
        index: 0,
        ray: none,
        run: Run::new(&none, false),
        turn: Turn::of(&none),
        prepared,
        frame,
        framed: u32::MAX,
    });
    let mut crossings = Crossings::NONE;
    let mut flying = 0;
    for flight in &mut flights {
        flying += usize::from(launch(lanes, flight, &mut queue));
    }
    // One block after the other, each for as many rays as want it.
    while flying > 0 {
        let block = flights.iter().find(|f| f.flying).map_or(0, |f| f.run.at.block);
        for (flight, stack) in flights.iter_mut().zip(&mut room.stacks) {
            while flight.flying && flight.run.at.block == block {
                match step(lanes, source, flight, stack, &mut crossings, queries)? {
                    Step::Going => {}
                    Step::Landed => {
                        flying -= usize::from(!launch(lanes, flight, &mut queue));
                    }
                    Step::Corrupt => {
                        return Err(TraceError::Corrupt { block: flight.run.at.block });
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
    queue: &mut impl Iterator<Item = (usize, &'r Ray)>,
) -> bool {
    for (index, ray) in queue {
        let ray = PreparedRay::new(ray);
        if ray.is_none() {
            continue;
        }
        flight.flying = true;
        flight.index = index;
        flight.turn = Turn::of(&ray);
        flight.prepared = lanes.ray(&ray);
        flight.run = Run::new(&ray, false);
        flight.ray = ray;
        flight.framed = u32::MAX;
        return true;
    }
    flight.flying = false;
    false
}

/// One visit: of a node, a leaf or a reference.
#[inline(always)]
fn step<L: Lanes, S: BlockSource, Q: Query>(
    lanes: L,
    source: &mut S,
    flight: &mut Flight<L>,
    stack: &mut Stack,
    crossings: &mut Crossings,
    queries: &mut [Q],
) -> Result<Step, TraceError<S::Error>> {
    let view = source.block(flight.run.at.block).map_err(TraceError::Source)?;
    let Run { t_min, t_max, at, height, .. } = &mut flight.run;
    let child = at.child();
    if is_node(child) {
        if flight.framed != at.block {
            flight.frame = lanes.frame(&flight.prepared, view.header());
            flight.framed = at.block;
        }
        let Some(node) = view.node(child & INDEX) else { return Ok(Step::Corrupt) };
        let (false, Some(places)) = (at.spent(), stack.places(height)) else {
            return Ok(Step::Corrupt);
        };
        let span = (*t_min, *t_max);
        let met = lanes.visit(&flight.frame, node, flight.turn, span, at.entry.tag(), places);
        if met.count > 0 {
            stack.descend(height, at, met);
            return Ok(Step::Going);
        }
    } else if is_leaf(child) {
        let Some(query) = queries.get_mut(flight.index) else { return Ok(Step::Corrupt) };
        let ray = &mut flight.ray;
        if leaf(lanes, &view, child, &flight.prepared, crossings, ray, t_max, query) {
            return Ok(Step::Landed);
        }
    } else if is_ref(child) {
        let sound = flight.run.follow(&view, stack);
        return Ok(if sound { Step::Going } else { Step::Corrupt });
    }
    match stack.next(height, at, *t_max) {
        Next::Nowhere => Ok(Step::Landed),
        Next::Here | Next::Elsewhere => Ok(Step::Going),
    }
}
