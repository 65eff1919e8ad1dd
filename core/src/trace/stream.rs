//! Streams: rays of the same signs that go through the tree as lists.
//!
//! Rays are sorted by [`Kind`]: their signs, and the axis that they go farthest along. Eight of a kind make a [`Group`]. Those of a kind that go much the same
//! way are traced by themselves, with a [`Beam`](super::Beam) around them that is tested against the boxes of a node for all of them; the others of the same
//! signs have lists.
//!
//! A node is decoded once for all rays that come to it, and each of them is tested against its eight boxes. Then for each child, front to back, those
//! that meet it are put down as a list of their own, and so on below it (Barringer, Akenine-Möller: Dynamic Ray Stream Traversal, 2014). What costs single
//! rays most, loads that wait for each other and branches that no one foresees, is paid once for a list.

use super::beam::ends;
use super::bundle::BundleVisited;
use super::cursor::{Cursor, TraceError};
use super::flow::{Flow, Stops};
use super::group::{Crossings, GROUP, Group, Kind, Octet, Quad, Row};
use super::lanes::Lanes;
use super::query::Query;
use super::turn::Turn;
use crate::block::BlockSource;
use crate::block::format::DEPTH_MAX;
use crate::geometry::Ray;
use core::ops::Range;

/// Rays that are sorted at a time, for each group of a stream.
const SORTED: usize = 32;
/// Where blocks are fetched, fewer rays of the same signs than this go one by one: they soon part there.
const SHORTEST: usize = 4;
/// Fewer rays of a kind than this are not coherent.
const FEWEST: usize = 4;
/// If the slopes of rays of a kind along their greatest axis differ by more than this, they are not coherent.
const WIDEST: f32 = 0.5;

/// Room for streams of `8 * GROUPS` rays.
#[derive(Debug, Clone)]
pub(super) struct Stream<const GROUPS: usize> {
    /// The kind of each ray that is sorted.
    kinds: [[u8; SORTED]; GROUPS],
    /// The rays, by kind.
    order: [[u16; SORTED]; GROUPS],
    pub(super) rays: Rays<GROUPS>,
    /// By level of the tree. The last has a list and no node.
    pub(super) levels: [Level<GROUPS>; DEPTH_MAX + 1],
    /// Groups that have rays.
    pub(super) used: usize,
    /// Where lanes put what they find. It means nothing from one record to the next.
    pub(super) crossings: Crossings,
    /// The record that is tested.
    pub(super) quad: Quad,
    pub(super) visited: BundleVisited,
}

/// The rays of a stream.
#[derive(Debug, Clone)]
pub(super) struct Rays<const GROUPS: usize> {
    pub(super) groups: [Group; GROUPS],
    /// Of each group.
    pub(super) kinds: [Kind; GROUPS],
    /// Which ray is in a lane.
    pub(super) index: [[u16; GROUP]; GROUPS],
}

/// A node on the path, with the rays that have come to it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Level<const GROUPS: usize> {
    /// Rays: lanes, counted through all groups.
    pub(super) list: [Octet; GROUPS],
    /// The slots that each of them meets.
    pub(super) met: [Octet; GROUPS],
    /// How many rays. Of coherent rays `list` has a mask of lanes for each group, and this is a mask of groups.
    pub(super) count: usize,
    /// The planes that are met first and last, if they are not in place in the top.
    pub(super) planes: [[Row; 3]; 2],
    /// Where the first of coherent rays enters, by slot.
    pub(super) enter: Row,
    /// By slot: bits of the block or of the top.
    pub(super) child: [u32; 8],
    /// The node's order, for the [`Turn`](super::Turn) of the rays.
    pub(super) order: u32,
    /// The block that the node lies in.
    pub(super) block: u32,
    /// Bit `k`: the slot in place `k` is still to be visited.
    pub(super) pending: u8,
    /// The place that was taken last.
    pub(super) place: u8,
}

impl<const GROUPS: usize> Level<GROUPS> {
    const NONE: Self = Self {
        list: [[0; GROUP]; GROUPS],
        met: [[0; GROUP]; GROUPS],
        count: 0,
        planes: [[[0.0; 8]; 3]; 2],
        enter: [0.0; 8],
        child: [0; 8],
        order: 0,
        block: 0,
        pending: 0,
        place: 0,
    };

    /// Its planes.
    #[inline(always)]
    pub(super) fn planes(&self) -> ([&Row; 3], [&Row; 3]) {
        planes_of(&self.planes)
    }

    /// The slots that are still to be visited.
    pub(super) fn slots(&self, turn: Turn) -> impl Iterator<Item = usize> {
        in_mask(self.pending.into()).map(move |place| turn.slot(self.order, place as u32))
    }

