use super::clear::is_clear;
#[cfg(feature = "bundles")]
use super::neighbours::Neighbours;
use crate::block::BlockSource;
use crate::geometry::Hit;
use crate::material::{OpticalDepth, crossing};
use crate::scene::{Light, Material};
use crate::shade::{PathRay, Shadow};
use crate::trace::{Cursor, TraceError, Tracer};

/// What rays see: a tracer, the blocks, and the state of a traversal.
#[derive(Debug)]
pub struct Sight<T, S> {
    tracer: T,
    source: S,
    cursor: Cursor,
    #[cfg(feature = "bundles")]
    neighbours: Neighbours,
    /// How many bundles in a row may be found hidden before most are traced unasked.
    trust: u8,
    asked: u8,
}

const TRUST_MAX: u8 = 8;

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
            trust: TRUST_MAX,
            asked: 0,
        }
    }

    /// The blocks.
    #[must_use]
    pub const fn source(&self) -> &S {
        &self.source
    }

    /// Whether nothing can be in the way of a bundle of shadow rays to a light.
    pub(super) fn is_clear(&mut self, rays: &[Shadow], light: &Light) -> bool {
        if !cfg!(feature = "clips") {
            return false;
        }
        // A search that leads nowhere costs; where many did, only some bundles are asked. It decides about time only.
        self.asked = self.asked.wrapping_add(1);
        if self.trust == 0 && !self.asked.is_multiple_of(16) {
            return false;
        }
        let clear = is_clear(rays.iter(), light, &mut self.source);
        self.trust = if clear { TRUST_MAX } else { self.trust.saturating_sub(1) };
        clear
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
        let Some(ray) = rays.get(at).map(Shadow::ray) else { return Ok(OpticalDepth::OPAQUE) };
        let Some(materials) = materials else {
            let hidden = self.hidden(rays, at)?;
            return Ok(if hidden { OpticalDepth::OPAQUE } else { OpticalDepth::CLEAR });
        };
        let mut depth = OpticalDepth::CLEAR;
        self.tracer.every(&mut self.cursor, &mut self.source, &ray, |hit| {
            let here = match materials.get(usize::from(hit.material)) {
                Some(material) => crossing(material, &ray, hit),
                None => OpticalDepth::OPAQUE,
            };
            depth = depth.and(here);
            depth.is_opaque()
        })?;
        Ok(depth)
    }

    /// Whether anything is in the way of `rays[at]`.
    fn hidden(&mut self, rays: &[Shadow], at: usize) -> Result<bool, TraceError<S::Error>> {
        #[cfg(feature = "bundles")]
        if self.source.holds_all() {
            return self.neighbours.hidden(self.tracer, &mut self.source, rays, at);
        }
        let Some(ray) = rays.get(at) else { return Ok(true) };
        self.tracer.any(&mut self.cursor, &mut self.source, &ray.ray())
    }
}
