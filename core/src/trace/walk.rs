//! The traversal of a single ray.

use super::code::{EMPTY, INDEX, is_leaf, is_node, is_ref, records};
use super::cursor::{Cursor, Place, TraceError, Visited};
use super::group::Crossings;
use super::lanes::Lanes;
use super::leaf::leaf;
use super::query::Query;
use super::restart::restart;
use super::stack::{Height, Next, Stack};
use super::top::{TOP, in_top};
use super::tracer::Search;
use super::turn::Turn;
use crate::block::format::Child;
use crate::block::{BlockSource, BlockView, ExpandedTop};
use crate::geometry::{PreparedRay, Ray};
use crate::real::Part;

/// A search of a single ray: from the root, or from the cursor's trail.
pub(super) struct Single<const CONTINUED: bool>;

impl<const CONTINUED: bool> Search for Single<CONTINUED> {
    type Room = Cursor;
    type Rays = Ray;
    type Queries<Q> = Q;

    #[inline(always)]
    fn run<L: Lanes, S: BlockSource, Q: Query>(
        lanes: L,
        cursor: &mut Cursor,
        source: &mut S,
        ray: &Ray,
        query: &mut Q,
    ) -> Result<(), TraceError<S::Error>> {
        let Some(prepared) = lanes.prepare(ray, &mut cursor.ray) else { return Ok(()) };
        let mut run = Run::new(&cursor.ray, CONTINUED);
        query.shorten(&mut run.t_max);
        if run.t_min > run.t_max {
            return Ok(());
        }
        if CONTINUED {
            let Some((at, collapsed)) = cursor.trail.lay(&mut cursor.stack) else {
                return Err(TraceError::Corrupt { block: cursor.trail.block() });
            };
            (run.at, run.collapsed) = (at, collapsed);
        } else if source.holds_all() && !source.top().is_empty() {
            run.at.block = TOP;
        }
        let result = walk::<CONTINUED, _, _, _>(lanes, &prepared, &mut run, cursor, source, query);
        cursor.count(&run.at);
        if let Err(TraceError::Source(_)) = result {
            cursor.stop(run.at, run.height, run.collapsed, run.t_max);
        }
        result
    }
}

/// What a traversal keeps in registers as far as it can.
#[derive(Clone, Copy)]
pub(super) struct Run {
    /// Of the ray.
    pub(super) t_min: f32,
    /// The ray's, or that of the best hit so far.
    pub(super) t_max: f32,
    pub(super) at: Place,
    pub(super) height: Height,
    /// Bit `d`: level `d` may have children left, which are not known any more.
    pub(super) collapsed: u32,
    /// The place is a trail's, and may be anything.
    unchecked: bool,
}

impl Run {
    /// Of a ray, from the root on.
    #[inline(always)]
    pub(super) fn new(ray: &PreparedRay, unchecked: bool) -> Self {
        let &PreparedRay { t_min, t_max, .. } = ray;
        Self { t_min, t_max, at: Place::ROOT, height: Height::NONE, collapsed: 0, unchecked }
    }

    /// Enters a block. `false`: the block does not have what the trail says.
    #[inline(always)]
    pub(super) fn enters(&mut self, view: &BlockView<'_>, visited: &mut Visited) -> bool {
        visited.blocks = visited.blocks.wrapping_add(1);
        !core::mem::take(&mut self.unchecked) || has(view, self.at.child())
    }

    /// Goes through a reference. `false`: the block is not sound.
    #[inline(always)]
    #[must_use]
    pub(super) fn follow(&mut self, view: &BlockView<'_>, stack: &mut Stack) -> bool {
        let Some(to) = view.reference(self.at.child() & INDEX) else { return false };
        let left = stack.leave(&mut self.height, self.at.block);
        self.at.enter(to);
        left
    }
}

/// Whether a block has a child.
#[cold]
#[inline(never)]
fn has(view: &BlockView<'_>, child: u16) -> bool {
    let header = view.header();
    match Child::decode(child) {
        Child::Node(node) => node < header.nodes,
        Child::Ref(index) => index < header.refs,
        Child::Leaf { at, count } => view.has_records(at, count),
        Child::Empty => true,
    }
}

