use super::batch::{self, Batch};
use super::bundle::{self, Bundle};
use super::cursor::{Cursor, TraceError};
use super::scalar::Scalar;
use super::walk;
use crate::block::BlockSource;
use crate::geometry::{Hit, Ray};

/// Traces rays, with the lanes that the machine has. All tracers find the same hits to the bit.
///
/// [`Scalar`] is one; `kiloray-simd` has one that finds out what the machine can do.
pub trait Tracer: Copy {
    /// The closest hit of a ray.
    ///
    /// # Errors
    /// [`TraceError`]; after `Source` it goes on with [`Tracer::resume_closest`].
    fn closest<S: BlockSource>(
        self,
        cursor: &mut Cursor,
        source: &mut S,
        ray: &Ray,
    ) -> Result<Option<Hit>, TraceError<S::Error>>;

    /// Goes on with a closest hit that its source has stopped.
    ///
    /// # Errors
    /// As [`Tracer::closest`].
    fn resume_closest<S: BlockSource>(
        self,
        cursor: &mut Cursor,
        source: &mut S,
    ) -> Result<Option<Hit>, TraceError<S::Error>>;

    /// Whether a ray hits anything.
    ///
    /// # Errors
    /// [`TraceError`]; after `Source` it goes on with [`Tracer::resume_any`].
    fn any<S: BlockSource>(
        self,
        cursor: &mut Cursor,
        source: &mut S,
        ray: &Ray,
    ) -> Result<bool, TraceError<S::Error>>;

    /// Goes on with an any hit that its source has stopped.
    ///
    /// # Errors
    /// As [`Tracer::any`].
    fn resume_any<S: BlockSource>(
        self,
        cursor: &mut Cursor,
        source: &mut S,
    ) -> Result<bool, TraceError<S::Error>>;

    /// Shows every hit of a ray to `visit`, once, in no order that means anything; `true` ends it. For
    /// shadow rays through what is transparent: the sum of what the hits take must not depend on their order.
    ///
    /// # Errors
    /// [`TraceError`].
    fn every<S: BlockSource>(
        self,
        cursor: &mut Cursor,
        source: &mut S,
        ray: &Ray,
        visit: impl FnMut(&Hit) -> bool,
    ) -> Result<(), TraceError<S::Error>>;

    /// The closest hits of many rays, `hits[i]` that of `rays[i]`; of the longer slice the rest is left out. A source
    /// that does not hold all blocks is asked for each block once for as many rays as want it.
    ///
    /// # Errors
    /// [`TraceError`]: the hits are then incomplete, and the batch begins anew.
    fn closest_batch<S: BlockSource>(
        self,
        room: &mut Batch,
        source: &mut S,
        rays: &[Ray],
        hits: &mut [Option<Hit>],
    ) -> Result<(), TraceError<S::Error>>;

    /// Whether each of many rays hits anything, as [`Tracer::closest_batch`].
    ///
    /// # Errors
    /// As [`Tracer::closest_batch`].
    fn any_batch<S: BlockSource>(
        self,
        room: &mut Batch,
        source: &mut S,
        rays: &[Ray],
        hits: &mut [bool],
    ) -> Result<(), TraceError<S::Error>>;

    /// The closest hits of coherent rays, `hits[i]` that of `rays[i]`, in bundles of [`BUNDLE`](super::BUNDLE): neighbours together, eight by
    /// eight. Of the longer slice the rest is left out. What is not coherent, or a source that does not hold all blocks,
    /// is traced ray by ray.
    ///
    /// # Errors
    /// [`TraceError`]: the hits are then incomplete, and the bundle begins anew.
    fn closest_bundle<S: BlockSource>(
        self,
        room: &mut Bundle,
        source: &mut S,
        rays: &[Ray],
        hits: &mut [Option<Hit>],
    ) -> Result<(), TraceError<S::Error>>;

    /// Whether each of many coherent rays hits anything, as [`Tracer::closest_bundle`].
    ///
    /// # Errors
    /// As [`Tracer::closest_bundle`].
    fn any_bundle<S: BlockSource>(
        self,
        room: &mut Bundle,
        source: &mut S,
        rays: &[Ray],
        hits: &mut [bool],
    ) -> Result<(), TraceError<S::Error>>;
}

impl Tracer for Scalar {
    fn closest<S: BlockSource>(
        self,
        cursor: &mut Cursor,
        source: &mut S,
        ray: &Ray,
    ) -> Result<Option<Hit>, TraceError<S::Error>> {
        walk::closest(self, cursor, source, ray)
    }

    fn resume_closest<S: BlockSource>(
        self,
        cursor: &mut Cursor,
        source: &mut S,
    ) -> Result<Option<Hit>, TraceError<S::Error>> {
        walk::resume_closest(self, cursor, source)
    }

    fn any<S: BlockSource>(
        self,
        cursor: &mut Cursor,
        source: &mut S,
        ray: &Ray,
    ) -> Result<bool, TraceError<S::Error>> {
        walk::any(self, cursor, source, ray)
    }

    fn resume_any<S: BlockSource>(
        self,
        cursor: &mut Cursor,
        source: &mut S,
    ) -> Result<bool, TraceError<S::Error>> {
        walk::resume_any(self, cursor, source)
    }

    fn every<S: BlockSource>(
        self,
        cursor: &mut Cursor,
        source: &mut S,
        ray: &Ray,
        visit: impl FnMut(&Hit) -> bool,
    ) -> Result<(), TraceError<S::Error>> {
        walk::every(self, cursor, source, ray, visit)
    }

    fn closest_batch<S: BlockSource>(
        self,
        room: &mut Batch,
        source: &mut S,
        rays: &[Ray],
        hits: &mut [Option<Hit>],
    ) -> Result<(), TraceError<S::Error>> {
        batch::closest_batch(self, room, source, rays, hits)
    }

    fn any_batch<S: BlockSource>(
        self,
        room: &mut Batch,
        source: &mut S,
        rays: &[Ray],
        hits: &mut [bool],
    ) -> Result<(), TraceError<S::Error>> {
        batch::any_batch(self, room, source, rays, hits)
    }

    fn closest_bundle<S: BlockSource>(
        self,
        room: &mut Bundle,
        source: &mut S,
        rays: &[Ray],
        hits: &mut [Option<Hit>],
    ) -> Result<(), TraceError<S::Error>> {
        bundle::closest_bundle(self, room, source, rays, hits)
    }

    fn any_bundle<S: BlockSource>(
        self,
        room: &mut Bundle,
        source: &mut S,
        rays: &[Ray],
        hits: &mut [bool],
    ) -> Result<(), TraceError<S::Error>> {
        bundle::any_bundle(self, room, source, rays, hits)
    }
}
