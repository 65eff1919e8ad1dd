use crate::block::BlockSource;
use crate::geometry::{Hit, Ray};
use crate::material::{OpticalDepth, crossing};
use crate::scene::Material;
use crate::trace::{Cursor, TraceError, Tracer};

/// What rays see: a tracer, the blocks, and the state of a traversal.
#[derive(Debug)]
pub struct Sight<T, S> {
    tracer: T,
    source: S,
    cursor: Cursor,
}

impl<T: Tracer, S: BlockSource> Sight<T, S> {
    /// Rays traced by `tracer` through the blocks of `source`.
    #[must_use]
    pub const fn new(tracer: T, source: S) -> Self {
        Self { tracer, source, cursor: Cursor::new() }
    }

    /// The blocks.
    #[must_use]
    pub const fn source(&self) -> &S {
        &self.source
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
