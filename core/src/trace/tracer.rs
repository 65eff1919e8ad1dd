use super::batch::{Batch, Many};
use super::bundle::{BUNDLE, Bundle, Together};
use super::cursor::{Cursor, TraceError};
use super::lanes::Lanes;
use super::query::{Any, Closest, Every};
use super::scalar::Scalar;
use super::trail::Trail;
use super::walk::Single;
use crate::block::BlockSource;
use crate::geometry::{Hit, Ray};

/// A search that any lanes can do.
pub trait Search {
    /// What comes of it.
    type Answer;

    /// Does it. Is inlined, so that all of it is compiled for the instructions of its caller.
    fn run<L: Lanes>(self, lanes: L) -> Self::Answer;
}

/// Traces rays, with the lanes that the machine has. All tracers find the same hits to the bit.
///
/// [`Scalar`] is one; `kiloray-simd` has one that finds out what the machine can do.
///
/// A search that its source has stopped can be continued: the [`Cursor`] then has the [`Trail`] to go on by, on this machine or
/// on another, with the same lanes or with others.
pub trait Tracer: Copy {
    /// Does a search with the lanes of the machine.
    fn run<T: Search>(self, search: T) -> T::Answer;

    /// The closest hit of a ray.
    ///
    /// # Errors
    /// [`TraceError`]; after `Source` it goes on with [`Tracer::continue_closest`].
    #[inline]
    fn closest<S: BlockSource>(
        self,
        cursor: &mut Cursor,
        source: &mut S,
        ray: &Ray,
    ) -> Result<Option<Hit>, TraceError<S::Error>> {
        self.continue_closest(cursor, source, ray, None, &Trail::START)
    }

    /// The closest hit of a ray, from a trail on, with the best hit so far.
    ///
    /// # Errors
    /// As [`Tracer::closest`].
    #[inline]
    fn continue_closest<S: BlockSource>(
        self,
        cursor: &mut Cursor,
        source: &mut S,
        ray: &Ray,
        mut best: Option<Hit>,
        trail: &Trail,
    ) -> Result<Option<Hit>, TraceError<S::Error>> {
        let query = Closest(&mut best);
        let result = self.run(Single { cursor: &mut *cursor, source, ray, trail, query });
        if result.is_err() {
            cursor.best = best;
        }
        result.map(|()| best)
    }

    /// Whether a ray hits anything.
    ///
    /// # Errors
    /// [`TraceError`]; after `Source` it goes on with [`Tracer::continue_any`].
    #[inline]
    fn any<S: BlockSource>(
        self,
        cursor: &mut Cursor,
        source: &mut S,
        ray: &Ray,
    ) -> Result<bool, TraceError<S::Error>> {
        self.continue_any(cursor, source, ray, &Trail::START)
    }

    /// Whether a ray hits anything, from a trail on.
    ///
    /// # Errors
    /// As [`Tracer::any`].
    #[inline]
    fn continue_any<S: BlockSource>(
        self,
        cursor: &mut Cursor,
        source: &mut S,
        ray: &Ray,
        trail: &Trail,
    ) -> Result<bool, TraceError<S::Error>> {
        let mut found = false;
        let query = Any(&mut found);
        self.run(Single { cursor, source, ray, trail, query })?;
        Ok(found)
    }

    /// Shows every hit of a ray to `visit`, once, in no order that means anything; `true` ends it. For
    /// shadow rays through what is transparent: the sum of what the hits take must not depend on their order.
    ///
    /// # Errors
    /// [`TraceError`]; after `Source` it goes on with [`Tracer::continue_every`].
    #[inline]
    fn every<S: BlockSource>(
        self,
        cursor: &mut Cursor,
        source: &mut S,
        ray: &Ray,
        visit: impl FnMut(&Hit) -> bool,
    ) -> Result<(), TraceError<S::Error>> {
        self.continue_every(cursor, source, ray, &Trail::START, visit)
    }