/// Goes on until all is visited, the query ends it, or a block is not there.
#[inline(always)]
fn walk<const CONTINUED: bool, L: Lanes, S: BlockSource, Q: Query>(
    lanes: L,
    prepared: &L::Ray,
    run: &mut Run,
    cursor: &mut Cursor,
    source: &mut S,
    query: &mut Q,
) -> Result<(), TraceError<S::Error>> {
    // A source that has all blocks stops nothing, and a trail is never needed.
    let trails = !source.holds_all();
    let turn = Turn::new(cursor.ray.signs, !CONTINUED && !trails && !query.shortens());
    // Of what was just prepared: the first node would wait for it to be read again.
    let mut of_top = lanes.frame(prepared, &ExpandedTop::FRAME);
    // The path of the trail leads on below the place.
    let mut restarts = run.collapsed.unbounded_shr(u32::from(run.at.entry.level())) != 0;
    loop {
        if CONTINUED && restarts && !restart(lanes, run, cursor, source, prepared, turn)? {
            return Ok(());
        }
        restarts = false;
        if !trails && run.at.block == TOP {
            match in_top(lanes, prepared, &mut of_top, turn, run, cursor, source, query)? {
                Leave::Block => {}
                Leave::Corrupt => return Err(TraceError::Corrupt { block: 0 }),
                Leave::Done | Leave::Exhausted => return Ok(()),
            }
        }
        let Cursor { ray, stack, visited, crossings, .. } = &mut *cursor;
        let view = source.block(run.at.block).map_err(TraceError::Source)?;
        if !run.enters(&view, visited) {
            return Err(TraceError::Corrupt { block: run.at.block });
        }
        let within = InBlock {
            lanes,
            view: &view,
            prepared,
            turn,
            trails,
            run: *run,
            stack,
            crossings,
            ray,
            query: &mut *query,
        };
        // Beside a top, where few rays come this far, a call would cost all of them registers; where there is none this is all that they do.
        let (leave, left) = lanes.apart(trails, within);
        *run = left;
        match leave {
            Leave::Block => {}
            Leave::Done => return Ok(()),
            Leave::Corrupt => return Err(TraceError::Corrupt { block: run.at.block }),
            Leave::Exhausted => {
                if run.collapsed == 0 {
                    return Ok(());
                }
                run.at.leave();
                restarts = true;
            }
        }
    }
}

/// Why the traversal leaves a block, or the top.
pub(super) enum Leave {
    /// It needs the block of its place.
    Block,
    /// Nothing waits.
    Exhausted,
    /// The query has ended it.
    Done,
    /// The block is not sound.
    Corrupt,
}

/// The way of a ray through a block.
struct InBlock<'a, 'v, L: Lanes, Q> {
    lanes: L,
    view: &'a BlockView<'v>,
    prepared: &'a L::Ray,
    turn: Turn,
    trails: bool,
    run: Run,
    stack: &'a mut Stack,
    crossings: &'a mut Crossings,
    ray: &'a mut PreparedRay,
    query: &'a mut Q,
}

impl<L: Lanes, Q: Query> Part for InBlock<'_, '_, L, Q> {
    type Result = (Leave, Run);

    /// Goes on as far as the block reaches.
    #[inline(always)]
    fn run(self) -> (Leave, Run) {
        let Self { lanes, view, prepared, turn, trails, mut run, stack, crossings, ray, query } =
            self;
        // Some blocks are entered for a leaf, which takes none.
        let mut frame = None;
        let mut child = run.at.child();
        let leave = 'block: loop {
            while is_node(child) {
                let Run { t_min, t_max, at, height, .. } = &mut run;
                let Some(node) = view.node(child & INDEX) else { break 'block Leave::Corrupt };
                if at.spent() {
                    break 'block Leave::Corrupt;
                }
                let Some(places) = stack.places(height) else { break 'block Leave::Corrupt };
                let frame = frame.get_or_insert_with(|| lanes.frame(prepared, view.header()));
                let span = (*t_min, *t_max);
                let met = lanes.visit(frame, node, turn, span, at.entry.tag(), places);
                if met.count == 0 {
                    at.is_empty();
                    child = EMPTY;
                    break;
                }
                stack.descend(height, at, met);
                // Apart from the entry: the next node waits for the child, and not for its place.
                child = met.first as u16;
                if trails {
                    stack.note(at.entry);
                }
            }
            if is_leaf(child) {
                run.at.tests();
                let (first, count) = records(child);
                let records = view.leaf(first, count);
                // The frame, made only where a node is met, is not saved for calls here.
                if leaf(
                    lanes,
                    view,
                    records,
                    prepared,
                    crossings,
                    ray,
                    &mut run.t_max,
                    query,
                    |_| {},
                ) {
                    break Leave::Done;
                }
            } else if is_ref(child) {
                break if run.follow(view, stack) { Leave::Block } else { Leave::Corrupt };
            }
            let t_max = query.shortens().then_some(run.t_max);
            let next = stack.next(&mut run.height, &mut run.at, t_max);
            if next == Next::Nowhere {
                break Leave::Exhausted;
            }
            if trails {
                stack.note(run.at.entry);
            }
            if next == Next::Elsewhere {
                break Leave::Block;
            }
            child = run.at.child();
        };
        (leave, run)
    }
}
