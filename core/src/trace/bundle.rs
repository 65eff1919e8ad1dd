//! Bundles of up to 64 coherent rays, which visit nodes together.

use super::beam::Beam;
use super::cursor::{Cursor, TraceError, Visited};
use super::frame::BoxRay;
use super::group::{Crossings, GROUP, Group};
use super::lanes::Lanes;
use super::query::Query;
use super::together::{Room, Stack, together};
use super::tracer::Search;
use super::trail::Trail;
use super::walk::Single;
use crate::block::BlockSource;
use crate::geometry::{PreparedRay, Ray};

/// Rays of a bundle.
pub const BUNDLE: usize = GROUP * GROUPS;
/// Groups of a bundle.
pub(super) const GROUPS: usize = 8;

/// Fewer rays than this are traced one by one.
const FEWEST: usize = 4;
/// If the slopes along the greatest axis differ by more than this, rays are traced one by one.
const WIDEST: f32 = 0.5;

/// Room for a bundle: 22 KiB.
#[derive(Debug, Clone)]
pub struct Bundle {
    pub(super) rays: Rays,
    pub(super) stack: Stack,
    stops: Stops,
    crossings: Crossings,
    visited: BundleVisited,
    single: Cursor,
}

/// What rays visited together: what a machine profile turns into time.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct BundleVisited {
    /// Nodes: eight boxes each, for all rays as one.
    pub nodes: u64,
    /// Boxes, for eight rays side by side.
    pub boxes: u64,
    /// Triangles, for eight rays side by side.
    pub triangles: u64,
    /// Blocks entered.
    pub blocks: u64,
    /// What was tested for single rays on the way, and all that was visited by rays that were alone.
    pub single: Visited,
}

/// Where rays of a bundle wait for blocks that the source does not have.
#[derive(Debug, Clone)]
pub(super) struct Stops {
    /// A bit for each ray.
    stopped: u64,
    trails: [Trail; BUNDLE],
}

impl Stops {
    pub(super) fn stop(&mut self, ray: u8, trail: Trail) {
        if let Some(place) = self.trails.get_mut(usize::from(ray)) {
            *place = trail;
            self.stopped |= 1 << ray;
        }
    }
}

/// The rays of a bundle.
#[derive(Debug, Clone)]
pub(super) struct Rays {
    /// As they came.
    pub(super) prepared: [PreparedRay; BUNDLE],
    /// The [`kind`] of each.
    kinds: [u8; BUNDLE],
    /// Which ray is in a lane.
    pub(super) order: [u8; BUNDLE],
    pub(super) groups: [Group; GROUPS],
    /// Bit `g`: group `g` has rays.
    pub(super) used: u32,
    pub(super) beam: Beam,
    /// Least `t` of all.
    pub(super) t_min: f32,
}

impl Default for Bundle {
    fn default() -> Self {
        Self::new()
    }
}

impl Bundle {
    /// Room for bundles.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            rays: Rays {
                prepared: [PreparedRay::NONE; BUNDLE],
                kinds: [0; BUNDLE],
                order: [0; BUNDLE],
                groups: [Group::NONE; GROUPS],
                used: 0,
                beam: Beam::NONE,
                t_min: 0.0,
            },
            stack: Stack::new(),
            stops: Stops { stopped: 0, trails: [Trail::START; BUNDLE] },
            crossings: Crossings::NONE,
            visited: BundleVisited::NONE,
            single: Cursor::new(),
        }
    }

    /// Where a ray of the last bundle goes on, if the source has stopped it.
    #[inline]
    #[must_use]
    pub fn stopped(&self, ray: usize) -> Option<Trail> {
        let trail = self.stops.trails.get(ray)?;
        (self.stops.stopped >> ray & 1 == 1).then_some(*trail)
    }

    /// The rays of the last bundle that the source has stopped, a bit each.
    #[must_use]
    pub const fn all_stopped(&self) -> u64 {
        self.stops.stopped
    }

    /// What was visited; counts from zero again.
    pub fn take_visited(&mut self) -> BundleVisited {
        let single = self.single.take_visited();
        let visited = core::mem::take(&mut self.visited);
        BundleVisited { single: single.and(&visited.single), ..visited }
    }
}

impl BundleVisited {
    const NONE: Self = Self {
        nodes: 0,
        boxes: 0,
        triangles: 0,
        blocks: 0,
        single: Visited { nodes: 0, leaves: 0, blocks: 0 },
    };
}

/// A search of at most [`BUNDLE`] rays, as many together as are coherent.
pub(super) struct Together;

impl Search for Together {
    type Room = Bundle;
    type Rays = [Ray];
    type Queries<Q> = [Q];

