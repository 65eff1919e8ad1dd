use crate::block::BlockSource;
use crate::geometry::{Hit, Ray};
use crate::shade::{PathRay, Shadow};
use crate::trace::{BUNDLE, Bundle, BundleVisited, TraceError, Tracer, Trail};
use glam::Vec3;

/// Room for rays that are traced together, and for what they hit until it is asked for: 33 KiB.
#[derive(Debug)]
pub struct Neighbours {
    room: Bundle,
    rays: [Ray; BUNDLE],
    hits: [Option<Hit>; BUNDLE],
    hidden: [bool; BUNDLE],
}

impl Default for Neighbours {
    fn default() -> Self {
        Self::new()
    }
}

impl Neighbours {
    /// Room for rays.
    #[must_use]
    pub const fn new() -> Self {
        const RAY: Ray = Ray { origin: Vec3::ZERO, direction: Vec3::ZERO, t_min: 0.0, t_max: 0.0 };
        Self {
            room: Bundle::new(),
            rays: [RAY; BUNDLE],
            hits: [None; BUNDLE],
            hidden: [false; BUNDLE],
        }
    }

    /// Finds the closest hits of the first [`BUNDLE`] rays: how many they were.
    pub(crate) fn trace<T: Tracer, S: BlockSource>(
        &mut self,
        tracer: T,
        source: &mut S,
        rays: impl Iterator<Item = Ray>,
    ) -> (usize, Result<(), TraceError<S::Error>>) {
        let together = fill(&mut self.rays, rays);
        let traced = tracer.closest_bundle(&mut self.room, source, together, &mut self.hits);
        (together.len(), traced)
    }

    /// Finds whether anything is in the way of the first [`BUNDLE`] rays: how many they were.
    pub(crate) fn ask<T: Tracer, S: BlockSource>(
        &mut self,
        tracer: T,
        source: &mut S,
        rays: impl Iterator<Item = Ray>,
    ) -> (usize, Result<(), TraceError<S::Error>>) {
        let together = fill(&mut self.rays, rays);
        let traced = tracer.any_bundle(&mut self.room, source, together, &mut self.hidden);
        (together.len(), traced)
    }

    /// The closest hit of a ray that was traced; of one that has stopped, the best so far.
    pub(crate) fn hit(&self, at: usize) -> Option<&Hit> {
        self.hits.get(at).and_then(Option::as_ref)
    }

    /// Whether anything is in the way of a ray that was asked about, as far as it is known.
    pub(crate) fn is_hidden(&self, at: usize) -> bool {
        self.hidden.get(at).copied().unwrap_or(true)
    }

    /// All rays that are hidden, as far as it is known: a bit each.
    pub(crate) fn all_hidden(&self) -> u64 {
        const { assert!(BUNDLE <= 64) };
        self.hidden.iter().zip(0..).fold(0, |all, (&hidden, at)| all | u64::from(hidden) << at)
    }

    /// All rays that have stopped for want of a block: a bit each.
    pub(crate) fn all_stopped(&self) -> u64 {
        self.room.all_stopped()
    }

    /// Where a ray has stopped for want of a block.
    pub(crate) fn stopped(&self, at: usize) -> Option<Trail> {
        self.room.stopped(at)
    }

    /// What was visited since the last call.
    pub(crate) fn take_visited(&mut self) -> BundleVisited {
        self.room.take_visited()
    }

    /// The closest hit of `rays[at]`, if `at` goes from 0 up by one.
    pub(super) fn closest<T: Tracer, S: BlockSource>(
        &mut self,
        tracer: T,
        source: &mut S,
        rays: &[PathRay],
        at: usize,
    ) -> Result<Option<Hit>, TraceError<S::Error>> {
        if at.is_multiple_of(BUNDLE) {
            let next = rays.get(at..).unwrap_or_default();
            self.trace(tracer, source, next.iter().map(PathRay::ray)).1?;
        }
        Ok(self.hit(at % BUNDLE).copied())
    }

    /// Whether anything is in the way of `rays[at]`, if `at` goes from 0 up by one.
    pub(super) fn hidden<T: Tracer, S: BlockSource>(
        &mut self,
        tracer: T,
        source: &mut S,
        rays: &[Shadow],
        at: usize,
    ) -> Result<bool, TraceError<S::Error>> {
        if at.is_multiple_of(BUNDLE) {
            let next = rays.get(at..).unwrap_or_default();
            self.ask(tracer, source, next.iter().map(Shadow::ray)).1?;
        }
        Ok(self.is_hidden(at % BUNDLE))
    }
}

/// Takes rays as long as there is room.
fn fill(room: &mut [Ray; BUNDLE], rays: impl Iterator<Item = Ray>) -> &[Ray] {
    let count = room.iter_mut().zip(rays).map(|(place, ray)| *place = ray).count();
    room.get(..count).unwrap_or_default()
}
