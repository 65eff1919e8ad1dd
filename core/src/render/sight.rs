use super::clear::is_clear;
use super::clearing::Clearings;
#[cfg(feature = "bundles")]
use super::neighbours::Neighbours;
use super::trust::Trust;
use crate::block::BlockSource;
use crate::geometry::Hit;
use crate::material::OpticalDepth;
use crate::scene::{Light, Material};
use crate::shade::{Bundle, PathRay, Point, Shader, Shadow, Sum};
use crate::trace::{Cursor, TraceError, Tracer};

/// What rays see: a tracer, the blocks, and the state of a traversal.
#[derive(Debug)]
pub struct Sight<T, S> {
    tracer: T,
    source: S,
    cursor: Cursor,
    #[cfg(feature = "bundles")]
    neighbours: Neighbours,
    trust: Trust,
    clearings: Clearings<CLEARINGS>,
}

/// Clearings that are known, at most.
const CLEARINGS: usize = if cfg!(feature = "clips") { 16 } else { 0 };

impl<T: Tracer, S: BlockSource> Sight<T, S> {
    /// Rays traced by `tracer` through the blocks of `source`.
    #[must_use]
    pub const fn new(tracer: T, source: S) -> Self {
        Self {
            tracer,
            source,
            cursor: Cursor::new(),
            #[cfg(feature = "bundles")]
            neighbours: Neighbours::new(),
            trust: Trust::new(),
            clearings: Clearings::new(),
        }
    }

    /// The blocks.
    #[must_use]
    pub const fn source(&self) -> &S {
        &self.source
    }

    /// What they are traced with.
    pub(super) const fn tracer(&self) -> T {
        self.tracer
    }

    /// How many shadow rays to look at together next, at most.
    pub(super) const fn most(&self) -> usize {
        self.trust.most()
    }

    /// How many rays, from the first, nothing can be in the way of, as far as a short search can tell. All go to one light.
    pub(super) fn clear_of(&mut self, rays: &[Shadow], light: &Light) -> usize {
        let Self { trust, source, .. } = self;
        trust.clear_of(rays.len(), |len| is_clear(rays.iter().take(len), light, source))
    }

    /// What the light of a bundle brings, if it is known, and all of the light is known to be seen.
    pub(super) fn whole(
        &mut self,
        shader: &Shader<'_>,
        point: &Point,
        bundle: &Bundle,
    ) -> Option<Sum> {
        let Self { clearings, source, .. } = self;
        clearings.whole(shader, point, bundle, source, &mut 0)
    }

    /// The closest hit of `rays[at]`, if `at` goes from 0 up by one.
    pub(super) fn closest(
        &mut self,
        rays: &[PathRay],
        at: usize,
    ) -> Result<Option<Hit>, TraceError<S::Error>> {
        #[cfg(feature = "bundles")]
        if self.source.holds_all() {
            return self.neighbours.closest(self.tracer, &mut self.source, rays, at);
        }
        let Some(ray) = rays.get(at) else { return Ok(None) };
        self.tracer.closest(&mut self.cursor, &mut self.source, &ray.ray())
    }

    /// What is left of the light along the shadow ray `rays[at]`, if `at` goes from 0 up by one. Without `materials` all that it meets stops it.
    pub(super) fn depth(
        &mut self,
        rays: &[Shadow],
        at: usize,
        materials: Option<&[Material]>,
    ) -> Result<OpticalDepth, TraceError<S::Error>> {
        #[cfg(feature = "bundles")]
        if self.source.holds_all() {
            return self.neighbours.lost(self.tracer, &mut self.source, rays, at, materials);
        }
        let Some(ray) = rays.get(at).map(Shadow::ray) else { return Ok(OpticalDepth::OPAQUE) };
        let Self { tracer, source, cursor, .. } = self;
        let mut depth = OpticalDepth::CLEAR;
        match materials {
            Some(materials) => {
                let cross = |hit: &Hit| depth.cross(materials, &ray, hit);
                tracer.every(cursor, source, &ray, cross)?;
            }
            None if tracer.any(cursor, source, &ray)? => depth = OpticalDepth::OPAQUE,
            None => {}
        }
        Ok(depth)
    }
}
