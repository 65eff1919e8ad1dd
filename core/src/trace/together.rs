//! The traversal of a bundle.

use super::beam::Planes;
use super::bundle::{GROUPS, Rays};
use super::code::{EMPTY, INDEX, is_leaf, is_node, is_ref, records};
use super::cursor::{Place, TraceError};
use super::group::{Corners, Crossings, GROUP, Sides};
use super::lanes::Lanes;
use super::leaf::{normals, spheres, triangle};
use super::octant::{first_octants, ordered};
use super::query::Query;
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
    /// Slot `k ^ flip` is visited `k`th.
    flip: u8,
    /// Bit `k`: still to be visited.
    pending: u8,
    /// Groups that meet the node.
    groups: u8,
}

impl Stack {
    pub(super) const fn new() -> Self {
        const LEVEL: Level =
            Level { planes: Planes::NONE, child: [0; 8], block: 0, flip: 0, pending: 0, groups: 0 };
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

/// Finds the hits of a bundle.
#[inline(always)]
pub(super) fn together<L: Lanes, S: BlockSource, Q: Query>(
    lanes: L,
    rays: &mut Rays,
    stack: &mut Stack,
    source: &mut S,
    queries: &mut [Q],
) -> Result<(), TraceError<S::Error>> {
    let none = PreparedRay::NONE;
    let [first, ..] = &rays.order;
    let first = *rays.prepared.get(usize::from(*first)).unwrap_or(&none);
    let octants = first_octants(&first);
    let axis = first.axis;
    let mut t_max = farthest(rays);
    let mut at = Place::ROOT;
    let mut groups = rays.used;
    stack.live = 0;
    'block: loop {
        let view = source.block(at.block).map_err(TraceError::Source)?;
        let frame = rays.beam.frame(view.header());
        loop {
            if is_node(at.child) {
                let Some(node) = view.node(at.child & INDEX) else {
                    return Err(TraceError::Corrupt { block: at.block });
                };
                if at.spent() {
                    return Err(TraceError::Corrupt { block: at.block });
                }
                let depth = u32::from(at.depth);
                let level = stack.at_mut(depth);
                let mask = lanes.beam(&frame, node, rays.t_min, t_max, &mut level.planes);
                if mask != 0 {
                    level.child = node.child;
                    level.block = at.block;
                    level.flip = lanes.flip(octants, node);
                    level.pending = ordered(mask, level.flip) as u8;
                    level.groups = groups as u8;
                    stack.live |= 1 << (depth & 31);
                }
            } else if is_ref(at.child) {
                let Some(to) = view.reference(at.child & INDEX) else {
                    return Err(TraceError::Corrupt { block: at.block });
                };
                at.enter(to);
                continue 'block;
            }
            // The next child that a ray meets.
            at.child = EMPTY;
            while at.child == EMPTY {
                if stack.live == 0 {
                    return Ok(());
                }
                let depth = 31 - stack.live.leading_zeros();
                let level = stack.at_mut(depth);
                if level.block != at.block {
                    at.block = level.block;
                    continue 'block;
                }
                let pending = u32::from(level.pending);
                let slot = (pending.trailing_zeros() ^ u32::from(level.flip)) as usize & 7;
                let pending = pending & pending.wrapping_sub(1);
                level.pending = pending as u8;
                stack.live &= !(u32::from(pending == 0) << depth);
                let level = stack.at_mut(depth);
                let enter = level.planes.enter.get(slot).copied().unwrap_or(0.0);
                let child = level.child.get(slot).copied().unwrap_or(EMPTY);
                // Not at equality: the order of hits decides among equals.
                if enter > t_max || child & 0x7fff == EMPTY {
                    continue;
                }
                let sides = sides(&level.planes, slot);
                let leaf = is_leaf(child);
                let mut asked: Mask = [0; GROUPS];
                let mut met = 0;
                let mut waiting = u32::from(level.groups);
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
                    if leaves(lanes, &view, child, axis, rays, met, &asked, queries) {
                        t_max = farthest(rays);
                    }
                    continue;
                }
                groups = met;
                at.child = child;
                at.depth = depth as u8 + 1;
            }
        }
    }
}

#[inline(always)]
fn farthest(rays: &Rays) -> f32 {
    let mut far = f32::NEG_INFINITY;
    for group in &rays.groups {
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
    queries: &mut [Q],
) -> bool {
    let (first, count) = records(leaf);
    let mut changed = false;
    let mut crossings = Crossings::default();
    for index in first..first + count {
        let Some(record) = view.record(index) else { break };
        if record.base & RECORD_SPHERES != 0 {
            one_by_one(rays, met, asked, queries, |ray, query| {
                changed = true;
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
            while waiting != 0 {
                let g = waiting.trailing_zeros() as usize & (GROUPS - 1);
                waiting &= waiting - 1;
                let (Some(group), Some(&mask)) = (rays.groups.get_mut(g), asked.get(g)) else {
                    continue;
                };
                let verdict = lanes.triangle(group, &corners, &mut crossings);
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
                    let mut shorter = PreparedRay::NONE;
                    shorter.t_max = at(&group.t_max);
                    let done = query.hit(&mut shorter, t, || Hit {
                        t,
                        b1: at(&crossings.b1),
                        b2: at(&crossings.b2),
                        material: record.material,
                        primitive: Primitive::Triangle {
                            vertices: [a, b, c],
                            normals: normals(view, index),
                        },
                    });
                    if let Some(t_max) = group.t_max.get_mut(lane) {
                        *t_max = if done { f32::NEG_INFINITY } else { shorter.t_max };
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
