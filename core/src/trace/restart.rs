//! The way back to what a trail has left behind.

use super::code::{INDEX, is_node, is_ref};
use super::cursor::{Levels, TraceError};
use super::lanes::Lanes;
use super::octant::{Octants, ordered};
use super::visit::{at_slot, take};
use super::walk::Run;
use crate::block::BlockSource;

/// Follows the path of a trail down from the place of the run, visits the node of each level on it again, and leaves the octants that
/// come after the path at their levels, as if the traversal had never stopped. Then takes the next of them; `false`: there is none.
#[inline(always)]
pub(super) fn restart<L: Lanes, S: BlockSource>(
    lanes: L,
    run: &mut Run,
    levels: &mut Levels,
    source: &mut S,
    prepared: &L::Ray,
    octants: &Octants,
) -> Result<bool, TraceError<S::Error>> {
    'block: loop {
        let view = source.block(run.at.block).map_err(TraceError::Source)?;
        if !run.enters(&view, &mut levels.visited) {
            break;
        }
        let Run { ray, at, collapsed, .. } = &mut *run;
        let frame = lanes.frame(prepared, view.header());
        loop {
            if is_ref(at.child) {
                let Some(to) = view.reference(at.child & INDEX) else { break 'block };
                at.enter(to);
                continue 'block;
            }
            let (true, Some(node)) = (is_node(at.child), view.node(at.child & INDEX)) else {
                break 'block;
            };
            if at.spent() {
                break 'block;
            }
            let depth = u32::from(at.depth);
            let level = levels.at_mut(depth);
            let mask = lanes.slots(&frame, node, ray.t_min, ray.t_max, &mut level.near);
            level.hold(&node.child, at.block, lanes.flip(octants, node));
            let met = ordered(mask, level.flip);
            let taken = 1 << (level.taken & 7);
            let pending = met & !(2 * taken - 1);
            level.pending = pending as u8;
            at.depth += 1;
            at.child = at_slot(&node.child, u32::from(level.taken ^ level.flip));
            levels.live |= u32::from(pending != 0) << depth;
            *collapsed &= !(1 << depth);
            // What the ray does not reach any more has nothing left that it reaches.
            let below = u32::MAX.unbounded_shl(depth + 1);
            if met & taken == 0 {
                *collapsed &= !below;
            }
            if *collapsed & below == 0 {
                if let Some(taken) = take(levels, ray.t_max) {
                    at.follow(&taken);
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
