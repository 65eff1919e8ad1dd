//! The traversal of a single ray.

use super::code::{INDEX, is_leaf, is_node, is_ref};
use super::cursor::{Cursor, Levels, Place, TraceError, Visited};
use super::group::Crossings;
use super::lanes::Lanes;
use super::leaf::leaf;
use super::octant::{Octants, first_octants};
use super::query::Query;
use super::restart::restart;
use super::top::{TOP, in_top};
use super::tracer::Search;
use super::visit::{take, visit};
use crate::block::format::{BlockHeader, Child};
use crate::block::{BlockSource, BlockView, ExpandedTop};
use crate::geometry::{PreparedRay, Ray};

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
        let mut ray = PreparedRay::new(ray);
        query.shorten(&mut ray);
        if ray.is_none() {
            return Ok(());
        }
        let mut run = Run { ray, at: Place::ROOT, collapsed: 0, unchecked: CONTINUED };
        cursor.levels.live = 0;
        if CONTINUED {
            let Some((at, collapsed)) = cursor.trail.lay(&mut cursor.levels) else {
                return Err(TraceError::Corrupt { block: cursor.trail.block() });
            };
            (run.at, run.collapsed) = (at, collapsed);
        } else if !source.top().is_empty() {
            run.at.block = TOP;
        }
        let result = walk(lanes, &mut run, &mut cursor.levels, source, query);
        cursor.count(&run.at);
        if let Err(TraceError::Source(_)) = result {
            cursor.stop(run.at, run.collapsed, run.ray.t_max);
        }
        result
    }
}

/// What a traversal keeps in registers as far as it can.
pub(super) struct Run {
    pub(super) ray: PreparedRay,
    pub(super) at: Place,
    /// Bit `d`: level `d` may have children left, which are not known any more.
    pub(super) collapsed: u32,
    /// The place is a trail's, and may be anything.
    unchecked: bool,
}

impl Run {
    /// Enters a block. `false`: the block does not have what the trail says.
    #[inline(always)]
    pub(super) fn enters(&mut self, view: &BlockView<'_>, visited: &mut Visited) -> bool {
        visited.blocks = visited.blocks.wrapping_add(1);
        !core::mem::take(&mut self.unchecked) || has(view.header(), self.at.child)
    }
}

/// Whether a block has a child.
#[cold]
#[inline(never)]
fn has(header: &BlockHeader, child: u16) -> bool {
    match Child::decode(child) {
        Child::Node(node) => node < header.nodes,
        Child::Ref(index) => index < header.refs,
        Child::Leaf { first, count } => first.saturating_add(count) <= header.records,
        Child::Empty => true,
    }
}

/// Goes on until all is visited, the query ends it, or a block is not there.
#[inline(always)]
fn walk<L: Lanes, S: BlockSource, Q: Query>(
    lanes: L,
    run: &mut Run,
    levels: &mut Levels,
    source: &mut S,
    query: &mut Q,
) -> Result<(), TraceError<S::Error>> {
    let octants = first_octants(&run.ray);
    let prepared = lanes.ray(&run.ray);
    let mut crossings = Crossings::default();
    let top_frame = lanes.frame(&prepared, &ExpandedTop::FRAME);
    // The path of the trail leads on below the place.
    let mut restarts = run.collapsed.unbounded_shr(u32::from(run.at.depth)) != 0;
    loop {
        if restarts && !restart(lanes, run, levels, source, &prepared, octants)? {
            return Ok(());
        }
        restarts = false;
        let top = source.top();
        if !top.is_empty() && run.at.block == TOP {
            match in_top(lanes, top, &top_frame, octants, run, levels) {
                Leave::Block => {}
                Leave::Corrupt => return Err(TraceError::Corrupt { block: 0 }),
                Leave::Done | Leave::Exhausted => return Ok(()),
            }
        }
        let view = source.block(run.at.block).map_err(TraceError::Source)?;
        if !run.enters(&view, &mut levels.visited) {
            return Err(TraceError::Corrupt { block: run.at.block });
        }
        let frame = lanes.frame(&prepared, view.header());
        let fixed = Fixed { lanes, view: &view, frame, prepared: &prepared, octants };
        match in_block(&fixed, run, levels, &mut crossings, query) {
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
    /// No level has children left.
    Exhausted,
    /// The query has ended it.
    Done,
    /// The block is not sound.
    Corrupt,
}

/// What does not change within a block.
struct Fixed<'a, L: Lanes> {
    lanes: L,
    view: &'a BlockView<'a>,
    frame: L::Frame,
    prepared: &'a L::Ray,
    octants: &'static Octants,
}

/// Goes on as far as the block reaches.
#[inline(always)]
fn in_block<L: Lanes, Q: Query>(
    fixed: &Fixed<'_, L>,
    run: &mut Run,
    levels: &mut Levels,
    crossings: &mut Crossings,
    query: &mut Q,
) -> Leave {
    let &Fixed { lanes, view, frame, prepared, octants } = fixed;
    let Run { ray, at, .. } = run;
    loop {
        while is_node(at.child) {
            let Some(node) = view.node(at.child & INDEX) else { return Leave::Corrupt };
            if at.spent() {
                return Leave::Corrupt;
            }
            at.child = visit(lanes, &frame, node, at, levels, ray, octants);
            at.depth += 1;
        }
        if is_leaf(at.child) {
            at.tests();
            if leaf(lanes, view, at.child, prepared, crossings, ray, query) {
                return Leave::Done;
            }
        } else if is_ref(at.child) {
            let Some(to) = view.reference(at.child & INDEX) else { return Leave::Corrupt };
            at.enter(to);
            return Leave::Block;
        }
        let Some(taken) = take(levels, ray.t_max) else { return Leave::Exhausted };
        if at.follow(&taken) {
            return Leave::Block;
        }
    }
}
