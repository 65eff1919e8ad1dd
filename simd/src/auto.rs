use kiloray_core::block::BlockSource;
use kiloray_core::geometry::{Hit, Ray};
use kiloray_core::trace::{Batch, Bundle, Cursor, Scalar, TraceError, Tracer};

#[cfg(target_arch = "x86_64")]
use crate::avx2::Avx2;

/// Traces with the widest lanes that the machine has.
#[derive(Debug, Clone, Copy)]
pub struct Auto {
    #[cfg(target_arch = "x86_64")]
    avx2: Option<Avx2>,
}

impl Auto {
    /// Finds out what the machine can do.
    #[must_use]
    pub fn detect() -> Self {
        Self {
            #[cfg(target_arch = "x86_64")]
            avx2: Avx2::detect(),
        }
    }

    /// What it traces with.
    #[must_use]
    pub fn name(self) -> &'static str {
        #[cfg(target_arch = "x86_64")]
        if self.avx2.is_some() {
            return "avx2";
        }
        "scalar"
    }
}

impl Default for Auto {
    fn default() -> Self {
        Self::detect()
    }
}

impl Tracer for Auto {
    fn closest<S: BlockSource>(
        self,
        cursor: &mut Cursor,
        source: &mut S,
        ray: &Ray,
    ) -> Result<Option<Hit>, TraceError<S::Error>> {
        #[cfg(target_arch = "x86_64")]
        if let Some(lanes) = self.avx2 {
            // SAFETY: `lanes` proves that the machine has these features.
            return unsafe { entry::closest(lanes, cursor, source, ray) };
        }
        Scalar.closest(cursor, source, ray)
    }

    fn resume_closest<S: BlockSource>(
        self,
        cursor: &mut Cursor,
        source: &mut S,
    ) -> Result<Option<Hit>, TraceError<S::Error>> {
        #[cfg(target_arch = "x86_64")]
        if let Some(lanes) = self.avx2 {
            // SAFETY: `lanes` proves that the machine has these features.
            return unsafe { entry::resume_closest(lanes, cursor, source) };
        }
        Scalar.resume_closest(cursor, source)
    }

    fn any<S: BlockSource>(
        self,
        cursor: &mut Cursor,
        source: &mut S,
        ray: &Ray,
    ) -> Result<bool, TraceError<S::Error>> {
        #[cfg(target_arch = "x86_64")]
        if let Some(lanes) = self.avx2 {
            // SAFETY: `lanes` proves that the machine has these features.
            return unsafe { entry::any(lanes, cursor, source, ray) };
        }
        Scalar.any(cursor, source, ray)
    }

    fn resume_any<S: BlockSource>(
        self,
        cursor: &mut Cursor,
        source: &mut S,
    ) -> Result<bool, TraceError<S::Error>> {
        #[cfg(target_arch = "x86_64")]
        if let Some(lanes) = self.avx2 {
            // SAFETY: `lanes` proves that the machine has these features.
            return unsafe { entry::resume_any(lanes, cursor, source) };
        }
        Scalar.resume_any(cursor, source)
    }

    fn every<S: BlockSource>(
        self,
        cursor: &mut Cursor,
        source: &mut S,
        ray: &Ray,
        visit: impl FnMut(&Hit) -> bool,
    ) -> Result<(), TraceError<S::Error>> {
        #[cfg(target_arch = "x86_64")]
        if let Some(lanes) = self.avx2 {
            // SAFETY: `lanes` proves that the machine has these features.
            return unsafe { entry::every(lanes, cursor, source, ray, visit) };
        }
        Scalar.every(cursor, source, ray, visit)
    }

    fn closest_batch<S: BlockSource>(
        self,
        room: &mut Batch,
        source: &mut S,
        rays: &[Ray],
        hits: &mut [Option<Hit>],
    ) -> Result<(), TraceError<S::Error>> {
        #[cfg(target_arch = "x86_64")]
        if let Some(lanes) = self.avx2 {
            // SAFETY: `lanes` proves that the machine has these features.
            return unsafe { entry::closest_batch(lanes, room, source, rays, hits) };
        }
        Scalar.closest_batch(room, source, rays, hits)
    }

    fn any_batch<S: BlockSource>(
        self,
        room: &mut Batch,
        source: &mut S,
        rays: &[Ray],
        hits: &mut [bool],
    ) -> Result<(), TraceError<S::Error>> {
        #[cfg(target_arch = "x86_64")]
        if let Some(lanes) = self.avx2 {
            // SAFETY: `lanes` proves that the machine has these features.
            return unsafe { entry::any_batch(lanes, room, source, rays, hits) };
        }
        Scalar.any_batch(room, source, rays, hits)
    }

