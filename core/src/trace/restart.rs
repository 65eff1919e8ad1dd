//! The way back to what a trail has left behind.

use super::code::{INDEX, is_node, is_ref};
use super::cursor::{Cursor, TraceError};
use super::lanes::Lanes;
use super::stack::{Entry, Next};
use super::turn::Turn;
use super::walk::Run;
use crate::block::BlockSource;

/// Follows the path of a trail down from the place of the run, visits the node of each level on it again, and leaves the children that
/// come after the path, as if the traversal had never stopped. Then takes the next of them; `false`: there is none.
#[inline(always)]
pub(super) fn restart<L: Lanes, S: BlockSource>(
    lanes: L,
    run: &mut Run,
    cursor: &mut Cursor,
    source: &mut S,
    prepared: &L::Ray,
    turn: Turn,
) -> Result<bool, TraceError<S::Error>> {
    let Cursor { stack, visited, .. } = cursor;
    'block: loop {
        let view = source.block(run.at.block).map_err(TraceError::Source)?;
        if !run.enters(&view, visited) {
            break;
        }
        let frame = lanes.frame(prepared, view.header());
        loop {
            if is_ref(run.at.child()) {
                if run.follow(&view, stack) {
                    continue 'block;
                }
                break 'block;
            }
            let Run { t_min, t_max, at, height, collapsed, .. } = &mut *run;
            let (true, Some(node)) = (is_node(at.child()), view.node(at.child() & INDEX)) else {
                break 'block;
            };
            let level = u32::from(at.entry.level());
            let taken = stack.taken().get(level as usize).copied().unwrap_or(0) & 7;
            let (false, Some(places)) = (at.spent(), stack.places(height)) else { break 'block };
            let tag = at.entry.tag();
            let met = lanes.visit(&frame, node, turn, (*t_min, *t_max), tag, places);
            let is_met = stack.keep_behind(height, met, taken);
            let slot = turn.slot(turn.of_node(&node.order), u32::from(taken));
            let child = node.child.get(slot).copied().unwrap_or(0);
            at.entry = Entry(u32::from(child) | u32::from(taken) << 16 | tag);
            *collapsed &= !(1 << level);
            // What the ray does not reach any more has nothing left that it reaches.
            let below = u32::MAX.unbounded_shl(level + 1);
            if !is_met {
                *collapsed &= !below;
            }
            if *collapsed & below == 0 {
                let next = stack.next(height, at, Some(*t_max));
                if next != Next::Nowhere {
                    stack.note(at.entry);
                    return Ok(true);
                }
                if *collapsed == 0 {
                    return Ok(false);
                }
                at.leave();
                continue 'block;
            }
        }
    }
    Err(TraceError::Corrupt { block: run.at.block })
}
