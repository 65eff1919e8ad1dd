//! The traversal of a bundle.

use super::beam::Planes;
use super::bundle::{BundleVisited, GROUPS, Rays, Stops};
use super::code::{EMPTY, INDEX, is_leaf, is_node, is_ref, records};
use super::cursor::{Place, TraceError};
use super::group::{Corners, Crossings, GROUP, Group, Sides};
use super::lanes::Lanes;
use super::leaf::{normals, spheres, triangle};
use super::query::Query;
use super::stack::Entry;
use super::trail::Trail;
use super::turn::Turn;
use crate::block::format::{DEPTH_MAX, RECORD_SPHERES, Record};
use crate::block::{BlockSource, BlockView};
use crate::geometry::{Hit, PreparedRay, Primitive};

/// The path from the root to the current node, with what is left to visit beside it.
#[derive(Debug, Clone)]
pub(super) struct Stack {
    /// Bit `d`: level `d` has children left.
    live: u32,
    level: [Level; DEPTH_MAX],
}

/// A node on the path.
#[derive(Debug, Clone, Copy)]
struct Level {
    planes: Planes,
    child: [u16; 8],
    /// The block that the node lies in.
    block: u32,
    /// The node's order, for the bundle's [`Turn`].
    order: u32,
    /// Bit `k`: the slot in place `k` is still to be visited.
    pending: u8,
    /// Groups that meet the node.
    groups: u8,
    /// The place that was taken last.
    taken: u8,
}

impl Stack {
    pub(super) const fn new() -> Self {
        const LEVEL: Level = Level {
            planes: Planes::NONE,
            child: [0; 8],
            block: 0,
            order: 0,
            pending: 0,
            groups: 0,
            taken: 0,
        };
        Self { live: 0, level: [LEVEL; DEPTH_MAX] }
    }

    #[inline(always)]
    #[allow(clippy::indexing_slicing, reason = "the mask keeps it in range")]
    fn at_mut(&mut self, depth: u32) -> &mut Level {
        const { assert!(DEPTH_MAX == 32) };
        &mut self.level[(depth & 31) as usize]
    }
}

/// The lanes that are asked, by group.
type Mask = [u8; GROUPS];

/// Where the traversal of a bundle keeps its state.
pub(super) struct Room<'r> {
    pub(super) stack: &'r mut Stack,
    pub(super) stops: &'r mut Stops,
    /// Where lanes put what they find. It means nothing from one triangle to the next.
    pub(super) crossings: &'r mut Crossings,
}