    /// Shows the hits of a ray from a trail on to `visit`: each is shown once, however often the search is stopped.
    ///
    /// # Errors
    /// As [`Tracer::every`].
    #[inline]
    fn continue_every<S: BlockSource>(
        self,
        cursor: &mut Cursor,
        source: &mut S,
        ray: &Ray,
        trail: &Trail,
        visit: impl FnMut(&Hit) -> bool,
    ) -> Result<(), TraceError<S::Error>> {
        self.run(Single { cursor, source, ray, trail, query: Every(visit) })
    }

    /// The closest hits of many rays, `hits[i]` that of `rays[i]`; of the longer slice the rest is left out. A source
    /// that does not hold all blocks is asked for each block once for as many rays as want it.
    ///
    /// # Errors
    /// [`TraceError`]: the hits are then incomplete, and the batch begins anew.
    #[inline]
    fn closest_batch<S: BlockSource>(
        self,
        room: &mut Batch,
        source: &mut S,
        rays: &[Ray],
        hits: &mut [Option<Hit>],
    ) -> Result<(), TraceError<S::Error>> {
        let (rays, queries) = pair(rays, hits);
        queries.fill(None);
        self.run(Many { room, source, rays, queries })
    }

    /// Whether each of many rays hits anything, as [`Tracer::closest_batch`].
    ///
    /// # Errors
    /// As [`Tracer::closest_batch`].
    #[inline]
    fn any_batch<S: BlockSource>(
        self,
        room: &mut Batch,
        source: &mut S,
        rays: &[Ray],
        hits: &mut [bool],
    ) -> Result<(), TraceError<S::Error>> {
        let (rays, queries) = pair(rays, hits);
        queries.fill(false);
        self.run(Many { room, source, rays, queries })
    }

    /// The closest hits of coherent rays, `hits[i]` that of `rays[i]`, in bundles of [`BUNDLE`]: neighbours together, eight by
    /// eight. Of the longer slice the rest is left out. What is not coherent, or a source that does not hold all blocks,
    /// is traced ray by ray.
    ///
    /// # Errors
    /// [`TraceError`]: the hits are then incomplete, and the bundle begins anew.
    #[inline]
    fn closest_bundle<S: BlockSource>(
        self,
        room: &mut Bundle,
        source: &mut S,
        rays: &[Ray],
        hits: &mut [Option<Hit>],
    ) -> Result<(), TraceError<S::Error>> {
        for (rays, hits) in rays.chunks(BUNDLE).zip(hits.chunks_mut(BUNDLE)) {
            let (rays, queries) = pair(rays, hits);
            queries.fill(None);
            self.run(Together { room, source, rays, queries })?;
        }
        Ok(())
    }

    /// Whether each of many coherent rays hits anything, as [`Tracer::closest_bundle`].
    ///
    /// # Errors
    /// As [`Tracer::closest_bundle`].
    #[inline]
    fn any_bundle<S: BlockSource>(
        self,
        room: &mut Bundle,
        source: &mut S,
        rays: &[Ray],
        hits: &mut [bool],
    ) -> Result<(), TraceError<S::Error>> {
        for (rays, hits) in rays.chunks(BUNDLE).zip(hits.chunks_mut(BUNDLE)) {
            let (rays, queries) = pair(rays, hits);
            queries.fill(false);
            self.run(Together { room, source, rays, queries })?;
        }
        Ok(())
    }
}

impl Tracer for Scalar {
    #[inline]
    fn run<T: Search>(self, search: T) -> T::Answer {
        search.run(self)
    }
}

/// Rays and places for what they hit, as many of the one as of the other.
fn pair<'r, 'h, H>(rays: &'r [Ray], hits: &'h mut [H]) -> (&'r [Ray], &'h mut [H]) {
    let count = rays.len().min(hits.len());
    (rays.get(..count).unwrap_or_default(), hits.get_mut(..count).unwrap_or_default())
}
