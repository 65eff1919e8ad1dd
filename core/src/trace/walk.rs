//! The traversal of a single ray.

use super::cursor::{Cursor, Levels, Place, TraceError};
use super::frame::BoxFrame;
use super::lanes::Lanes;
use super::leaf::leaf;
use super::octant::{Octants, first_octants, ordered};
use super::query::{Any, Closest, Every, Query};
use crate::block::format::{Child, DEPTH_MAX};
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
    cursor.begin(ray);
    resume_closest(lanes, cursor, source)
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
    let mut best = cursor.best;
    let end = walk(lanes, cursor, source, &mut Closest { best: &mut best });
    cursor.best = best;
    end.map(|()| best)
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
    cursor.begin(ray);
    resume_any(lanes, cursor, source)
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
    let mut any = Any { found: false };
    walk(lanes, cursor, source, &mut any)?;
    Ok(any.found)
}

/// Shows every hit of a ray to `visit`, once, in no order that means anything; `true` ends it.
///
/// What is made of the hits must not depend on their order.
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
    cursor.begin(ray);
    walk(lanes, cursor, source, &mut Every { visit })
}

/// What depends on the ray alone.
struct Constant<R> {
    octants: &'static Octants,
    prepared: R,
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
    cursor: &mut Cursor,
    source: &mut S,
    query: &mut Q,
) -> Result<(), TraceError<S::Error>> {
    if !cursor.at.enter && cursor.levels.live == 0 {
        return Ok(());
    }
    let mut ray = cursor.ray;
    let constant = Constant { octants: first_octants(&ray), prepared: lanes.ray(&ray) };
    let mut at = cursor.at;
    loop {
        let view = match source.block(at.block) {
            Ok(view) => view,
            Err(error) => {
                cursor.at = at;
                cursor.ray = ray;
                return Err(TraceError::Source(error));
            }
        };
        match in_block(lanes, &view, &mut at, &mut cursor.levels, &constant, &mut ray, query) {
            Leave::Block => {}
            Leave::Done => return Ok(()),
            Leave::Corrupt => return Err(TraceError::Corrupt { block: at.block }),
        }
    }
}

/// Goes on as far as the block reaches.
#[inline(always)]
fn in_block<L: Lanes, Q: Query>(
    lanes: L,
    view: &BlockView<'_>,
    at: &mut Place,
    levels: &mut Levels,
    constant: &Constant<L::Ray>,
    ray: &mut PreparedRay,
    query: &mut Q,
) -> Leave {
    let frame = lanes.frame(&BoxFrame::new(ray, view.header()));
    loop {
        if at.enter {
            let Some(node) = view.node(at.node) else { return Leave::Corrupt };
            if usize::from(at.depth) >= DEPTH_MAX || at.steps == 0 {
                return Leave::Corrupt;
            }
            at.steps -= 1;
            let level = levels.at_mut(u32::from(at.depth));
            let mask = lanes.slots(&frame, node, ray.t_min, ray.t_max, &mut level.near);
            if mask != 0 {
                level.child = node.child;
                level.block = at.block;
                level.node = at.node;
                level.flip = lanes.flip(constant.octants, node);
                level.pending = ordered(mask, level.flip) as u8;
                levels.live |= 1 << (at.depth & 31);
            }
        }
        loop {
            if levels.live == 0 {
                return Leave::Done;
            }
            let depth = 31 - levels.live.leading_zeros();
            let level = levels.at_mut(depth);
            let slot = level.pending.trailing_zeros() ^ u32::from(level.flip);
            let pending = level.pending & level.pending.wrapping_sub(1);
            let near = level.near.get(slot as usize & 7).copied().unwrap_or(0.0);
            let child = level.child.get(slot as usize & 7).copied().unwrap_or(0);
            let live = if pending == 0 { 1_u32 << depth } else { 0 };
            if near > ray.t_max {
                level.pending = pending;
                levels.live &= !live;
                continue;
            }
            if level.block != at.block {
                at.block = level.block;
                at.enter = false;
                return Leave::Block;
            }
            level.pending = pending;
            levels.live &= !live;
            at.depth = depth as u8 + 1;
            match Child::decode(child) {
                Child::Node(node) => {
                    at.node = node;
                    at.enter = true;
                    break;
                }
                Child::Leaf { first, count } => {
                    if leaf(lanes, view, (first, count), &constant.prepared, ray, query) {
                        return Leave::Done;
                    }
                }
                Child::Ref(index) => {
                    let Some(to) = view.reference(index) else { return Leave::Corrupt };
                    at.block = to.block;
                    at.node = to.node;
                    at.enter = true;
                    return Leave::Block;
                }
                Child::Empty => {}
            }
        }
    }
}
