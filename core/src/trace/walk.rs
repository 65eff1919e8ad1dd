//! The traversal of a single ray.

use super::code::{INDEX, is_leaf, is_node, is_ref};
use super::cursor::{Cursor, Levels, Place, Run, TraceError};
use super::lanes::Lanes;
use super::leaf::leaf;
use super::octant::{Octants, first_octants};
use super::query::{Any, Closest, Every, Query};
use super::visit::{take, visit};
use crate::block::{BlockSource, BlockView};
use crate::geometry::{Hit, PreparedRay, Ray};

/// The closest hit of a ray.
///
/// # Errors
/// [`TraceError`]; after `Source` it goes on with [`resume_closest`].
#[inline(always)]
pub fn closest<L: Lanes, S: BlockSource>(
    lanes: L,
    cursor: &mut Cursor,
    source: &mut S,
    ray: &Ray,
) -> Result<Option<Hit>, TraceError<S::Error>> {
    let mut run = Run::new(ray);
    let mut closest = Closest { best: None };
    cursor.levels.live = 0;
    match walk(lanes, &mut run, &mut cursor.levels, source, &mut closest) {
        Ok(()) => Ok(closest.best),
        Err(error) => {
            cursor.stop(run, closest.best);
            Err(error)
        }
    }
}

/// Goes on with a closest hit that its source has stopped.
///
/// # Errors
/// As [`closest`].
#[inline(always)]
pub fn resume_closest<L: Lanes, S: BlockSource>(
    lanes: L,
    cursor: &mut Cursor,
    source: &mut S,
) -> Result<Option<Hit>, TraceError<S::Error>> {
    let mut run = cursor.run;
    let mut closest = Closest { best: cursor.best };
    match walk(lanes, &mut run, &mut cursor.levels, source, &mut closest) {
        Ok(()) => Ok(closest.best),
        Err(error) => {
            cursor.stop(run, closest.best);
            Err(error)
        }
    }
}

/// Whether a ray hits anything.
///
/// # Errors
/// [`TraceError`]; after `Source` it goes on with [`resume_any`].
#[inline(always)]
pub fn any<L: Lanes, S: BlockSource>(
    lanes: L,
    cursor: &mut Cursor,
    source: &mut S,
    ray: &Ray,
) -> Result<bool, TraceError<S::Error>> {
    let mut run = Run::new(ray);
    let mut any = Any { found: false };
    cursor.levels.live = 0;
    match walk(lanes, &mut run, &mut cursor.levels, source, &mut any) {
        Ok(()) => Ok(any.found),
        Err(error) => {
            cursor.stop(run, None);
            Err(error)
        }
    }
}

/// Goes on with an any hit that its source has stopped.
///
/// # Errors
/// As [`any`].
#[inline(always)]
pub fn resume_any<L: Lanes, S: BlockSource>(
    lanes: L,
    cursor: &mut Cursor,
    source: &mut S,
) -> Result<bool, TraceError<S::Error>> {
    let mut run = cursor.run;
    let mut any = Any { found: false };
    match walk(lanes, &mut run, &mut cursor.levels, source, &mut any) {
        Ok(()) => Ok(any.found),
        Err(error) => {
            cursor.stop(run, None);
            Err(error)
        }
    }
}

/// Shows every hit of a ray to `visit`, once, in no order that means anything; `true` ends it.
///
/// What is made of the hits must not depend on their order. After an error of the source it begins anew.
///
/// # Errors
/// [`TraceError`].
#[inline(always)]
pub fn every<L: Lanes, S: BlockSource>(
    lanes: L,
    cursor: &mut Cursor,
    source: &mut S,
    ray: &Ray,
    visit: impl FnMut(&Hit) -> bool,
) -> Result<(), TraceError<S::Error>> {
    cursor.levels.live = 0;
    walk(lanes, &mut Run::new(ray), &mut cursor.levels, source, &mut Every { visit })
}

/// Why the traversal leaves a block.
enum Leave {
    /// It needs the block of its place.
    Block,
    /// It has visited all, or the query has ended it.
    Done,
    /// The block is not sound.
    Corrupt,
}

#[inline(always)]
fn walk<L: Lanes, S: BlockSource, Q: Query>(
    lanes: L,
    run: &mut Run,
    levels: &mut Levels,
    source: &mut S,
    query: &mut Q,
) -> Result<(), TraceError<S::Error>> {
    if run.ray.is_none() {
        return Ok(());
    }
    let octants = first_octants(&run.ray);
    let prepared = lanes.ray(&run.ray);
    loop {
        let view = source.block(run.at.block).map_err(TraceError::Source)?;
        let frame = lanes.frame(&prepared, view.header());
        let fixed = Fixed { lanes, view: &view, frame, prepared: &prepared, octants };
        match in_block(&fixed, &mut run.at, levels, &mut run.ray, query) {
            Leave::Block => {}
            Leave::Done => return Ok(()),
            Leave::Corrupt => return Err(TraceError::Corrupt { block: run.at.block }),
        }
    }
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
    at: &mut Place,
    levels: &mut Levels,
    ray: &mut PreparedRay,
    query: &mut Q,
) -> Leave {
    let &Fixed { lanes, view, frame, prepared, octants } = fixed;
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
            if leaf(lanes, view, at.child, prepared, ray, query) {
                return Leave::Done;
            }
        } else if is_ref(at.child) {
            let Some(to) = view.reference(at.child & INDEX) else { return Leave::Corrupt };
            at.enter(to);
            return Leave::Block;
        }
        let Some(taken) = take(levels, ray.t_max) else { return Leave::Done };
        at.child = taken.child;
        at.depth = taken.depth;
        if taken.block != at.block {
            at.block = taken.block;
            return Leave::Block;
        }
    }
}
