//! The steps that single rays and batches share.

use super::code::EMPTY;
use super::cursor::{Levels, Place};
use super::lanes::Lanes;
use super::octant::{Octants, Visits, flip_of};
use crate::block::ExpandedNode;
use crate::block::format::Node;
use crate::geometry::PreparedRay;

/// Visits a node at `at`: returns the child that the ray meets first, and leaves the others at the
/// node's level.
#[inline(always)]
pub(super) fn visit<L: Lanes>(
    lanes: L,
    frame: &L::Frame,
    node: &Node,
    at: &Place,
    levels: &mut Levels,
    ray: &PreparedRay,
    octants: &Octants,
) -> u16 {
    let level = levels.at_mut(u32::from(at.depth));
    let mask = lanes.slots(frame, node, ray.t_min, ray.t_max, &mut level.near);
    if mask == 0 {
        return EMPTY;
    }
    enter(mask, lanes.flip(octants, node), &node.child, at, levels)
}

/// Visits a node of the expanded top.
///
/// What it shares with [`visit`] is [`enter`], but not the test: given to `enter` as a closure, it is compiled without the instructions of the
/// lanes, and a picture takes half as long again.
#[inline(always)]
pub(super) fn visit_expanded<L: Lanes>(
    lanes: L,
    frame: &L::Frame,
    node: &ExpandedNode,
    at: &Place,
    levels: &mut Levels,
    ray: &PreparedRay,
    octants: &Octants,
) -> u16 {
    let level = levels.at_mut(u32::from(at.depth));
    let mask = lanes.expanded_slots(frame, node, ray.t_min, ray.t_max, &mut level.near);
    if mask == 0 {
        return EMPTY;
    }
    enter(mask, flip_of(octants, node.axes), &node.child, at, levels)
}

/// The child that is visited first, of those that are met; the others are left at the level.
#[inline(always)]
fn enter(mask: u32, flip: u8, child: &[u16; 8], at: &Place, levels: &mut Levels) -> u16 {
    let level = levels.at_mut(u32::from(at.depth));
    let visits = Visits::of(mask, flip);
    let (slot, pending) = (visits.first(), visits.others());
    level.taken = slot as u8 ^ flip;
    // Always: whether more than one is met is anybody's guess, and the stores cost less than a wrong one.
    level.hold(child, at.block, flip);
    level.pending = pending;
    levels.live |= u32::from(pending != 0) << (at.depth & 31);
    at_slot(child, slot)
}

/// A child that was left.
pub(super) struct Taken {
    pub(super) child: u16,
    /// The block of its parent.
    pub(super) block: u32,
    /// Its level.
    pub(super) depth: u8,
}

/// Takes the next child that the ray may still reach, of the deepest level that has one.
#[inline(always)]
pub(super) fn take(levels: &mut Levels, t_max: f32) -> Option<Taken> {
    while levels.live != 0 {
        let depth = 31 - levels.live.leading_zeros();
        let level = levels.at_mut(depth);
        let pending = u32::from(level.pending);
        let taken = pending.trailing_zeros();
        let slot = taken ^ u32::from(level.flip);
        let pending = pending & pending.wrapping_sub(1);
        level.taken = taken as u8;
        level.pending = pending as u8;
        let near = level.near.get(slot as usize & 7).copied().unwrap_or(0.0);
        let child = at_slot(&level.child, slot);
        let block = level.block;
        levels.live &= !(u32::from(pending == 0) << depth);
        // Not at equality: the order of hits decides among equals.
        if near > t_max {
            continue;
        }
        return Some(Taken { child, block, depth: depth as u8 + 1 });
    }
    None
}

/// The child in a slot, as its bits.
#[inline(always)]
pub(super) fn at_slot(children: &[u16; 8], slot: u32) -> u16 {
    children.get(slot as usize & 7).copied().unwrap_or(EMPTY)
}
