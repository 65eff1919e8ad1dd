//! The traversal of the expanded top of a tree.

use super::code::EMPTY;
use super::cursor::Levels;
use super::lanes::Lanes;
use super::octant::Octants;
use super::visit::{take, visit_expanded};
use super::walk::{Leave, Run};
use crate::block::ExpandedTop;

/// Its number, among those of blocks. No file has so many.
pub(super) const TOP: u32 = u32::MAX;

/// Goes on as far as the top reaches.
#[inline(always)]
pub(super) fn in_top<L: Lanes>(
    lanes: L,
    top: ExpandedTop<'_>,
    frame: &L::Frame,
    octants: &Octants,
    run: &mut Run,
    levels: &mut Levels,
) -> Leave {
    let Run { ray, at, .. } = run;
    loop {
        while at.child < EMPTY {
            let Some(node) = top.node(at.child) else { return Leave::Corrupt };
            if at.spent() {
                return Leave::Corrupt;
            }
            at.child = visit_expanded(lanes, frame, node, at, levels, ray, octants);
            at.depth += 1;
        }
        if ExpandedTop::is_ref(at.child) {
            let Some(to) = top.reference(at.child) else { return Leave::Corrupt };
            (at.block, at.child) = (to.block, to.node);
            return Leave::Block;
        }
        let Some(taken) = take(levels, ray.t_max) else { return Leave::Exhausted };
        if at.follow(&taken) {
            return Leave::Block;
        }
    }
}
