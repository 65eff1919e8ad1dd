//! Batches of any rays, which visit nodes together as far as they go the same way.

use super::cursor::{Cursor, TraceError};
use super::flow::Stops;
use super::lanes::Lanes;
use super::query::Query;
use super::stream::Stream;
use super::tracer::Search;
use super::trail::Trail;
use crate::block::BlockSource;
use crate::geometry::Ray;

/// Room for batches: 52 KiB.
#[derive(Debug, Clone)]
pub struct Batch {
    stream: Stream<32>,
    single: Cursor,
}

impl Default for Batch {
    fn default() -> Self {
        Self::new()
    }
}

impl Batch {
    /// Room for batches.
    #[must_use]
    pub const fn new() -> Self {
        Self { stream: Stream::new(), single: Cursor::new() }
    }
}

/// A search of many rays.
pub(super) struct Many;

impl Search for Many {
    type Room = Batch;
    type Rays = [Ray];
    type Queries<Q> = [Q];

    #[inline(always)]
    fn run<L: Lanes, S: BlockSource, Q: Query>(
        lanes: L,
        room: &mut Batch,
        source: &mut S,
        rays: &[Ray],
        queries: &mut [Q],
    ) -> Result<(), TraceError<S::Error>> {
        room.stream.trace(lanes, &mut room.single, source, &mut Whole, rays, queries)
    }
}

/// A batch is traced as a whole, or begins anew.
struct Whole;

impl<E> Stops<E> for Whole {
    fn lacks(&mut self, error: E) -> Result<(), E> {
        Err(error)
    }

    fn stop(&mut self, _: u16, _: Trail) {}

    fn has_stopped(&self, _: u16) -> bool {
        false
    }
}