/// Finds the hits of a bundle, as far as the source has the blocks: `Ok(Err(_))` is the first that it lacked.
///
/// A missing block stops the rays that need it, each with a trail of its own, and no others.
#[inline(always)]
pub(super) fn together<L: Lanes, S: BlockSource, Q: Query>(
    lanes: L,
    rays: &mut Rays,
    Room { stack, stops, crossings }: Room<'_>,
    visited: &mut BundleVisited,
    source: &mut S,
    queries: &mut [Q],
) -> Result<Result<(), S::Error>, TraceError<S::Error>> {
    let none = PreparedRay::NONE;
    let [first, ..] = &rays.order;
    let first = *rays.prepared.get(usize::from(*first)).unwrap_or(&none);
    let turn = Turn::of(&first);
    let axis = first.axis;
    let mut t_max = farthest(rays);
    let mut at = Place::ROOT;
    let mut groups = rays.used;
    // Lanes that meet the child that is visited, by group.
    let mut asked: Mask = [u8::MAX; GROUPS];
    let mut lacks = Ok(());
    let mut boxes = 0;
    stack.live = 0;
    'block: loop {
        let view = match source.block(at.block) {
            Ok(view) => view,
            Err(error) => {
                lacks = lacks.and(Err(error));
                stack.stop(lanes, turn, rays, stops, &at, groups, &asked);
                t_max = farthest(rays);
                let Some(block) = stack.returns_to() else { break };
                at.block = block;
                at.is_empty();
                continue;
            }
        };
        visited.blocks = visited.blocks.wrapping_add(1);
        let frame = rays.beam.frame(view.header());
        loop {
            if is_node(at.child()) {
                let Some(node) = view.node(at.child() & INDEX) else {
                    return Err(TraceError::Corrupt { block: at.block });
                };
                if at.spent() {
                    return Err(TraceError::Corrupt { block: at.block });
                }
                let depth = u32::from(at.entry.level());
                let level = stack.at_mut(depth);
                let mask = lanes.beam(&frame, node, rays.t_min, t_max, &mut level.planes);
                if mask != 0 {
                    level.child = node.child;
                    level.block = at.block;
                    level.order = turn.of_node(&node.order);
                    level.pending = turn.by_place(level.order, mask) as u8;
                    level.groups = groups as u8;
                    stack.live |= 1 << (depth & 31);
                }
            } else if is_ref(at.child()) {
                let Some(to) = view.reference(at.child() & INDEX) else {
                    return Err(TraceError::Corrupt { block: at.block });
                };
                at.enter(to);
                continue 'block;
            }
            // The next child that a ray meets.
            at.is_empty();
            while at.child() == EMPTY {
                if stack.live == 0 {
                    break 'block;
                }
                let depth = 31 - stack.live.leading_zeros();
                let level = stack.at_mut(depth);
                if level.block != at.block {
                    at.block = level.block;
                    continue 'block;
                }
                let pending = u32::from(level.pending);
                let taken = pending.trailing_zeros();
                let slot = turn.slot(level.order, taken);
                let pending = pending & pending.wrapping_sub(1);
                level.pending = pending as u8;
                level.taken = taken as u8;
                stack.live &= !(u32::from(pending == 0) << depth);
                let level = stack.at_mut(depth);
                let enter = level.planes.enter.get(slot).copied().unwrap_or(0.0);
                let child = level.child.get(slot).copied().unwrap_or(EMPTY);
                // Not at equality: the order of hits decides among equals.
                if enter > t_max || child == EMPTY {
                    continue;
                }
                let sides = sides(&level.planes, slot);
                let leaf = is_leaf(child);
                asked = [0; GROUPS];
                let mut met = 0;
                let mut waiting = u32::from(level.groups);
                boxes += waiting.count_ones();
                while waiting != 0 {
                    let g = waiting.trailing_zeros();
                    waiting &= waiting - 1;
                    if let (Some(group), Some(asked)) =
                        (rays.groups.get(g as usize), asked.get_mut(g as usize))
                    {
                        let mask = lanes.meets(group, &sides);
                        *asked = mask as u8;
                        met |= u32::from(mask != 0) << g;
                    }
                }
                if met == 0 {
                    continue;
                }
                if leaf {
                    if leaves(
                        lanes, &view, child, axis, rays, met, &asked, crossings, visited, queries,
                    ) {
                        t_max = farthest(rays);
                    }
                    continue;
                }
                groups = met;
                at.entry = Entry::new(child, depth as u8 + 1);
            }
        }
    }
    visited.nodes = visited.nodes.wrapping_add(at.nodes_visited());
    visited.boxes = visited.boxes.wrapping_add(u64::from(boxes));
    Ok(lacks)
}

impl Stack {
    /// The block of the deepest level that has children left.
    fn returns_to(&mut self) -> Option<u32> {
        let depth = self.live.checked_ilog2()?;
        Some(self.at_mut(depth).block)
    }

