//! The traversal of a stream.

use super::beam::{Beam, farthest};
use super::bundle::BundleVisited;
use super::code::{INDEX, LEAF, is_leaf, is_node, is_ref, records};
use super::cursor::{Cursor, Place, TraceError};
use super::group::{Crossings, GROUP, Quad, Row, Verdict};
use super::lanes::Lanes;
use super::leaf::{crossed, spheres, triangle, triangles};
use super::query::Query;
use super::stack::Entry;
use super::stream::{Level, Rays, Stream, planes_of};
use super::top::{TOP, fetch_children};
use super::tracer::Search;
use super::trail::Trail;
use super::turn::Turn;
use super::walk::Single;
use crate::block::format::{BlockHeader, Child, Node, RECORD_SPHERES, Record};
use crate::block::{BlockSource, BlockView, ExpandedTop};
use crate::geometry::{PreparedRay, Ray};
use crate::real::Part;

/// What becomes of rays whose way leads into a block that the source lacks.
pub(super) trait Stops<E> {
    /// A block is lacking. Its rays [stop](Self::stop), or the search ends with an error.
    fn lacks(&mut self, error: E) -> Result<(), E>;

    /// Stops a ray, which has not stopped before.
    fn stop(&mut self, ray: u16, trail: Trail);

    /// Whether a ray has stopped.
    fn has_stopped(&self, ray: u16) -> bool;
}

/// What a stream is traced with.
pub(super) struct Flow<'a, L, S, P, Q> {
    pub(super) lanes: L,
    pub(super) source: &'a mut S,
    pub(super) stops: &'a mut P,
    pub(super) rays: &'a [Ray],
    pub(super) queries: &'a mut [Q],
}

impl<L: Lanes, S: BlockSource, P: Stops<S::Error>, Q: Query> Flow<'_, L, S, P, Q> {
    /// Traces a ray by itself.
    #[inline(always)]
    pub(super) fn alone(
        &mut self,
        cursor: &mut Cursor,
        ray: u16,
    ) -> Result<(), TraceError<S::Error>> {
        self.lanes.apart(true, Alone { flow: self, cursor, ray })
    }

    /// Traces the rays of the list of the first level, which have these signs. `COHERENT`: they are those of some groups from `first` on, and go much the
    /// same way.
    #[inline(always)]
    pub(super) fn run<const COHERENT: bool, const GROUPS: usize>(
        &mut self,
        stream: &mut Stream<GROUPS>,
        signs: u8,
        first: usize,
    ) -> Result<(), TraceError<S::Error>> {
        let lanes = self.lanes;
        lanes.apart(true, Through::<COHERENT, _, _, GROUPS> { flow: self, stream, signs, first })
    }
}

/// [`Flow::alone`].
struct Alone<'a, F> {
    flow: &'a mut F,
    cursor: &'a mut Cursor,
    ray: u16,
}

impl<L: Lanes, S: BlockSource, P: Stops<S::Error>, Q: Query> Part
    for Alone<'_, Flow<'_, L, S, P, Q>>
{
    type Result = Result<(), TraceError<S::Error>>;

    #[inline(always)]
    fn run(self) -> Self::Result {
        let Self { flow, cursor, ray } = self;
        let at = usize::from(ray);
        let (Some(of), Some(query)) = (flow.rays.get(at), flow.queries.get_mut(at)) else {
            return Ok(());
        };
        match Single::<false>::run(flow.lanes, cursor, flow.source, of, query) {
            Err(TraceError::Source(error)) => {
                flow.stops.lacks(error).map_err(TraceError::Source)?;
                flow.stops.stop(ray, cursor.trail());
                Ok(())
            }
            result => result,
        }
    }
}

/// The way of a stream through the tree.
struct Through<'a, const COHERENT: bool, F, T, const GROUPS: usize> {
    flow: &'a mut F,
    stream: &'a mut T,
    signs: u8,
    first: usize,
}

impl<
    const COHERENT: bool,
    L: Lanes,
    S: BlockSource,
    P: Stops<S::Error>,
    Q: Query,
    const GROUPS: usize,
