use crate::block::BlockSource;
use crate::geometry::Hit;
use crate::material::OpticalDepth;
use crate::scene::Material;
use crate::shade::{Memo, PathRay, Point, Shader, Shadow, Sum};
use crate::trace::{Cursor, TraceError, Tracer};

/// Rays that are traced one by one, as `Neighbours` traces them together.
#[derive(Debug)]
pub(super) struct Alone {
    cursor: Cursor,
    hit: Option<Hit>,
}

impl Alone {
    /// No ray is under way.
    pub(super) const fn new() -> Self {
        Self { cursor: Cursor::new(), hit: None }
    }

    /// Finds what `rays[at]` hits.
    pub(super) fn closest<T: Tracer, S: BlockSource>(
        &mut self,
        tracer: T,
        source: &mut S,
        rays: &[PathRay],
        at: usize,
        _: &Shader<'_>,
    ) -> Result<(), TraceError<S::Error>> {
        let Some(ray) = rays.get(at) else { return Ok(()) };
        self.hit = tracer.closest(&mut self.cursor, source, &ray.ray())?;
        Ok(())
    }

    /// What the ray whose hit was found brings: see [`Shader::arrive`].
    pub(super) fn arrive(
        &self,
        shader: &Shader<'_>,
        packed: &PathRay,
        _: usize,
        _: &mut Memo,
    ) -> (Sum, Option<Point>) {
        shader.arrive(&packed.path(), &packed.ray(), self.hit.as_ref())
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
