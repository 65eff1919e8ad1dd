use crate::block::BlockSource;
use crate::geometry::Hit;
use crate::material::OpticalDepth;
use crate::scene::Material;
use crate::shade::{PathRay, Shadow};
use crate::trace::{Cursor, TraceError, Tracer};

/// Rays that are traced one by one, as `Neighbours` traces them together.
#[derive(Debug)]
pub(super) struct Alone {
    cursor: Cursor,
}

impl Alone {
    /// No ray is under way.
    pub(super) const fn new() -> Self {
        Self { cursor: Cursor::new() }
    }

    /// The closest hit of `rays[at]`.
    pub(super) fn closest<T: Tracer, S: BlockSource>(
        &mut self,
        tracer: T,
        source: &mut S,
        rays: &[PathRay],
        at: usize,
    ) -> Result<Option<Hit>, TraceError<S::Error>> {
        let Some(ray) = rays.get(at) else { return Ok(None) };
        tracer.closest(&mut self.cursor, source, &ray.ray())
    }

    /// What `rays[at]` has lost on its way. Without `materials` all that it meets stops it.
    pub(super) fn lost<T: Tracer, S: BlockSource>(
        &mut self,
        tracer: T,
        source: &mut S,
        rays: &[Shadow],
        at: usize,
        materials: Option<&[Material]>,
    ) -> Result<OpticalDepth, TraceError<S::Error>> {
        let Some(ray) = rays.get(at).map(Shadow::ray) else { return Ok(OpticalDepth::OPAQUE) };
        let mut depth = OpticalDepth::CLEAR;
        match materials {
            Some(materials) => {
                let cross = |hit: &Hit| depth.cross(materials, &ray, hit);
                tracer.every(&mut self.cursor, source, &ray, cross)?;
            }
            None if tracer.any(&mut self.cursor, source, &ray)? => depth = OpticalDepth::OPAQUE,
            None => {}
        }
        Ok(depth)
    }
}
