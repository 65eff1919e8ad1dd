#[cfg(not(feature = "bundles"))]
use super::alone::Alone as Rays;
use super::clear::is_clear;
use super::clearing::Clearings;
#[cfg(feature = "bundles")]
use super::together::Together as Rays;
use super::trust::Trust;
use crate::block::BlockSource;
use crate::material::OpticalDepth;
use crate::scene::{Light, Material};
use crate::shade::{Bundle, Memo, PathRay, Point, Shader, Shadow, Sum};
use crate::trace::{TraceError, Tracer};

/// What rays see: a tracer, the blocks, and the state of a traversal.
#[derive(Debug)]
pub struct Sight<T, S> {
    tracer: T,
    source: S,
    rays: Rays,
    trust: Trust,
    clearings: Clearings<CLEARINGS>,
}

/// Clearings that are known, at most.
const CLEARINGS: usize = if cfg!(feature = "clips") { 16 } else { 0 };

impl<T: Tracer, S: BlockSource> Sight<T, S> {
    /// Rays traced by `tracer` through the blocks of `source`.
    #[must_use]
    pub const fn new(tracer: T, source: S) -> Self {
        Self { tracer, source, rays: Rays::new(), trust: Trust::new(), clearings: Clearings::new() }
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

    /// Whether a block that is asked for may have to come, and push out another.
    pub(super) fn fetches(&self) -> bool {
        !self.source.holds_all()
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

    /// Finds what `rays[at]` hits, if `at` goes from 0 up by one.
    pub(super) fn closest(
        &mut self,
        rays: &[PathRay],
        at: usize,
        shader: &Shader<'_>,
    ) -> Result<(), TraceError<S::Error>> {
        self.rays.closest(self.tracer, &mut self.source, rays, at, shader)
    }

    /// What the ray `rays[at]`, whose hit was found, brings: see [`Shader::arrive`].
    #[cfg_attr(feature = "bundles", inline(always))]
    pub(super) fn arrive(
        &self,
        shader: &Shader<'_>,
        ray: &PathRay,
        at: usize,
        memo: &mut Memo,
    ) -> (Sum, Option<Point>) {
        self.rays.arrive(shader, ray, at, memo)
    }

    /// What is left of the light along the shadow ray `rays[at]`, if `at` goes from 0 up by one. Without `materials` all that it meets stops it.
    pub(super) fn depth(
        &mut self,
        rays: &[Shadow],
        at: usize,
        materials: Option<&[Material]>,
    ) -> Result<OpticalDepth, TraceError<S::Error>> {
        self.rays.lost(self.tracer, &mut self.source, rays, at, materials)
    }
}