    /// Stops the rays that need the block of a place: those in the lanes asked, or where it is the way back to a level, all that meet it.
    #[cold]
    #[inline(never)]
    #[expect(clippy::too_many_arguments, reason = "the state of the traversal that stops")]
    fn stop<L: Lanes>(
        &mut self,
        lanes: L,
        turn: Turn,
        rays: &mut Rays,
        stops: &mut Stops,
        at: &Place,
        groups: u32,
        asked: &Mask,
    ) {
        let mut at = *at;
        let (mut groups, mut asked) = (groups, *asked);
        let live = self.live;
        if at.child() == EMPTY
            && let Some(depth) = self.live.checked_ilog2()
        {
            at.entry = Entry::new(EMPTY, depth as u8 + 1);
            (groups, asked) = (u32::from(self.at_mut(depth).groups), [u8::MAX; GROUPS]);
            self.live &= !(1 << depth);
        }
        while groups != 0 {
            let g = groups.trailing_zeros() as usize & (GROUPS - 1);
            groups &= groups - 1;
            let (Some(group), Some(&mask)) = (rays.groups.get_mut(g), asked.get(g)) else {
                continue;
            };
            let left = self.reached(lanes, turn, group, live);
            let order = rays.order.iter().skip(g * GROUP);
            for (((t_max, left), ray), lane) in group.t_max.iter_mut().zip(left).zip(order).zip(0..)
            {
                if u32::from(mask) >> lane & 1 == 0 || *t_max == f32::NEG_INFINITY {
                    continue;
                }
                *t_max = f32::NEG_INFINITY;
                let taken = self.level.iter().map(|level| level.taken);
                stops.stop(*ray, Trail::new(&at, taken, left));
            }
        }
    }

    /// Of these levels those on which each ray of a group may still reach a child.
    #[inline(always)]
    fn reached<L: Lanes>(&self, lanes: L, turn: Turn, group: &Group, live: u32) -> [u32; GROUP] {
        let mut reached = [0; GROUP];
        for (level, depth) in self.level.iter().zip(0..).filter(|(_, depth)| live >> depth & 1 == 1)
        {
            let mut met = 0;
            for place in (0..8).filter(|place| level.pending >> place & 1 == 1) {
                let slot = turn.slot(level.order, place);
                met |= lanes.meets(group, &sides(&level.planes, slot));
            }
            for (reached, lane) in reached.iter_mut().zip(0..) {
                *reached |= (met >> lane & 1) << depth;
            }
        }
        reached
    }
}

/// The greatest `t` that any ray of the bundle accepts. Groups behind are of bundles before.
#[inline(always)]
fn farthest(rays: &Rays) -> f32 {
    let mut far = f32::NEG_INFINITY;
    for group in rays.groups.iter().take(rays.used.count_ones() as usize) {
        let used = group.farthest();
        far = if used > far { used } else { far };
    }
    far
}

/// The planes of a slot.
#[inline(always)]
fn sides(planes: &Planes, slot: usize) -> Sides {
    let [nx, ny, nz] = &planes.near;
    let [fx, fy, fz] = &planes.far;
    let at = |row: &[f32; 8]| row.get(slot & 7).copied().unwrap_or(0.0);
    Sides { near: [at(nx), at(ny), at(nz)], far: [at(fx), at(fy), at(fz)] }
}

