use super::path::share;
use super::{Bundle, Point, Settings, Shader};
use crate::geometry::Ray;
use crate::light::Sample;
use crate::real::{LANES, Mask, Part, Real, Vector};
use crate::trace::{Kernel, Lanes, Tracer};
use glam::Vec3;

/// A shadow ray, and the light that it brings to the pixel if nothing is in its way.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ShadowRay {
    /// From the point to just before the light.
    pub ray: Ray,
    /// Times the transmittance of what it crosses.
    pub light: Vec3,
}

/// Shadow rays made together: a place is empty where the light of a ray would not count.
pub type ShadowRays = [Option<ShadowRay>; TOGETHER];

/// As many as lanes do at once; a board, which has one, makes them one by one.
const TOGETHER: usize = if cfg!(feature = "bundles") { LANES } else { 1 };

/// Below so many rays of a bundle lanes would be empty that cost what full ones do.
const FEW: u32 = 3;

impl Shader<'_> {
    /// Shadow rays of a bundle from `j` on into the places, as many as there are of both: how many. They are made one after the other, from 0 up.
    pub fn shadow_rays<T: Tracer>(
        &self,
        tracer: T,
        point: &Point,
        bundle: &mut Bundle,
        j: u32,
        rays: &mut [Option<ShadowRay>],
    ) -> u32 {
        let count = bundle.len.saturating_sub(j).min(rays.len().min(TOGETHER) as u32);
        let rays = rays.get_mut(..count as usize).unwrap_or_default();
        if cfg!(feature = "bundles") && count >= FEW {
            tracer.compute(Together { shader: *self, point, bundle, j, rays });
        } else {
            for (i, ray) in (j..).zip(rays) {
                *ray = self.shadow_ray(point, bundle, i);
            }
        }
        count
    }

    /// Shadow ray `j` of a bundle; `None` if its light would not count. They are made one after the other, from 0 up.
    #[must_use]
    #[cfg_attr(feature = "bundles", inline(always))]
    pub fn shadow_ray(&self, point: &Point, bundle: &mut Bundle, j: u32) -> Option<ShadowRay> {
        let made = self.made(point, bundle, bundle.index(point, j));
        let light = bundle.take(j, made.is_lit, made.light.into())?;
        let (origin, direction) = (made.origin.into(), made.direction.into());
        Some(ShadowRay { ray: Ray { origin, direction, t_min: 0.0, t_max: made.t_max }, light })
    }

    /// The shadow rays of these indices, and their light as samples.
    #[inline(always)]
    fn made<R: Real>(&self, point: &Point, bundle: &Bundle, index: R::Bits) -> Made<R> {
        let surface = &point.surface;
        let sample = bundle.aim.sample(bundle.sequence.points(index));
        let light = self.sampled(point, bundle, &sample);
        let side = sample.direction.on(surface.normal);
        let like = |v: Vec3| Vector::same(side, v);
        let is_below = side.same(0.0).above(side);
        let origin = Vector::select(is_below, like(surface.below), like(surface.above));
        let (direction, t_max) = match sample.end {
            Some(end) => (end - origin, 1.0),
            None => (sample.direction, f32::INFINITY),
        };
        Made { origin, direction, t_max, light, is_lit: sample.is_lit }
    }

    /// The light that samples bring to the pixel if nothing is in their way.
    #[inline(always)]
    fn sampled<R: Real>(&self, point: &Point, bundle: &Bundle, sample: &Sample<R>) -> Vector<R> {
        let Point { surface, path, .. } = point;
        let response = point.bsdf.evaluate(surface, sample.direction);
        let mut answer = response.diffuse;
        if let Some((gloss, density)) = response.gloss {
            answer = answer
                + if bundle.seen {
                    let above = sample.direction.on(surface.normal).is_positive();
                    let ray = point.ray_density(above, density);
                    gloss * self.share(ray, sample.density).complement()
                } else {
                    gloss
                };
        }
        let power = Vector::along(bundle.aim.radiance(), sample.inverse);
        let passed = self.absorbed(path.medium, sample.distance);
        passed * path.throughput * answer * (power * sample.inverse.same(bundle.scale))
    }

    /// The [share] of a ray of this density in light that is also sampled with some density.
    #[inline(always)]
    pub(super) fn share<R: Real>(&self, ray: R, sampled: R) -> R {
        R::apart(Share { settings: &self.settings, ray, sampled })
    }
}

