use super::neighbours::Neighbours;
use crate::block::BlockSource;
use crate::material::{Made, OpticalDepth, Surfaces};
use crate::real::LANES;
use crate::scene::Material;
use crate::shade::{PathRay, Point, Shader, Shadow, Sum};
use crate::trace::{BUNDLE, TraceError, Tracer};

/// Rays that are traced a bundle at a time, and the surfaces that they hit.
#[derive(Debug)]
pub(super) struct Together {
    rays: Neighbours,
    surfaces: [Surfaces; BUNDLE / LANES],
}

impl Together {
    /// No ray is under way.
    pub(super) const fn new() -> Self {
        Self { rays: Neighbours::new(), surfaces: [const { Surfaces::new() }; BUNDLE / LANES] }
    }

    /// Finds what `rays[at]` hits, if `at` goes from 0 up by one.
    #[inline(always)]
    pub(super) fn closest<T: Tracer, S: BlockSource>(
        &mut self,
        tracer: T,
        source: &mut S,
        rays: &[PathRay],
        at: usize,
        through: bool,
    ) -> Result<(), TraceError<S::Error>> {
        if !at.is_multiple_of(BUNDLE) {
            return Ok(());
        }
        let next = rays.get(at..).unwrap_or_default();
        self.rays.trace(tracer, source, next.iter().map(PathRay::ray)).1?;
        let eights = next.chunks(LANES).zip(self.rays.hits().chunks(LANES));
        for (surfaces, (rays, hits)) in self.surfaces.iter_mut().zip(eights) {
            let directions = rays.iter().map(PathRay::direction);
            surfaces.make(tracer, directions.zip(hits), through);
        }
        Ok(())
    }

    /// What the ray `rays[at]`, whose hit was found, brings: see [`Shader::arrive`].
    #[inline(always)]
    pub(super) fn arrive(
        &self,
        shader: &Shader<'_>,
        packed: &PathRay,
        at: usize,
    ) -> (Sum, Option<Point>) {
        let at = at % BUNDLE;
        let made = Made { surfaces: self.surfaces.get(at / LANES), lane: at % LANES };
        shader.arrive_at(&packed.path(), &packed.ray(), self.rays.hit(at), made)
    }

    /// What `rays[at]` has lost on its way, if `at` goes from 0 up by one: see [`Neighbours::ask`].
    pub(super) fn lost<T: Tracer, S: BlockSource>(
        &mut self,
        tracer: T,
        source: &mut S,
        rays: &[Shadow],
        at: usize,
        materials: Option<&[Material]>,
    ) -> Result<OpticalDepth, TraceError<S::Error>> {
        if at.is_multiple_of(BUNDLE) {
            let next = rays.get(at..).unwrap_or_default();
            self.rays.ask(tracer, source, next.iter().map(Shadow::ray), materials).1?;
        }
        Ok(self.rays.depth(at % BUNDLE))
    }
}
