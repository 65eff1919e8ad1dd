use super::clear::is_clear;
use super::packed::Shadow;
use crate::block::BlockSource;
use crate::geometry::{Hit, Ray};
use crate::material::{OpticalDepth, crossing};
use crate::scene::{Light, Material};
use crate::trace::{Cursor, TraceError, Tracer};

/// What rays see: a tracer, the blocks, and the state of a traversal.
#[derive(Debug)]
pub struct Sight<T, S> {
    tracer: T,
    source: S,
    cursor: Cursor,
    /// How many bundles in a row may be found hidden before most are traced unasked.
    trust: u8,
    asked: u8,
}

const TRUST_MAX: u8 = 8;

impl<T: Tracer, S: BlockSource> Sight<T, S> {
    /// Rays traced by `tracer` through the blocks of `source`.
    #[must_use]
    pub const fn new(tracer: T, source: S) -> Self {
        Self { tracer, source, cursor: Cursor::new(), trust: TRUST_MAX, asked: 0 }
    }

    /// The blocks.
    #[must_use]
    pub const fn source(&self) -> &S {
        &self.source
    }

    /// Whether nothing can be in the way of a bundle of shadow rays to a light.
    pub(super) fn is_clear(&mut self, rays: &[Shadow], light: &Light) -> bool {
        // A search that leads nowhere costs; where many did, only some bundles are asked. It decides about time only.
        self.asked = self.asked.wrapping_add(1);
        if self.trust == 0 && !self.asked.is_multiple_of(16) {
            return false;
        }
        let clear = is_clear(rays, light, &mut self.source);
        self.trust = if clear { TRUST_MAX } else { self.trust.saturating_sub(1) };
        clear
    }

    /// The closest hit of a ray.
    pub(super) fn closest(&mut self, ray: &Ray) -> Result<Option<Hit>, TraceError<S::Error>> {
        self.tracer.closest(&mut self.cursor, &mut self.source, ray)
    }

    /// What is left of the light along a shadow ray. Without `materials` all that it meets stops it.
    pub(super) fn depth(
        &mut self,
        ray: &Ray,
        materials: Option<&[Material]>,
    ) -> Result<OpticalDepth, TraceError<S::Error>> {
        let Some(materials) = materials else {
            let hidden = self.tracer.any(&mut self.cursor, &mut self.source, ray)?;
            return Ok(if hidden { OpticalDepth::OPAQUE } else { OpticalDepth::CLEAR });
        };
        let mut depth = OpticalDepth::CLEAR;
        self.tracer.every(&mut self.cursor, &mut self.source, ray, |hit| {
            let here = match materials.get(usize::from(hit.material)) {
                Some(material) => crossing(material, ray, hit),
                None => OpticalDepth::OPAQUE,
            };
            depth = depth.and(here);
            depth.is_opaque()
        })?;
        Ok(depth)
    }
}