/// See [`Shader::share`].
struct Share<'a, R> {
    settings: &'a Settings,
    ray: R,
    sampled: R,
}

impl<R: Real> Part for Share<'_, R> {
    type Result = R;

    #[inline(always)]
    fn run(self) -> R {
        let Self { settings, ray, sampled } = self;
        // Light sampling takes several samples where a ray is one.
        let is_finite = sampled.is_positive() & sampled.same(f32::INFINITY).above(sampled);
        let count = settings.shadow_count(sampled.same(1.0) / sampled);
        share(ray, R::select(is_finite, count * sampled, sampled))
    }
}

impl Bundle {
    /// The index in the sequence of its ray `j`.
    fn index(&self, point: &Point, j: u32) -> u32 {
        point.path.key.sample.wrapping_mul(self.len).wrapping_add(j)
    }

    /// The light of its ray `j`, of which a sample brings `light`, if it counts.
    #[inline(always)]
    fn take(&mut self, j: u32, is_lit: bool, light: Vec3) -> Option<Vec3> {
        if !is_lit {
            return None;
        }
        // The last of those that share a known light takes what is left of it. Of a lamp whose light is known, no sample is lost.
        let last = self.deal.is_known() && j.wrapping_add(1) == self.len;
        let light = if last { self.deal.rest() } else { self.deal.take(light) };
        (light.max_element() > 0.0).then_some(light)
    }
}

/// Shadow rays in lanes.
struct Made<R: Real> {
    origin: Vector<R>,
    direction: Vector<R>,
    t_max: f32,
    light: Vector<R>,
    is_lit: R::Mask,
}

/// [`Shader::shadow_rays`] with all lanes.
struct Together<'a, 's> {
    shader: Shader<'s>,
    point: &'a Point,
    bundle: &'a mut Bundle,
    j: u32,
    rays: &'a mut [Option<ShadowRay>],
}

impl Kernel for Together<'_, '_> {
    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) {
        let Self { shader, point, bundle, mut j, mut rays } = self;
        while !rays.is_empty() {
            let made =
                shader.made::<L::Real>(point, bundle, lanes.count_from(bundle.index(point, j)));
            let is_lit = made.is_lit.lanes();
            let (origin, direction) = (Put::down(made.origin), Put::down(made.direction));
            let light = Put::down(made.light);
            let (now, later) = rays.split_at_mut(L::Real::COUNT.min(rays.len()));
            for (lane, ray) in now.iter_mut().enumerate() {
                let light = bundle.take(j, is_lit >> lane & 1 != 0, light.at(lane));
                j = j.wrapping_add(1);
                *ray = light.map(|light| {
                    let (origin, direction) = (origin.at(lane), direction.at(lane));
                    ShadowRay {
                        ray: Ray { origin, direction, t_min: 0.0, t_max: made.t_max },
                        light,
                    }
                });
            }
            rays = later;
        }
    }
}

/// Vectors, put down lane by lane.
struct Put([[f32; LANES]; 3]);

impl Put {
    #[inline(always)]
    fn down<R: Real>(v: Vector<R>) -> Self {
        let mut to = [[0.0; LANES]; 3];
        let [x, y, z] = &mut to;
        v.x.store(x);
        v.y.store(y);
        v.z.store(z);
        Self(to)
    }

    #[inline(always)]
    fn at(&self, lane: usize) -> Vec3 {
        Vec3::from(self.0.map(|axis| axis.get(lane % LANES).copied().unwrap_or(0.0)))
    }
}
