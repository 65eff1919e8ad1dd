//! The traversal of a single ray.

use super::code::{EMPTY, INDEX, is_leaf, is_node, is_ref};
use super::cursor::{Cursor, Levels, Place, Run, TraceError};
use super::lanes::Lanes;
use super::leaf::leaf;
use super::octant::{Octants, first_octants, ordered};
use super::query::{Any, Closest, Every, Query};
use crate::block::format::DEPTH_MAX;
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
    if !run.at.enter && levels.live == 0 {
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
    let block = at.block;
    let mut enter = at.enter;
    loop {
        let mut child = EMPTY;
        if enter {
            let Some(node) = view.node(at.node) else { return Leave::Corrupt };
            if usize::from(at.depth) >= DEPTH_MAX || at.steps == 0 {
                return Leave::Corrupt;
            }
            at.steps -= 1;
            let level = levels.at_mut(u32::from(at.depth));
            let mask = lanes.slots(&frame, node, ray.t_min, ray.t_max, &mut level.near);
            if mask != 0 {
                let flip = lanes.flip(octants, node);
                let pending = ordered(mask, flip);
                let slot = pending.trailing_zeros() ^ u32::from(flip);
                let pending = pending & (pending - 1);
                child = at_slot(&node.child, slot);
                if pending != 0 {
                    level.child = node.child;
                    level.block = block;
                    level.node = at.node;
                    level.flip = flip;
                    level.pending = pending as u8;
                    levels.live |= 1 << (at.depth & 31);
                }
            }
        }
        while !is_node(child) {
            if is_leaf(child) {
                if leaf(lanes, view, child, prepared, ray, query) {
                    return Leave::Done;
                }
            } else if is_ref(child) {
                let Some(to) = view.reference(child & INDEX) else { return Leave::Corrupt };
                at.block = to.block;
                at.node = to.node;
                at.depth += 1;
                at.enter = true;
                return Leave::Block;
            }
            // Back to the deepest level with a child left that the ray may still reach.
            child = loop {
                if levels.live == 0 {
                    return Leave::Done;
                }
                let depth = 31 - levels.live.leading_zeros();
                let level = levels.at_mut(depth);
                let pending = u32::from(level.pending);
                let slot = pending.trailing_zeros() ^ u32::from(level.flip);
                let beyond = level.near.get(slot as usize & 7).is_some_and(|&t| t > ray.t_max);
                if !beyond && level.block != block {
                    at.block = level.block;
                    at.enter = false;
                    return Leave::Block;
                }
                let pending = pending & pending.wrapping_sub(1);
                level.pending = pending as u8;
                let child = at_slot(&level.child, slot);
                levels.live &= !(u32::from(pending == 0) << depth);
                if !beyond {
                    at.depth = depth as u8;
                    break child;
                }
            };
        }
        at.node = child & INDEX;
        at.depth += 1;
        enter = true;
    }
}

/// The child in a slot, as its bits.
#[inline(always)]
fn at_slot(children: &[u16; 8], slot: u32) -> u16 {
    children.get(slot as usize & 7).copied().unwrap_or(EMPTY)
}