> Part for Through<'_, COHERENT, Flow<'_, L, S, P, Q>, Stream<GROUPS>, GROUPS>
{
    type Result = Result<(), TraceError<S::Error>>;

    #[inline(always)]
    fn run(self) -> Self::Result {
        let Self { flow, stream, signs, first } = self;
        let from_end =
            flow.source.holds_all() && flow.queries.first().is_some_and(|query| !query.shortens());
        let turn = Turn::new(signs, from_end);
        let goes_past = !flow.source.holds_all()
            && flow.queries.first().is_some_and(|query| query.answered().is_some());
        let Stream { rays, levels, crossings, quad, used, visited, .. } = stream;
        let Rays { groups, .. } = rays;
        let beam_of = groups.get(first..*used).unwrap_or_default();
        let mut beam = if COHERENT { Beam::of(beam_of, signs) } else { Beam::NONE };
        let has_top = flow.source.holds_all() && !flow.source.top().is_empty();
        let (mut block, mut child) = (if has_top { TOP } else { 0 }, 0_u32);
        // Counts nodes.
        let mut place = Place::ROOT;
        let mut depth = 0;
        let mut last = TOP;
        let result = 'tree: loop {
            let corrupt = Err(TraceError::Corrupt { block: if block == TOP { 0 } else { block } });
            let Some(level) = levels.get_mut(depth) else { break corrupt };
            level.pending = 0;
            let of_top = if block == TOP { ExpandedTop::leaf(child) } else { None };
            if let Some((b, ..)) = of_top {
                (block, child) = (b, LEAF.into());
            }
            'node: {
                let planes = if block == TOP {
                    let top = flow.source.top();
                    let Some(node) = top.node(child) else {
                        let Some(to) = top.reference(child) else { break 'node };
                        (block, child) = (to.block, to.node.into());
                        continue 'tree;
                    };
                    let (near, far) = sides((&node.lo, &node.hi), signs);
                    if COHERENT {
                        // Row by row, or they take the way over the stack.
                        let rows = level.planes.as_flattened_mut().iter_mut();
                        rows.zip(near.iter().chain(&far)).for_each(|(to, from)| *to = **from);
                    }
                    level.child = node.child;
                    level.order = turn.of_node(&node.order);
                    (near, far)
                } else {
                    let view = match flow.source.block(block) {
                        Ok(view) => view,
                        Err(error) => {
                            if let Err(error) = flow.stops.lacks(error) {
                                break 'tree Err(TraceError::Source(error));
                            }
                            stop::<COHERENT, _, _, _, GROUPS>(
                                flow.lanes,
                                flow.stops,
                                levels,
                                depth,
                                turn,
                                rays,
                                block,
                                child as u16,
                                goes_past,
                            );
                            break 'node;
                        }
                    };
                    visited.blocks = visited.blocks.wrapping_add(u64::from(block != last));
                    last = block;
                    let bits = child as u16;
                    if is_leaf(bits) {
                        let mut to = Leaf {
                            lanes: flow.lanes,
                            view: &view,
                            rays,
                            of: flow.rays,
                            crossings,
                            queries: &mut *flow.queries,
                            visited: &mut *visited,
                        };
                        let records = match of_top {
                            Some((_, at, count)) => view.leaf(at, count),
                            None => {
                                let (at, count) = records(bits);
                                view.leaf(at, count)
                            }
                        };
                        let changed = if COHERENT {
                            to.test(quad, records, level.lanes())
                        } else {
                            to.test(quad, records, level.alone())
                        };
                        if COHERENT && changed {
                            let groups = rays.groups.get(first..*used);
                            beam.t_max = farthest(groups.unwrap_or_default());
                        }
                        break 'node;
                    }
                    if is_ref(bits) {
                        let Some(to) = view.reference(bits & INDEX) else { break 'tree corrupt };
                        (block, child) = (to.block, (to.node & INDEX).into());
                        continue 'tree;
                    }
                    if !is_node(bits) {
                        break 'node;
                    }
                    let Some(node) = view.node(bits & INDEX) else { break 'tree corrupt };
                    decode(&mut level.planes, view.header(), node, signs);
                    level.child = children(node);
                    level.order = turn.of_node(&node.order);
                    planes_of(&level.planes)
                };
                if place.too_many() {
                    break 'tree corrupt;
                }
                let slots = if COHERENT {
                    flow.lanes.beam(&beam, planes, &mut level.enter)
                } else {
                    let (list, met) = (&level.list, &mut level.met);
                    visited.ray_boxes = visited.ray_boxes.wrapping_add(level.count as u64);
                    flow.lanes.boxes(&rays.groups, list, level.count, planes, met)
                };
                level.pending = flow.lanes.by_place(turn, level.order, slots);
                level.block = block;
                if block == TOP {
                    // They are read while the rays of the first are selected and traced.
                    fetch_children(flow.lanes, flow.source, child, slots);
                }
            }
            // The next child that any ray meets.
            loop {
                let Some((level, below)) =
                    levels.get_mut(depth..).and_then(<[Level<GROUPS>]>::split_first_mut)
                else {
                    break 'tree corrupt;
                };
                if level.pending == 0 {
                    level.count = 0;
                    let Some(above) = depth.checked_sub(1) else { break 'tree Ok(()) };
                    depth = above;
                    continue;
                }
                level.place = level.pending.trailing_zeros() as u8;
                level.pending &= level.pending - 1;
                let slot = turn.slot(level.order, level.place.into());
                let next = level.child.get(slot).copied().unwrap_or(ExpandedTop::EMPTY);
                if next == ExpandedTop::EMPTY {
                    continue;
                }
                let Some(to) = below.first_mut() else { break 'tree corrupt };
                if COHERENT {
                    // Not at equality: the order of hits decides among equals.
                    if level.enter.get(slot).is_some_and(|&enter| enter > beam.t_max) {
                        continue;
                    }
                    let planes = level.planes();
                    let mut waiting = level.count as u32;
                    visited.boxes = visited.boxes.wrapping_add(waiting.count_ones().into());
                    let mut met = 0;
                    while waiting != 0 {
                        let g = waiting.trailing_zeros();
                        waiting &= waiting - 1;
                        if let (Some(group), Some(to)) = (
                            rays.groups.get(g as usize),
                            to.list.as_flattened_mut().get_mut(g as usize),
                        ) {
                            *to = flow.lanes.meets(group, planes, slot);
                            met |= u32::from(*to != 0) << g;
                        }
                    }
                    if met == 0 {
                        continue;
                    }
                    to.count = met as usize;
                } else {
                    to.count =
                        flow.lanes.select(&level.list, &level.met, level.count, slot, &mut to.list);
                }
                (block, child) = (level.block, next);
                depth += 1;
                break;
            }
        };
        visited.nodes = visited.nodes.wrapping_add(place.nodes_visited());
        result
    }
}

/// The planes that rays of these signs meet first and last, by axis.
#[inline(always)]
fn sides<'n, T>((lo, hi): (&'n [T; 3], &'n [T; 3]), signs: u8) -> ([&'n T; 3], [&'n T; 3]) {
    let ([lx, ly, lz], [hx, hy, hz]) = (lo, hi);
    let axis = |axis: u8, lo, hi| if signs >> axis & 1 == 0 { (lo, hi) } else { (hi, lo) };
    let ((nx, fx), (ny, fy), (nz, fz)) = (axis(0, lx, hx), axis(1, ly, hy), axis(2, lz, hz));
    ([nx, ny, nz], [fx, fy, fz])
}

/// The planes of a node in scene coordinates.
#[inline(always)]
fn decode(planes: &mut [[Row; 3]; 2], header: &BlockHeader, node: &Node, signs: u8) {
    let (near, far) = sides((&node.lo, &node.hi), signs);
    for (rows, bounds) in planes.iter_mut().zip([near, far]) {
        let frame = header.origin.iter().zip(&header.scale);
        for ((row, bounds), (&origin, &scale)) in rows.iter_mut().zip(bounds).zip(frame) {
            // A row at a time: number by number, each would wait to see whether the last was written over the frame.
            *row = bounds.map(|q| origin + scale * f32::from(q));
        }
    }
}

/// The children of a node, as levels have them.
#[inline(always)]
fn children(node: &Node) -> [u32; 8] {
    node.child.map(|bits| if bits == Child::EMPTY { ExpandedTop::EMPTY } else { bits.into() })
}

/// Stops the rays of a level at a child, those that have not stopped before. If each `goes_past` it, they stay in the stream.
#[cold]
#[inline(never)]
#[expect(clippy::too_many_arguments, reason = "the state of the traversal that stops")]
fn stop<const COHERENT: bool, L: Lanes, P: Stops<E>, E, const GROUPS: usize>(
    lanes: L,
    stops: &mut P,
    levels: &[Level<GROUPS>],
    depth: usize,
    turn: Turn,
    rays: &mut Rays<GROUPS>,
    block: u32,
    child: u16,
    goes_past: bool,
) {
    let path = levels.get(..=depth).and_then(<[Level<GROUPS>]>::split_last);
    let Some((level, above)) = path else { return };
    let at = Place { block, entry: Entry::new(child, depth as u8), ..Place::ROOT };
    let mut stop = |g: usize, mut asked: u32| {
        let (Some(group), Some(index)) = (rays.groups.get_mut(g), rays.index.get(g)) else {
            return;
        };
        while asked != 0 {
            let lane = asked.trailing_zeros() as usize & (GROUP - 1);
            asked &= asked - 1;
            let (Some(t_max), Some(&ray)) = (group.t_max.get(lane), index.get(lane)) else {
                continue;
            };
            if *t_max == f32::NEG_INFINITY || stops.has_stopped(ray) {
                continue;
            }
            let is_left = |level: &Level<GROUPS>| {
                if COHERENT {
                    level.slots(turn).any(|slot| {
                        u32::from(lanes.meets(group, level.planes(), slot)) >> lane & 1 != 0
                    })
                } else {
                    let met = level.met_by(g * GROUP + lane);
                    level.slots(turn).any(|slot| met >> slot & 1 != 0)
                }
            };
            let left = above.iter().zip(0_u32..).fold(0, |left, (level, depth)| {
                left | u32::from(is_left(level)).unbounded_shl(depth)
            });
            let taken = above.iter().map(|level| level.place);
            stops.stop(ray, Trail::new(&at, taken, left));
            if let Some(t_max) = group.t_max.get_mut(lane).filter(|_| !goes_past) {
                *t_max = f32::NEG_INFINITY;
            }
        }
    };
    if COHERENT {
        level.lanes().for_each(|(g, asked)| stop(g, asked));
    } else {
        level.alone().for_each(|(g, asked)| stop(g, asked));
    }
}

/// A leaf, and the rays of a stream that test its records.
struct Leaf<'a, 'v, L, Q, const GROUPS: usize> {
    lanes: L,
    view: &'a BlockView<'v>,
    rays: &'a mut Rays<GROUPS>,
    /// As they came.
    of: &'a [Ray],
    crossings: &'a mut Crossings,
    queries: &'a mut [Q],
    visited: &'a mut BundleVisited,
}

impl<L: Lanes, Q: Query, const GROUPS: usize> Leaf<'_, '_, L, Q, GROUPS> {
    /// Tests its records for the lanes of some groups. Whether any of them has hit something.
    #[inline(always)]
    fn test(
        &mut self,
        quad: &mut Quad,
        records: &[Record],
        list: impl Iterator<Item = (usize, u32)> + Clone,
    ) -> bool {
        let (view, lanes) = (self.view, self.lanes);
        let vertices = view.vertex_numbers();
        let mut changed = false;
        for record in records {
            if record.base & RECORD_SPHERES == 0 && lanes.quad(vertices, record, quad) {
                for (g, asked) in list.clone() {
                    changed |= if asked.count_ones() as usize >= L::TOGETHER {
                        self.together(record, quad, g, asked)
                    } else {
                        self.apart(record, quad, g, asked)
                    };
                }
            } else {
                changed = true;
                for (g, asked) in list.clone() {
                    self.one_by_one(g, asked, |ray, query| {
                        if record.base & RECORD_SPHERES == 0 {
                            triangles(view, record, 0b1111, ray, query)
                        } else {
                            spheres(view, record, ray, query)
                        }
                    });
                }
            }
        }
        changed
    }

    /// Tests the triangles of a record for some lanes of a group, all lanes at once. Whether any has hit something.
    #[inline(always)]
    fn together(&mut self, record: &Record, quad: &Quad, g: usize, asked: u32) -> bool {
        let (view, lanes) = (self.view, self.lanes);
        let mut changed = false;
        let mut places = quad.used;
        while places != 0 {
            let place = places.trailing_zeros();
            places &= places - 1;
            let (Some(group), Some(&kind), Some(index)) =
                (self.rays.groups.get_mut(g), self.rays.kinds.get(g), self.rays.index.get(g))
            else {
                continue;
            };
            self.visited.triangles = self.visited.triangles.wrapping_add(1);
            let verdict = lanes.triangle(quad, place as usize, group, kind, self.crossings);
            let (mut accepted, doubtful) = (verdict.accepted & asked, verdict.doubtful & asked);
            changed |= accepted | doubtful != 0;
            while accepted != 0 {
                let lane = accepted.trailing_zeros() as usize & (GROUP - 1);
                accepted &= accepted - 1;
                let query = index.get(lane).and_then(|&i| self.queries.get_mut(usize::from(i)));
                let (Some(query), Some(t_max)) = (query, group.t_max.get_mut(lane)) else {
                    continue;
                };
                if crossed(view, record, place, (&*self.crossings, lane), t_max, query) {
                    *t_max = f32::NEG_INFINITY;
                }
            }
            if doubtful != 0 {
                lanes.in_doubt(|| {
                    self.one_by_one(g, doubtful, |ray, query| {
                        triangle(view, record, place, ray, query)
                    });
                });
            }
        }
        changed
    }

    /// .. lane by lane, all triangles at once.
    #[inline(always)]
    fn apart(&mut self, record: &Record, quad: &Quad, g: usize, mut asked: u32) -> bool {
        let (view, lanes) = (self.view, self.lanes);
        let mut changed = false;
        while asked != 0 {
            let lane = asked.trailing_zeros() as usize & (GROUP - 1);
            asked &= asked - 1;
            let (Some(group), Some(&kind), Some(index)) =
                (self.rays.groups.get_mut(g), self.rays.kinds.get(g), self.rays.index.get(g))
            else {
                continue;
            };
            self.visited.ray_triangles = self.visited.ray_triangles.wrapping_add(1);
            let Verdict { mut accepted, doubtful } =
                lanes.quad_of(quad, group, lane, kind, self.crossings);
            changed |= accepted | doubtful != 0;
            if accepted != 0 {
                let query = index.get(lane).and_then(|&i| self.queries.get_mut(usize::from(i)));
                let (Some(query), Some(t_max)) = (query, group.t_max.get_mut(lane)) else {
                    continue;
                };
                while accepted != 0 {
                    let place = accepted.trailing_zeros();
                    accepted &= accepted - 1;
                    let found = (&*self.crossings, place as usize);
                    if crossed(view, record, place, found, t_max, query) {
                        *t_max = f32::NEG_INFINITY;
                        break;
                    }
                }
            }
            if doubtful != 0 {
                lanes.in_doubt(|| {
                    self.one_by_one(g, 1 << lane, |ray, query| {
                        triangles(view, record, doubtful, ray, query)
                    });
                });
            }
        }
        changed
    }

    /// Tests single rays of a group. `true` of a test: nothing more is asked of the ray.
    #[inline(always)]
    fn one_by_one(
        &mut self,
        g: usize,
        mut asked: u32,
        mut test: impl FnMut(&mut PreparedRay, &mut Q) -> bool,
    ) {
        let (Some(group), Some(&kind), Some(index)) =
            (self.rays.groups.get_mut(g), self.rays.kinds.get(g), self.rays.index.get(g))
        else {
            return;
        };
        while asked != 0 {
            let lane = asked.trailing_zeros() as usize & (GROUP - 1);
            asked &= asked - 1;
            let Some(i) = index.get(lane).map(|&i| usize::from(i)) else { continue };
            let (Some(ray), Some(query)) = (self.of.get(i), self.queries.get_mut(i)) else {
                continue;
            };
            let mut ray = group.prepared(lane, kind, ray);
            if ray.is_none() {
                continue;
            }
            self.visited.single.leaves = self.visited.single.leaves.wrapping_add(1);
            let done = test(&mut ray, query);
            if let Some(t_max) = group.t_max.get_mut(lane) {
                *t_max = if done { f32::NEG_INFINITY } else { ray.t_max };
            }
        }
    }
}
