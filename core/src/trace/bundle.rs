//! Bundles of up to 64 rays, which visit nodes together as far as they go the same way.

use super::cursor::{Cursor, TraceError, Visited};
use super::flow::Stops;
use super::lanes::Lanes;
use super::query::Query;
use super::stream::Stream;
use super::tracer::Search;
use super::trail::Trail;
use crate::block::BlockSource;
use crate::geometry::Ray;

/// Rays of a bundle.
pub const BUNDLE: usize = 64;

/// Room for a bundle: 26 KiB.
#[derive(Debug, Clone)]
pub struct Bundle {
    /// Rays of one kind fill eight groups; two more, as a group has rays of one kind alone.
    stream: Stream<10>,
    stopped: Stopped,
    single: Cursor,
}

/// What rays visited together: what a machine profile turns into time.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct BundleVisited {
    /// Nodes, each for all rays that come to it.
    pub nodes: u64,
    /// Tests of eight rays against a box.
    pub boxes: u64,
    /// Tests of a ray against eight boxes.
    pub ray_boxes: u64,
    /// Tests of eight rays against a triangle.
    pub triangles: u64,
    /// Tests of a ray against the four triangles of a record.
    pub ray_triangles: u64,
    /// Blocks entered.
    pub blocks: u64,
    /// What was tested for single rays on the way, and all that was visited by rays that were alone.
    pub single: Visited,
}

/// Where rays of a bundle wait for blocks that the source does not have.
#[derive(Debug, Clone)]
struct Stopped {
    /// A bit for each ray.
    rays: u64,
    trails: [Trail; BUNDLE],
}

/// The first error is kept, and the other rays go on.
struct Waiting<'a, E> {
    stopped: &'a mut Stopped,
    lacks: Option<E>,
}

impl<E> Stops<E> for Waiting<'_, E> {
    fn lacks(&mut self, error: E) -> Result<(), E> {
        self.lacks.get_or_insert(error);
        Ok(())
    }

    fn stop(&mut self, ray: u16, trail: Trail) {
        if let Some(place) = self.stopped.trails.get_mut(usize::from(ray)) {
            *place = trail;
            self.stopped.rays |= 1 << ray;
        }
    }

    fn has_stopped(&self, ray: u16) -> bool {
        self.stopped.rays.unbounded_shr(ray.into()) & 1 != 0
    }
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
        let stopped = Stopped { rays: 0, trails: [Trail::START; BUNDLE] };
        Self { stream: Stream::new(), stopped, single: Cursor::new() }
    }

    /// Where a ray of the last bundle goes on, if the source has stopped it.
    #[inline]
    #[must_use]
    pub fn stopped(&self, ray: usize) -> Option<Trail> {
        let trail = self.stopped.trails.get(ray)?;
        (self.stopped.rays >> ray & 1 == 1).then_some(*trail)
    }

    /// The rays of the last bundle that the source has stopped, a bit each.
    #[must_use]
    pub const fn all_stopped(&self) -> u64 {
        self.stopped.rays
    }

    /// What was visited; counts from zero again.
    pub fn take_visited(&mut self) -> BundleVisited {
        let visited = core::mem::take(&mut self.stream.visited);
        BundleVisited { single: self.single.take_visited().and(&visited.single), ..visited }
    }
}

impl BundleVisited {
    pub(super) const NONE: Self = Self {
        nodes: 0,
        boxes: 0,
        ray_boxes: 0,
        triangles: 0,
        ray_triangles: 0,
        blocks: 0,
        single: Visited { nodes: 0, leaves: 0, blocks: 0 },
    };
}

/// A search of at most [`BUNDLE`] rays, those of the same signs together.
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
        let Bundle { stream, stopped, single } = room;
        stopped.rays = 0;
        let mut waiting = Waiting { stopped, lacks: None };
        stream.trace(lanes, single, source, &mut waiting, rays, queries)?;
        let Waiting { stopped, lacks } = waiting;
        if stopped.rays != 0 {
            // They have been hit beyond the block that they lacked.
            let answered = queries.iter().map(|query| query.answered() == Some(true));
            stopped.rays &= !answered.zip(0..).fold(0, |all, (is, at)| all | u64::from(is) << at);
        }
        lacks.map_or(Ok(()), |error| Err(TraceError::Source(error)))
    }
}