/// Tests the records of a leaf. `true`: a ray has become shorter.
#[inline(always)]
#[allow(clippy::too_many_arguments, reason = "inlined into the traversal, whose state it is")]
fn leaves<L: Lanes, Q: Query>(
    lanes: L,
    view: &BlockView<'_>,
    leaf: u16,
    axis: u8,
    rays: &mut Rays,
    met: u32,
    asked: &Mask,
    crossings: &mut Crossings,
    visited: &mut BundleVisited,
    queries: &mut [Q],
) -> bool {
    let (first, count) = records(leaf);
    let mut changed = false;
    let single = &mut visited.single.leaves;
    for record in view.leaf(first, count) {
        if record.base & RECORD_SPHERES != 0 {
            one_by_one(rays, met, asked, queries, |ray, query| {
                changed = true;
                *single = single.wrapping_add(1);
                spheres(view, record, ray, query)
            });
            continue;
        }
        for (place, &[a, b, c]) in record.index.iter().enumerate() {
            if a == b && b == c {
                continue;
            }
            let index = [a, b, c].map(|i| usize::from(record.base) + usize::from(i));
            let [a, b, c] = index.map(|i| view.vertex(i));
            let (Some(a), Some(b), Some(c)) = (a, b, c) else { continue };
            let corners = Corners::new([a, b, c], axis);
            let mut waiting = met;
            visited.triangles = visited.triangles.wrapping_add(u64::from(met.count_ones()));
            while waiting != 0 {
                let g = waiting.trailing_zeros() as usize & (GROUPS - 1);
                waiting &= waiting - 1;
                let (Some(group), Some(&mask)) = (rays.groups.get_mut(g), asked.get(g)) else {
                    continue;
                };
                let verdict = lanes.triangle(group, &corners, crossings);
                let mask = u32::from(mask);
                let doubtful = verdict.doubtful & mask;
                let mut accepted = verdict.accepted & mask;
                changed |= accepted | doubtful != 0;
                while accepted != 0 {
                    let lane = accepted.trailing_zeros() as usize & (GROUP - 1);
                    accepted &= accepted - 1;
                    let Some(&ray) = rays.order.get(g * GROUP + lane) else { continue };
                    let Some(query) = queries.get_mut(usize::from(ray)) else { continue };
                    let at = |row: &[f32; GROUP]| row.get(lane).copied().unwrap_or(0.0);
                    let t = at(&crossings.t);
                    let mut t_max = at(&group.t_max);
                    let found = || Hit {
                        t,
                        b1: at(&crossings.b1),
                        b2: at(&crossings.b2),
                        material: record.material,
                        primitive: Primitive::Triangle {
                            vertices: [a, b, c],
                            normals: normals(view, index),
                        },
                        block: view.number(),
                    };
                    let done = query.hit(&mut t_max, t, &found);
                    if let Some(place) = group.t_max.get_mut(lane) {
                        *place = if done { f32::NEG_INFINITY } else { t_max };
                    }
                }
                if doubtful != 0 {
                    doubt(view, record, place, rays, g, doubtful, queries);
                }
            }
        }
    }
    changed
}

/// Asks the definition for the lanes of a group.
#[cold]
#[inline(never)]
fn doubt<Q: Query>(
    view: &BlockView<'_>,
    record: &Record,
    place: usize,
    rays: &mut Rays,
    g: usize,
    lanes: u32,
    queries: &mut [Q],
) {
    let mut asked = [0; GROUPS];
    if let Some(asked) = asked.get_mut(g) {
        *asked = lanes as u8;
    }
    one_by_one(rays, 1 << g, &asked, queries, |ray, query| {
        triangle(view, record, place as u32, ray, query)
    });
}

/// Tests single rays. `true` of a test: nothing more is asked of the ray.
#[inline(always)]
fn one_by_one<Q: Query>(
    rays: &mut Rays,
    mut met: u32,
    asked: &Mask,
    queries: &mut [Q],
    mut test: impl FnMut(&mut PreparedRay, &mut Q) -> bool,
) {
    while met != 0 {
        let g = met.trailing_zeros() as usize & (GROUPS - 1);
        met &= met - 1;
        let mut mask = asked.get(g).map_or(0, |&mask| u32::from(mask));
        while mask != 0 {
            let lane = mask.trailing_zeros() as usize & (GROUP - 1);
            mask &= mask - 1;
            let Some(&index) = rays.order.get(g * GROUP + lane) else { continue };
            let Some(mut ray) = rays.prepared.get(usize::from(index)).copied() else { continue };
            let t_max = rays.groups.get_mut(g).and_then(|group| group.t_max.get_mut(lane));
            let (Some(t_max), Some(query)) = (t_max, queries.get_mut(usize::from(index))) else {
                continue;
            };
            ray.t_max = *t_max;
            let done = !ray.is_none() && test(&mut ray, query);
            *t_max = if done { f32::NEG_INFINITY } else { ray.t_max };
        }
    }
}
