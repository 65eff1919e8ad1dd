use crate::block::BlockSource;
use crate::geometry::{Hit, Ray};
use crate::shade::{PathRay, Shadow};
use crate::trace::{BUNDLE, Bundle, TraceError, Tracer};
use glam::Vec3;

/// Room for rays that are traced together, and for what they hit until it is asked for.
#[derive(Debug)]
pub(super) struct Neighbours {
    room: Bundle,
    rays: [Ray; BUNDLE],
    hits: [Option<Hit>; BUNDLE],
    hidden: [bool; BUNDLE],
}

impl Neighbours {
    pub(super) const fn new() -> Self {
        const RAY: Ray = Ray { origin: Vec3::ZERO, direction: Vec3::ZERO, t_min: 0.0, t_max: 0.0 };
        Self {
            room: Bundle::new(),
            rays: [RAY; BUNDLE],
            hits: [None; BUNDLE],
            hidden: [false; BUNDLE],
        }
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
            let next = rays.get(at..).unwrap_or_default().iter().map(PathRay::ray);
            let count = fill(&mut self.rays, next);
            let together = self.rays.get(..count).unwrap_or_default();
            tracer.closest_bundle(&mut self.room, source, together, &mut self.hits)?;
        }
        Ok(self.hits.get(at % BUNDLE).copied().flatten())
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
            let next = rays.get(at..).unwrap_or_default().iter().map(Shadow::ray);
            let count = fill(&mut self.rays, next);
            let together = self.rays.get(..count).unwrap_or_default();
            tracer.any_bundle(&mut self.room, source, together, &mut self.hidden)?;
        }
        Ok(self.hidden.get(at % BUNDLE).copied().unwrap_or(true))
    }
}

/// Takes rays as long as there is room: how many.
fn fill(room: &mut [Ray; BUNDLE], rays: impl Iterator<Item = Ray>) -> usize {
    room.iter_mut().zip(rays).map(|(place, ray)| *place = ray).count()
}
