use super::batch::{Batch, Many};
use super::bundle::{BUNDLE, Bundle, Together};
use super::cursor::{Cursor, TraceError};
use super::lanes::{Kernel, Lanes};
use super::query::{Every, Query};
use super::scalar::Scalar;
use super::trail::Trail;
use super::walk::Single;
use crate::block::{BlockError, BlockLimits, BlockSource, BlockView};
use crate::geometry::{Hit, Ray};

/// A search that any lanes can do. A type without values: what it works on are arguments, so that they stay in registers.
pub trait Search {
    /// Where it keeps its state.
    type Room;
    /// What it traces.
    type Rays: ?Sized;
    /// What it asks of them.
    type Queries<Q>: ?Sized;

    /// Does it. Is inlined, so that all of it is compiled for the instructions of its caller.
    ///
    /// # Errors
    /// [`TraceError`].
    fn run<L: Lanes, S: BlockSource, Q: Query>(
        lanes: L,
        room: &mut Self::Room,
        source: &mut S,
        rays: &Self::Rays,
        queries: &mut Self::Queries<Q>,
    ) -> Result<(), TraceError<S::Error>>;
}

/// [`Tracer::check`].
struct Check<'a> {
    bytes: &'a [u8],
    block: u32,
    limits: &'a BlockLimits,
    checked: &'a mut Result<(), BlockError>,
}

impl Kernel for Check<'_> {
    #[inline(always)]
    fn run<L: Lanes>(self, _: L) {
        *self.checked = BlockView::parse(self.bytes, self.block, self.limits).map(drop);
    }
}

/// Traces rays, with the lanes that the machine has. All tracers find the same hits to the bit.
///
/// [`Scalar`] is one; `kiloray-simd` has one that finds out what the machine can do.
///
/// A search that its source has stopped can be continued: the [`Cursor`] then has the [`Trail`] to go on by, on this machine or
/// on another, with the same lanes or with others.
pub trait Tracer: Copy {
    /// Does a search with the lanes of the machine.
    ///
    /// # Errors
    /// Those of the search.
    fn run<T: Search, S: BlockSource, Q: Query>(
        self,
        room: &mut T::Room,
        source: &mut S,
        rays: &T::Rays,
        queries: &mut T::Queries<Q>,
    ) -> Result<(), TraceError<S::Error>>;

    /// Computes something else with the lanes of the machine.
    fn compute<K: Kernel>(self, kernel: K);

