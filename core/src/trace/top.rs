//! The traversal of the expanded top of a tree.

use super::code::INDEX;
use super::cursor::{Cursor, TraceError};
use super::lanes::Lanes;
use super::leaf::leaf;
use super::query::Query;
use super::stack::{Entry, Next};
use super::stream::in_mask;
use super::turn::Turn;
use super::walk::{Leave, Run};
use crate::block::format::Record;
use crate::block::{BlockSource, BlockView, ExpandedNode, ExpandedTop};

/// Its number, among those of blocks. No file has so many.
pub(super) const TOP: u32 = u32::MAX;

/// Goes on as far as the top reaches, leaves of its nodes included: they lie in blocks, but need no frame of theirs. The frame is the top's.
#[inline(always)]
#[expect(clippy::too_many_arguments, reason = "inlined into the traversal, whose state it is")]
pub(super) fn in_top<L: Lanes, S: BlockSource, Q: Query>(
    lanes: L,
    prepared: &L::Ray,
    frame: &mut L::Frame,
    turn: Turn,
    run: &mut Run,
    cursor: &mut Cursor,
    source: &mut S,
    query: &mut Q,
) -> Result<Leave, TraceError<S::Error>> {
    let Cursor { ray, stack, visited, crossings, .. } = cursor;
    // Apart from the run, which others know of: so they stay in registers.
    let (mut at, mut height, mut t_max) = (run.at, run.height, run.t_max);
    // Of the leaf that comes next, if it was just met: one that waited takes none, and a node has none.
    let mut lines = 0;
    let leave = 'top: loop {
        // Children that waited are gone on with in here: the frame stays in registers from one to the next.
        let spread = lanes.spread(frame);
        while let Some(node) = source.top().node(at.entry.0) {
            // Its children have all bits of an entry for themselves: a level means nothing here.
            let (false, Some(mut places)) = (at.too_many(), stack.places(&height)) else {
                break 'top Ok(Leave::Corrupt);
            };
            if !query.shortens() {
                places.near = None;
            }
            let met = lanes.visit_expanded(&spread, node, turn, (run.t_min, t_max), places);
            if met.count != 0 {
                stack.descend(&mut height, &mut at, met);
                lines = met.lines;
                // What waits first is visited later, unless any hit ends the ray: it is read meanwhile.
                if query.shortens()
                    && met.count > 1
                    && let Some(next) = stack.waiting(&height)
                {
                    fetch(lanes, source, next.0, 0);
                }
                continue;
            }
            match stack.next(&mut height, &mut at, query.shortens().then_some(t_max)) {
                Next::Here => {}
                Next::Elsewhere => break 'top Ok(Leave::Block),
                Next::Nowhere => break 'top Ok(Leave::Exhausted),
            }
        }
        if let Some((block, at_record, count)) = ExpandedTop::leaf(at.entry.0) {
            let view = match source.block(block) {
                Ok(view) => view,
                Err(error) => break Err(TraceError::Source(error)),
            };
            fetch_leaf(lanes, &view, at_record, core::mem::take(&mut lines));
            visited.blocks = visited.blocks.wrapping_add(1);
            at.tests();
            let records = view.leaf(at_record, count);
            let renew = |ray: &_| lanes.renew(frame, ray, &ExpandedTop::FRAME);
            if leaf(lanes, &view, records, prepared, crossings, ray, &mut t_max, query, renew) {
                break Ok(Leave::Done);
            }
        } else if let Some(to) = source.top().reference(at.entry.0) {
            let left = stack.leave(&mut height, at.block);
            (at.block, at.entry) = (to.block, Entry::new(to.node, 0));
            break Ok(if left { Leave::Block } else { Leave::Corrupt });
        }
        match stack.next(&mut height, &mut at, query.shortens().then_some(t_max)) {
            Next::Here => {}
            Next::Elsewhere => break Ok(Leave::Block),
            Next::Nowhere => break Ok(Leave::Exhausted),
        }
    };
    (run.at, run.height, run.t_max) = (at, height, t_max);
    leave
}

/// Has the children in some slots of a node read, which are visited soon.
#[inline(always)]
pub(super) fn fetch_children<L: Lanes, S: BlockSource>(
    lanes: L,
    source: &mut S,
    node: u32,
    slots: u8,
) {
    if !L::READS_AHEAD {
        return;
    }
    let Some(&ExpandedNode { child, lines, nodes, .. }) = source.top().node(node) else { return };
    let slots = u32::from(slots);
    // Nodes first: of most children nobody then has to guess what they are.
    for slot in in_mask(slots & nodes) {
        if let Some(node) = child.get(slot).and_then(|&child| source.top().node(child)) {
            lanes.fetch(node);
        }
    }
    for slot in in_mask(slots & !nodes) {
        if let (Some(&child), Some(&lines)) = (child.get(slot), lines.get(slot)) {
            fetch(lanes, source, child, lines);
        }
    }
}

/// Has a child read that is visited soon, with these [lines](ExpandedNode::lines). Of a leaf for which there
/// are none, its first records.
#[inline(always)]
pub(super) fn fetch<L: Lanes, S: BlockSource>(lanes: L, source: &mut S, child: u32, lines: u8) {
    if !L::READS_AHEAD {
        return;
    }
    if let Some(node) = source.top().node(child) {
        lanes.fetch(node);
    } else if let Some((block, record, _)) = ExpandedTop::leaf(child)
        && let Ok(view) = source.block(block)
    {
        if lines == 0 {
            lanes.fetch_lines::<1>(&view, line_of(record));
        } else {
            fetch_leaf(lanes, &view, record, lines);
        }
    } else if let Some(to) = source.top().reference(child)
        && let Ok(view) = source.block(to.block)
        && let Some(node) = view.node(to.node & INDEX)
    {
        lanes.fetch(view.header());
        lanes.fetch(node);
    }
}

/// Has a leaf read that is visited next: its vertices are asked for when its record is there, the header when there is a hit, and the records behind it
/// probably soon.
#[inline(always)]
pub(super) fn fetch_leaf<L: Lanes>(lanes: L, view: &BlockView<'_>, record: u16, lines: u8) {
    lanes.fetch_lines::<3>(view, line_of(record));
    if lines != 0 {
        lanes.fetch_lines::<{ ExpandedNode::LINES }>(view, lines.into());
    }
    lanes.fetch(view.header());
}

/// The line of a block that has this record.
#[inline(always)]
const fn line_of(record: u16) -> usize {
    record as usize * size_of::<Record>() / ExpandedNode::LINE_BYTES
}
