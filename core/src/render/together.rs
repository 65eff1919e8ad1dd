use super::neighbours::Neighbours;
use crate::block::BlockSource;
use crate::material::{Made, OpticalDepth, Surfaces};
use crate::real::LANES;
use crate::scene::{Material, Needs};
use crate::shade::{Glances, Memo, PathRay, Point, Shader, Shadow, Sum};
use crate::trace::{BUNDLE, TraceError, Tracer};

/// Rays that are traced a bundle at a time, and the surfaces that they hit.
#[derive(Debug)]
pub(super) struct Together {
    rays: Neighbours,
    surfaces: [Surfaces; EIGHTS],
    glances: [Glances; EIGHTS],
}

/// A bundle in parts that lanes do at once.
const EIGHTS: usize = BUNDLE / LANES;

impl Together {
    /// No ray is under way.
    pub(super) const fn new() -> Self {
        Self {
            rays: Neighbours::new(),
            surfaces: [const { Surfaces::new() }; EIGHTS],
            glances: [const { Glances::new() }; EIGHTS],
        }
    }

    /// Finds what `rays[at]` hits, if `at` goes from 0 up by one.
    #[inline(always)]
    pub(super) fn closest<T: Tracer, S: BlockSource>(
        &mut self,
        tracer: T,
        source: &mut S,
        rays: &[PathRay],
        at: usize,
        shader: &Shader<'_>,
    ) -> Result<(), TraceError<S::Error>> {
        if !at.is_multiple_of(BUNDLE) {
            return Ok(());
        }
        let next = rays.get(at..).unwrap_or_default();
        self.rays.trace(tracer, source, next.iter().map(PathRay::ray)).1?;
        let eights = next.chunks(LANES).zip(self.rays.hits().chunks(LANES));
        let through = shader.tables().needs.any(Needs::SPECULAR | Needs::TRANSPARENT);
        let places = self.surfaces.iter_mut().zip(&mut self.glances);
        for ((surfaces, glances), (rays, hits)) in places.zip(eights) {
            let directions = rays.iter().map(PathRay::direction);
            surfaces.make(tracer, directions.zip(hits), through);
            if let Some(lights) = shader.rows() {
                glances.find(tracer, surfaces, lights);
            }
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
        memo: &mut Memo,
    ) -> (Sum, Option<Point>) {
        let at = at % BUNDLE;
        let (surfaces, lane) = (self.surfaces.get(at / LANES), at % LANES);
        let made = Made { surfaces, lane };
        if let (Some(lights), Some(glances)) = (shader.rows(), self.glances.get(at / LANES))
            && surfaces.is_some_and(|surfaces| surfaces.is_made(lane))
        {
            memo.glance(packed.key(), glances, lane, lights);
        }
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