    /// The slots that a ray meets.
    pub(super) fn met_by(&self, id: usize) -> u8 {
        // Eight rays at a time: which byte of a word is zero (Warren, Hacker's Delight, 6-1). What stands behind the list comes after the ray, if that is there.
        const ONES: u64 = u64::from_ne_bytes([1; GROUP]);
        const HIGHS: u64 = ONES << 7;
        let id = ONES.wrapping_mul(id as u64 & 0xff);
        let octets = self.list.iter().zip(&self.met).take(self.count.div_ceil(GROUP));
        for (g, (octet, met)) in octets.enumerate() {
            let differ = u64::from_le_bytes(*octet) ^ id;
            let same = differ.wrapping_sub(ONES) & !differ & HIGHS;
            if same != 0 {
                let lane = same.trailing_zeros() as usize / 8;
                let is_in = g * GROUP + lane < self.count;
                return met.get(lane).copied().filter(|_| is_in).unwrap_or(0);
            }
        }
        0
    }

    /// Rays of any way, each as a lane of its group.
    #[inline(always)]
    pub(super) fn alone(&self) -> impl Iterator<Item = (usize, u32)> + Clone {
        let list = self.list.as_flattened().get(..self.count).unwrap_or_default();
        list.iter().map(|&id| (usize::from(id) / GROUP, 1 << (usize::from(id) % GROUP)))
    }

    /// The lanes of groups of coherent rays.
    #[inline(always)]
    pub(super) fn lanes(&self) -> impl Iterator<Item = (usize, u32)> + Clone {
        let lanes = |g| self.list.as_flattened().get(g).copied().unwrap_or(0);
        in_mask(self.count as u32).map(move |g| (g, lanes(g).into()))
    }
}

/// The numbers of bits that are set, the lowest first.
#[inline(always)]
pub(super) fn in_mask(mut mask: u32) -> impl Iterator<Item = usize> + Clone {
    core::iter::from_fn(move || {
        let bit = (mask != 0).then(|| mask.trailing_zeros() as usize);
        mask &= mask.wrapping_sub(1);
        bit
    })
}

/// Rows of planes, each in its place.
#[inline(always)]
pub(super) fn planes_of([[nx, ny, nz], [fx, fy, fz]]: &[[Row; 3]; 2]) -> ([&Row; 3], [&Row; 3]) {
    ([nx, ny, nz], [fx, fy, fz])
}

impl<const GROUPS: usize> Stream<GROUPS> {
    /// Lanes are counted in a byte.
    const POSSIBLE: () = assert!(GROUPS > 0 && GROUPS * GROUP <= 256);

    pub(super) const fn new() -> Self {
        const { Self::POSSIBLE };
        Self {
            kinds: [[0; SORTED]; GROUPS],
            order: [[0; SORTED]; GROUPS],
            rays: Rays {
                groups: [Group::NONE; GROUPS],
                kinds: [Kind::new(0, 0); GROUPS],
                index: [[0; GROUP]; GROUPS],
            },
            levels: [Level::NONE; DEPTH_MAX + 1],
            used: 0,
            crossings: Crossings::NONE,
            quad: Quad::NONE,
            visited: BundleVisited::NONE,
        }
    }

    /// Traces rays: those of the same signs together, as many as there is room for.
    #[inline(always)]
    pub(super) fn trace<L: Lanes, S: BlockSource, Q: Query>(
        &mut self,
        lanes: L,
        single: &mut Cursor,
        source: &mut S,
        stops: &mut impl Stops<S::Error>,
        rays: &[Ray],
        queries: &mut [Q],
    ) -> Result<(), TraceError<S::Error>> {
        for (rays, queries) in rays.chunks(SORTED * GROUPS).zip(queries.chunks_mut(SORTED * GROUPS))
        {
            self.trace_sorted(&mut Flow { lanes, source, stops, rays, queries }, single)?;
        }
        Ok(())
    }

    /// Traces as many rays as are sorted at a time.
    #[inline(always)]
    fn trace_sorted<L: Lanes, S: BlockSource, P: Stops<S::Error>, Q: Query>(
        &mut self,
        flow: &mut Flow<'_, L, S, P, Q>,
        single: &mut Cursor,
    ) -> Result<(), TraceError<S::Error>> {
        let (lanes, rays) = (flow.lanes, flow.rays);
        let ends = self.sort(lanes, rays);
        let mut begin = 0;
        // A search before may have ended with an error.
        (self.used, self.levels[0].count) = (0, 0);
        for (&end, number) in ends.iter().zip(0_u8..) {
            let kind = Kind::new(number >> 2, number & 3);
            let (mut from, to) = (usize::from(begin), usize::from(end));
            begin = end;
            while from < to {
                if self.used >= GROUPS {
                    self.flush(flow, single, kind.signs())?;
                }
                let (first, count) = (self.used, self.levels[0].count);
                while from < to && self.used < GROUPS {
                    let members = self.order.as_flattened().get(from..to.min(from + GROUP));
                    let members = members.unwrap_or_default();
                    from += GROUP;
                    let mut wild =
                        self.rays.take(lanes, self.used, rays, members, kind, &mut self.levels[0]);
                    self.used += 1;
                    while wild != 0 {
                        let lane = wild.trailing_zeros() as usize;
                        wild &= wild - 1;
                        let Some(&i) = members.get(lane) else { continue };
                        flow.alone(single, i)?;
                    }
                }
                let taken = self.levels[0].count - count;
                if taken >= FEWEST && self.is_coherent(first) {
                    self.coherent(flow, kind.signs(), first, count..count + taken)?;
                }
            }
            // The last of these signs.
            if number & 3 == 3 {
                self.flush(flow, single, kind.signs())?;
            }
        }
        Ok(())
    }

