//! The traversal of a single ray.

use super::code::{INDEX, is_leaf, is_node, is_ref, records};
use super::cursor::{Cursor, Levels, Place, STEPS_MAX, TraceError};
use super::lanes::Lanes;
use super::leaf::leaf;
use super::octant::{Octants, first_octants};
use super::query::Query;
use super::restart::restart;
use super::tracer::Search;
use super::trail::Trail;
use super::visit::{take, visit};
use crate::block::format::Child;
use crate::block::{BlockSource, BlockView};
use crate::geometry::{PreparedRay, Ray};

/// A search of a single ray, from a trail on.
pub(super) struct Single<'a, S, Q> {
    pub(super) cursor: &'a mut Cursor,
    pub(super) source: &'a mut S,
    pub(super) ray: &'a Ray,
    pub(super) trail: &'a Trail,
    pub(super) query: Q,
}

impl<S: BlockSource, Q: Query> Search for Single<'_, S, Q> {
    type Answer = Result<(), TraceError<S::Error>>;

    #[inline(always)]
    fn run<L: Lanes>(mut self, lanes: L) -> Self::Answer {
        walk(lanes, self.cursor, self.source, self.ray, self.trail, &mut self.query)
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
    /// As [`Visited`](super::Visited) has them.
    leaves: u32,
    blocks: u32,
}

impl Run {
    /// Counts a block that is entered. `false`: the block does not have what the trail says.
    #[inline(always)]
    pub(super) fn enters(&mut self, view: &BlockView<'_>) -> bool {
        self.blocks = self.blocks.wrapping_add(1);
        !core::mem::take(&mut self.unchecked) || has(view, self.at.child)
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
        Child::Leaf { first, count } => first.saturating_add(count) <= header.records,
        Child::Empty => true,
    }
}

/// Shows the hits of a ray to a query, from a trail on. When its source stops it, the cursor has the trail to go on by.
#[inline(always)]
pub(super) fn walk<L: Lanes, S: BlockSource, Q: Query>(
    lanes: L,
    cursor: &mut Cursor,
    source: &mut S,
    ray: &Ray,
    trail: &Trail,
    query: &mut Q,
) -> Result<(), TraceError<S::Error>> {
    let mut ray = PreparedRay::new(ray);
    query.begin(&mut ray);
    if ray.is_none() {
        return Ok(());
    }
    let Some((at, collapsed)) = trail.lay(&mut cursor.levels) else {
        return Err(TraceError::Corrupt { block: trail.block() });
    };
    let unchecked = *trail != Trail::START;
    let mut run = Run { ray, at, collapsed, unchecked, leaves: 0, blocks: 0 };
    let result = through_blocks(lanes, &mut run, &mut cursor.levels, source, query);
    let visited = &mut cursor.visited;
    visited.nodes = visited.nodes.wrapping_add(u64::from(STEPS_MAX - run.at.steps));
    visited.leaves = visited.leaves.wrapping_add(u64::from(run.leaves));
    visited.blocks = visited.blocks.wrapping_add(u64::from(run.blocks));
    if let Err(TraceError::Source(_)) = result {
        cursor.stop(&run.at, run.collapsed, run.ray.t_max);
    }
    result
}

/// Goes on until all is visited, the query ends it, or a block is not there.
#[inline(always)]
fn through_blocks<L: Lanes, S: BlockSource, Q: Query>(
    lanes: L,
    run: &mut Run,
    levels: &mut Levels,
    source: &mut S,
    query: &mut Q,
) -> Result<(), TraceError<S::Error>> {
    let octants = first_octants(&run.ray);
    let prepared = lanes.ray(&run.ray);
    // The path of the trail leads on below the place.
    if run.collapsed.unbounded_shr(u32::from(run.at.depth)) != 0
        && !restart(lanes, run, levels, source, &prepared, octants)?
    {
        return Ok(());
    }
    loop {
        let view = source.block(run.at.block).map_err(TraceError::Source)?;
        if !run.enters(&view) {
            return Err(TraceError::Corrupt { block: run.at.block });
        }
        let frame = lanes.frame(&prepared, view.header());
        let fixed = Fixed { lanes, view: &view, frame, prepared: &prepared, octants };
        match in_block(&fixed, run, levels, query) {
            Leave::Block => {}
            Leave::Done => return Ok(()),
            Leave::Corrupt => return Err(TraceError::Corrupt { block: run.at.block }),
            Leave::Exhausted => {
                if run.collapsed == 0 {
                    return Ok(());
                }
                run.at.leave();
                if !restart(lanes, run, levels, source, &prepared, octants)? {
                    return Ok(());
                }
            }
        }
    }
}

/// Why the traversal leaves a block.
enum Leave {
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
    query: &mut Q,
) -> Leave {
    let &Fixed { lanes, view, frame, prepared, octants } = fixed;
    let Run { ray, at, leaves, .. } = run;
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
            *leaves = leaves.wrapping_add(u32::from(records(at.child).1));
            if leaf(lanes, view, at.child, prepared, ray, query) {
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