    fn closest_bundle<S: BlockSource>(
        self,
        room: &mut Bundle,
        source: &mut S,
        rays: &[Ray],
        hits: &mut [Option<Hit>],
    ) -> Result<(), TraceError<S::Error>> {
        #[cfg(target_arch = "x86_64")]
        if let Some(lanes) = self.avx2 {
            // SAFETY: `lanes` proves that the machine has these features.
            return unsafe { entry::closest_bundle(lanes, room, source, rays, hits) };
        }
        Scalar.closest_bundle(room, source, rays, hits)
    }

    fn any_bundle<S: BlockSource>(
        self,
        room: &mut Bundle,
        source: &mut S,
        rays: &[Ray],
        hits: &mut [bool],
    ) -> Result<(), TraceError<S::Error>> {
        #[cfg(target_arch = "x86_64")]
        if let Some(lanes) = self.avx2 {
            // SAFETY: `lanes` proves that the machine has these features.
            return unsafe { entry::any_bundle(lanes, room, source, rays, hits) };
        }
        Scalar.any_bundle(room, source, rays, hits)
    }
}

/// The entries of the AVX2 code: all that they call is inlined into them, and compiled for AVX2.
#[cfg(target_arch = "x86_64")]
mod entry {
    use super::{Avx2, Batch, BlockSource, Bundle, Cursor, Hit, Ray, TraceError};
    use kiloray_core::trace;

    #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
    pub(super) fn closest<S: BlockSource>(
        lanes: Avx2,
        cursor: &mut Cursor,
        source: &mut S,
        ray: &Ray,
    ) -> Result<Option<Hit>, TraceError<S::Error>> {
        trace::closest(lanes, cursor, source, ray)
    }

    #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
    pub(super) fn resume_closest<S: BlockSource>(
        lanes: Avx2,
        cursor: &mut Cursor,
        source: &mut S,
    ) -> Result<Option<Hit>, TraceError<S::Error>> {
        trace::resume_closest(lanes, cursor, source)
    }

    #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
    pub(super) fn any<S: BlockSource>(
        lanes: Avx2,
        cursor: &mut Cursor,
        source: &mut S,
        ray: &Ray,
    ) -> Result<bool, TraceError<S::Error>> {
        trace::any(lanes, cursor, source, ray)
    }

    #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
    pub(super) fn resume_any<S: BlockSource>(
        lanes: Avx2,
        cursor: &mut Cursor,
        source: &mut S,
    ) -> Result<bool, TraceError<S::Error>> {
        trace::resume_any(lanes, cursor, source)
    }

    #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
    pub(super) fn every<S: BlockSource>(
        lanes: Avx2,
        cursor: &mut Cursor,
        source: &mut S,
        ray: &Ray,
        visit: impl FnMut(&Hit) -> bool,
    ) -> Result<(), TraceError<S::Error>> {
        trace::every(lanes, cursor, source, ray, visit)
    }

    #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
    pub(super) fn closest_batch<S: BlockSource>(
        lanes: Avx2,
        room: &mut Batch,
        source: &mut S,
        rays: &[Ray],
        hits: &mut [Option<Hit>],
    ) -> Result<(), TraceError<S::Error>> {
        trace::closest_batch(lanes, room, source, rays, hits)
    }

    #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
    pub(super) fn any_batch<S: BlockSource>(
        lanes: Avx2,
        room: &mut Batch,
        source: &mut S,
        rays: &[Ray],
        hits: &mut [bool],
    ) -> Result<(), TraceError<S::Error>> {
        trace::any_batch(lanes, room, source, rays, hits)
    }

    #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
    pub(super) fn closest_bundle<S: BlockSource>(
        lanes: Avx2,
        room: &mut Bundle,
        source: &mut S,
        rays: &[Ray],
        hits: &mut [Option<Hit>],
    ) -> Result<(), TraceError<S::Error>> {
        trace::closest_bundle(lanes, room, source, rays, hits)
    }

    #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
    pub(super) fn any_bundle<S: BlockSource>(
        lanes: Avx2,
        room: &mut Bundle,
        source: &mut S,
        rays: &[Ray],
        hits: &mut [bool],
    ) -> Result<(), TraceError<S::Error>> {
        trace::any_bundle(lanes, room, source, rays, hits)
    }
}