    /// Traces the rays of the groups from `first` on, which stand in these places of the first list, by themselves; the others wait meanwhile.
    #[inline(always)]
    fn coherent<L: Lanes, S: BlockSource, P: Stops<S::Error>, Q: Query>(
        &mut self,
        flow: &mut Flow<'_, L, S, P, Q>,
        signs: u8,
        first: usize,
        places: Range<usize>,
    ) -> Result<(), TraceError<S::Error>> {
        let others = self.levels[0];
        let count = places.start;
        let list = self.levels[0].list.as_flattened_mut();
        list.fill(0);
        for &id in others.list.as_flattened().get(places).unwrap_or_default() {
            if let Some(lanes) = list.get_mut(usize::from(id) / GROUP) {
                *lanes |= 1 << (usize::from(id) % GROUP);
            }
        }
        self.levels[0].count = ((1_u64 << self.used) - (1_u64 << first)) as usize;
        flow.run::<true, GROUPS>(self, signs, first)?;
        self.used = first;
        self.levels[0] = Level { count, ..others };
        Ok(())
    }

    /// Traces the rays that have come together, which have these signs.
    #[inline(always)]
    fn flush<L: Lanes, S: BlockSource, P: Stops<S::Error>, Q: Query>(
        &mut self,
        flow: &mut Flow<'_, L, S, P, Q>,
        single: &mut Cursor,
        signs: u8,
    ) -> Result<(), TraceError<S::Error>> {
        let Level { list, count, .. } = &self.levels[0];
        let list = list.as_flattened().get(..*count).unwrap_or_default();
        let shortest = if flow.source.holds_all() { 1 } else { SHORTEST };
        if list.len() >= shortest {
            flow.run::<false, GROUPS>(self, signs, 0)?;
        } else {
            let index = self.rays.index.as_flattened();
            for &id in list {
                let Some(&ray) = index.get(usize::from(id)) else { continue };
                flow.alone(single, ray)?;
            }
            self.levels[0].count = 0;
        }
        self.used = 0;
        Ok(())
    }

    /// Whether the rays of the groups from here on go much the same way.
    #[inline(always)]
    fn is_coherent(&self, first: usize) -> bool {
        let groups = self.rays.groups.get(first..self.used).unwrap_or_default();
        (0..2).all(|axis| {
            let [least, greatest] = ends(groups, |group| group.shear.get(axis));
            greatest - least <= WIDEST
        })
    }

    /// Sorts rays by kind. Where the rays of each kind end.
    #[inline(always)]
    fn sort<L: Lanes>(&mut self, lanes: L, rays: &[Ray]) -> [u16; Kind::COUNT] {
        let (kinds, order) = (self.kinds.as_flattened_mut(), self.order.as_flattened_mut());
        let mut ends = [0_u16; Kind::COUNT];
        for (kind, ray) in kinds.iter_mut().zip(rays) {
            let of = lanes.kind(ray).index();
            *kind = of as u8;
            if let Some(count) = ends.get_mut(of) {
                *count = count.wrapping_add(1);
            }
        }
        let mut before = 0;
        for end in &mut ends {
            // Where they begin: it moves to the end as they are put down.
            before += core::mem::replace(end, before);
        }
        for (i, &kind) in (0_u16..).zip(kinds.iter().take(rays.len())) {
            let Some(end) = ends.get_mut(usize::from(kind)) else { continue };
            if let Some(place) = order.get_mut(usize::from(*end)) {
                *place = i;
            }
            *end = end.wrapping_add(1);
        }
        ends
    }
}

impl<const GROUPS: usize> Rays<GROUPS> {
    /// Puts rays into a group, and its lanes into a list. Those of its lanes that no box test can be made for are handed back.
    #[inline(always)]
    fn take<L: Lanes>(
        &mut self,
        lanes: L,
        at: usize,
        rays: &[Ray],
        members: &[u16],
        kind: Kind,
        to: &mut Level<GROUPS>,
    ) -> u8 {
        let places = (self.groups.get_mut(at), self.kinds.get_mut(at), self.index.get_mut(at));
        let (Some(group), Some(kind_of), Some(index)) = places else { return 0 };
        let filled = lanes.fill(rays, members, kind, group);
        *kind_of = kind;
        for (place, &member) in index.iter_mut().zip(members) {
            *place = member;
        }
        let list = to.list.as_flattened_mut();
        for lane in 0..GROUP {
            if let Some(place) = list.get_mut(to.count) {
                *place = (at * GROUP + lane) as u8;
            }
            to.count += usize::from(filled.lanes >> lane & 1);
        }
        filled.wild
    }
}