    #[inline(always)]
    fn run<L: Lanes, S: BlockSource, Q: Query>(
        lanes: L,
        room: &mut Bundle,
        source: &mut S,
        rays: &[Ray],
        queries: &mut [Q],
    ) -> Result<(), TraceError<S::Error>> {
        let Bundle { rays: bundle, stack, stops, crossings, visited, single } = room;
        stops.stopped = 0;
        let mut lacks = Ok(());
        let mut left = bundle.prepare(rays);
        while bundle.coherent(&mut left) {
            let room = Room { stack: &mut *stack, stops: &mut *stops, crossings: &mut *crossings };
            let lacked = together(lanes, bundle, room, visited, source, queries)?;
            lacks = lacks.and(lacked);
        }
        while left.alone != 0 {
            let i = left.alone.trailing_zeros();
            left.alone &= left.alone - 1;
            let (Some(ray), Some(query)) = (rays.get(i as usize), queries.get_mut(i as usize))
            else {
                continue;
            };
            match Single::<false>::run(lanes, single, source, ray, query) {
                Err(TraceError::Source(error)) => {
                    stops.stop(i as u8, single.trail());
                    lacks = lacks.and(Err(error));
                }
                result => result?,
            }
        }
        lacks.map_err(TraceError::Source)
    }
}

/// Rays that are not in a bundle yet, a bit each.
struct Left {
    waiting: u64,
    /// To be traced one by one.
    alone: u64,
}

/// Signs and greatest axis: rays of a bundle have them in common.
#[inline(always)]
fn kind(ray: &PreparedRay) -> u8 {
    ray.signs | ray.axis << 3
}

impl Rays {
    #[inline(always)]
    fn prepare(&mut self, rays: &[Ray]) -> Left {
        let mut left = Left { waiting: 0, alone: 0 };
        let places = self.prepared.iter_mut().zip(&mut self.kinds);
        for (i, ((place, kind_of), ray)) in places.zip(rays).enumerate() {
            let prepared = PreparedRay::new(ray);
            *kind_of = kind(&prepared);
            left.waiting |= u64::from(!prepared.is_none()) << i;
            *place = prepared;
        }
        left
    }

    /// Makes the next bundle of what is left. `false`: there is none.
    #[inline(always)]
    fn coherent(&mut self, left: &mut Left) -> bool {
        while left.waiting != 0 {
            let first = left.waiting.trailing_zeros() as usize;
            let kind_of = self.kinds.get(first).copied().unwrap_or(0);
            let (mut low, mut high) = ([f32::INFINITY; 2], [f32::NEG_INFINITY; 2]);
            let mut members = 0_u64;
            let mut waiting = left.waiting;
            while waiting != 0 {
                let i = waiting.trailing_zeros();
                waiting &= waiting - 1;
                if self.kinds.get(i as usize) != Some(&kind_of) {
                    continue;
                }
                let Some(ray) = self.prepared.get(i as usize) else { continue };
                members |= 1 << i;
                for ((low, high), x) in low.iter_mut().zip(&mut high).zip(ray.shear) {
                    *low = if x < *low { x } else { *low };
                    *high = if x > *high { x } else { *high };
                }
            }
            left.waiting &= !members;
            let wide = low.iter().zip(&high).any(|(low, high)| high - low > WIDEST);
            if wide || (members.count_ones() as usize) < FEWEST {
                left.alone |= members;
            } else {
                let wild = self.group(members);
                left.alone |= wild;
                if members != wild {
                    return true;
                }
            }
        }
        false
    }

    /// Fills the groups with these rays. Those that no box test can be made for are handed back.
    #[inline(always)]
    fn group(&mut self, members: u64) -> u64 {
        self.beam = Beam::NONE;
        self.t_min = f32::INFINITY;
        let mut waiting = members;
        let mut wild = 0;
        let mut place = 0;
        while waiting != 0 {
            let i = waiting.trailing_zeros();
            waiting &= waiting - 1;
            let Some(ray) = self.prepared.get(i as usize) else { continue };
            let boxes = BoxRay::new(ray);
            if boxes.pad == f32::INFINITY {
                wild |= 1 << i;
                continue;
            }
            let lane = place % GROUP;
            let order = self.order.get_mut(place);
            let (Some(group), Some(order)) = (self.groups.get_mut(place / GROUP), order) else {
                continue;
            };
            if lane == 0 {
                *group = Group::NONE;
            }
            group.set(lane, ray, &boxes);
            *order = i as u8;
            self.beam.take_in(&boxes);
            self.t_min = if ray.t_min < self.t_min { ray.t_min } else { self.t_min };
            place += 1;
        }
        self.used = (1_u32 << place.div_ceil(GROUP).min(GROUPS)) - 1;
        wild
    }
}
