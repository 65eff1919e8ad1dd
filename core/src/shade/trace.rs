use super::{Bundle, Counts, Memo, Path, Point, Shader, Sum};
use crate::geometry::{Hit, Ray};
use crate::material::OpticalDepth;
use crate::trace::Scalar;

/// What shading asks of the geometry.
pub trait Visibility {
    /// Why it may not answer.
    type Error;

    /// The closest hit of a ray.
    ///
    /// # Errors
    /// The tracer's own.
    fn closest(&mut self, ray: &Ray) -> Result<Option<Hit>, Self::Error>;

    /// What is left of the light along each shadow ray, into the place of the same index; the slices are as long as each other, and have at most
    /// [`BATCH`] places. What weakens light and what stops it says [`crossing`](crate::material::crossing).
    ///
    /// # Errors
    /// The tracer's own.
    fn depths(&mut self, rays: &[Ray], depths: &mut [OpticalDepth]) -> Result<(), Self::Error>;
}

/// Shadow rays that are asked for at once.
pub const BATCH: usize = 16;

/// Most rays of a path that wait: only its first two points send two children, of which one goes on at once.
#[cfg(feature = "specular")]
const WAITING_MAX: usize = 2;

impl Shader<'_> {
    /// The light of one camera path: the reference for all ways of dividing this work.
    ///
    /// # Errors
    /// Those of `visibility`.
    pub fn trace<V: Visibility>(
        &self,
        visibility: &mut V,
        ray: &Ray,
        path: Path,
        counts: &mut Counts,
    ) -> Result<Sum, V::Error> {
        let mut sum = Sum::ZERO;
        counts.primary += 1;
        let mut now = Some((*ray, path));
        #[cfg(feature = "specular")]
        let mut waiting = [None; WAITING_MAX];
        while let Some((ray, path)) = now.take() {
            let hit = visibility.closest(&ray)?;
            let (light, point) = self.arrive(&path, &ray, hit.as_ref());
            sum.add(light);
            if let Some(point) = point {
                sum.add(self.lit(visibility, &point, counts)?);
                #[cfg(feature = "specular")]
                for child in self.children(&point, counts).into_iter().flatten() {
                    counts.specular += 1;
                    let next = Some((child.ray, child.path));
                    if now.is_none() {
                        now = next;
                    } else if let Some(free) = waiting.iter_mut().find(|slot| slot.is_none()) {
                        *free = next;
                    }
                }
            }
            #[cfg(feature = "specular")]
            if now.is_none() {
                now = waiting.iter_mut().rev().find_map(Option::take);
            }
        }
        Ok(sum)
    }

    /// The direct light of a point, by all its bundles.
    ///
    /// # Errors
    /// Those of `visibility`.
    pub fn lit<V: Visibility>(
        &self,
        visibility: &mut V,
        point: &Point,
        counts: &mut Counts,
    ) -> Result<Sum, V::Error> {
        let mut sum = Sum::ZERO;
        let mut memo = Memo::new();
        let mut direct = self.direct(Scalar, point, &mut memo);
        while let Some(mut bundle) = self.next_bundle(Scalar, point, &mut direct, &memo, counts) {
            sum.add(self.lit_by(visibility, point, &mut bundle, counts)?);
        }
        Ok(sum)
    }

    fn lit_by<V: Visibility>(
        &self,
        visibility: &mut V,
        point: &Point,
        bundle: &mut Bundle,
        counts: &mut Counts,
    ) -> Result<Sum, V::Error> {
        let none =
            Ray { origin: glam::Vec3::ZERO, direction: glam::Vec3::ZERO, t_min: 0.0, t_max: 0.0 };
        let mut sum = Sum::ZERO;
        let mut next = 0;
        while next < bundle.len {
            let mut rays = [none; BATCH];
            let mut light = [glam::Vec3::ZERO; BATCH];
            let mut len = 0;
            for (ray, light) in rays.iter_mut().zip(&mut light) {
                // Dark samples take no place: the batch stays full.
                let shadow = loop {
                    if next >= bundle.len {
                        break None;
                    }
                    let shadow = self.shadow_ray(point, bundle, next);
                    next += 1;
                    if shadow.is_some() {
                        break shadow;
                    }
                    counts.shadow_dark += 1;
                };
                let Some(shadow) = shadow else { break };
                (*ray, *light) = (shadow.ray, shadow.light);
                len += 1;
            }
            let mut depths = [OpticalDepth::CLEAR; BATCH];
            if let (Some(rays), Some(depths)) = (rays.get(..len), depths.get_mut(..len)) {
                if len > 0 {
                    counts.shadow += len as u64;
                    visibility.depths(rays, depths)?;
                }
                for (depth, light) in depths.iter().zip(light) {
                    if !depth.is_opaque() {
                        sum.add(self.unit().quantise(light * depth.transmittance()));
                    }
                }
            }
        }
        Ok(sum)
    }
}