    /// Checks a block as [`BlockView::parse`] does, with the instructions of the machine.
    ///
    /// # Errors
    /// [`BlockError`] names the first thing found wrong.
    fn check(self, bytes: &[u8], block: u32, limits: &BlockLimits) -> Result<(), BlockError> {
        let mut checked = Ok(());
        self.compute(Check { bytes, block, limits, checked: &mut checked });
        checked
    }

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
        let mut best = None;
        let result = self.run::<Single<false>, S, Option<Hit>>(cursor, source, ray, &mut best);
        if result.is_err() {
            cursor.best = best;
        }
        result.map(|()| best)
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
        cursor.trail = *trail;
        let result = self.run::<Single<true>, S, Option<Hit>>(cursor, source, ray, &mut best);
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
        let mut found = false;
        self.run::<Single<false>, S, bool>(cursor, source, ray, &mut found)?;
        Ok(found)
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
        cursor.trail = *trail;
        self.run::<Single<true>, S, bool>(cursor, source, ray, &mut found)?;
        Ok(found)
    }

    /// Asks anything of a ray, from a trail on. Of an [`Option<Hit>`] it makes the closest hit, of a `bool` whether there is any.
    ///
    /// # Errors
    /// [`TraceError`]; after `Source` it goes on by [`Cursor::trail`], with the same query.
    #[inline]
    fn continue_query<S: BlockSource, Q: Query>(
        self,
        cursor: &mut Cursor,
        source: &mut S,
        ray: &Ray,
        trail: &Trail,
        query: &mut Q,
    ) -> Result<(), TraceError<S::Error>> {
        cursor.trail = *trail;
        self.run::<Single<true>, S, Q>(cursor, source, ray, query)
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
        self.run::<Single<false>, S, Every<_>>(cursor, source, ray, &mut Every(visit))
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
        cursor.trail = *trail;
        self.run::<Single<true>, S, Every<_>>(cursor, source, ray, &mut Every(visit))
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
        batch(self, room, source, rays, queries)
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
        batch(self, room, source, rays, queries)
    }

    /// The closest hits of coherent rays, `hits[i]` that of `rays[i]`, in bundles of [`BUNDLE`]: neighbours together, eight by
    /// eight. Of the longer slice the rest is left out. What is not coherent is traced ray by ray.
    ///
    /// # Errors
    /// [`TraceError`]. After `Source`, the first that happened, the bundle with the missing block was traced as far as the source reaches: for the rays that have
    /// [stopped](Bundle::stopped) a trail and the best hit so far are known, to be continued one by one; for the others, the hit. The bundles behind it
    /// were not begun.
    #[inline]
    fn closest_bundle<S: BlockSource>(
        self,
        room: &mut Bundle,
        source: &mut S,
        rays: &[Ray],
        hits: &mut [Option<Hit>],
    ) -> Result<(), TraceError<S::Error>> {
        let (rays, queries) = pair(rays, hits);
        queries.fill(None);
        self.query_bundle(room, source, rays, queries)
    }

    /// Whether each of many coherent rays hits anything, as [`Tracer::closest_bundle`].
    ///
    /// # Errors
    /// As [`Tracer::closest_bundle`]; but rays go past missing blocks together, and those that hit something beyond have not stopped.
    #[inline]
    fn any_bundle<S: BlockSource>(
        self,
        room: &mut Bundle,
        source: &mut S,
        rays: &[Ray],
        hits: &mut [bool],
    ) -> Result<(), TraceError<S::Error>> {
        let (rays, queries) = pair(rays, hits);
        queries.fill(false);
        self.query_bundle(room, source, rays, queries)
    }

    /// Asks anything of coherent rays, `queries[i]` of `rays[i]`, as [`Tracer::closest_bundle`]: each hit is shown once. Of the longer slice the rest is left out.
    ///
    /// # Errors
    /// As [`Tracer::closest_bundle`]; a ray that has stopped goes on with its query.
    #[inline]
    fn query_bundle<S: BlockSource, Q: Query>(
        self,
        room: &mut Bundle,
        source: &mut S,
        rays: &[Ray],
        queries: &mut [Q],
    ) -> Result<(), TraceError<S::Error>> {
        for (rays, queries) in rays.chunks(BUNDLE).zip(queries.chunks_mut(BUNDLE)) {
            let (rays, queries) = pair(rays, queries);
            self.run::<Together, S, Q>(room, source, rays, queries)?;
        }
        Ok(())
    }
}

impl Tracer for Scalar {
    #[inline]
    fn run<T: Search, S: BlockSource, Q: Query>(
        self,
        room: &mut T::Room,
        source: &mut S,
        rays: &T::Rays,
        queries: &mut T::Queries<Q>,
    ) -> Result<(), TraceError<S::Error>> {
        T::run(self, room, source, rays, queries)
    }

    #[inline]
    fn compute<K: Kernel>(self, kernel: K) {
        kernel.run(self);
    }
}

/// Traces a batch.
#[inline]
fn batch<T: Tracer, S: BlockSource, Q: Query>(
    tracer: T,
    room: &mut Batch,
    source: &mut S,
    rays: &[Ray],
    queries: &mut [Q],
) -> Result<(), TraceError<S::Error>> {
    tracer.run::<Many, S, Q>(room, source, rays, queries)
}

/// Rays and places for what they hit, as many of the one as of the other.
fn pair<'r, 'h, H>(rays: &'r [Ray], hits: &'h mut [H]) -> (&'r [Ray], &'h mut [H]) {
    let count = rays.len().min(hits.len());
    (rays.get(..count).unwrap_or_default(), hits.get_mut(..count).unwrap_or_default())
}
