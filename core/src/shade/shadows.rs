use super::path::share;
use super::{Bundle, Point, Settings, Shader};
use crate::geometry::Ray;
use crate::light::Sample;
use crate::random::{Purpose, Sequence};
use crate::real::{LANES, Mask, Part, Real, Rows, Vector};
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

impl ShadowRay {
    const NONE: Self = {
        let ray = Ray { origin: Vec3::ZERO, direction: Vec3::ZERO, t_min: 0.0, t_max: 0.0 };
        Self { ray, light: Vec3::ZERO }
    };
}

/// Shadow rays made together, one after the other.
#[derive(Debug, Clone, Copy)]
pub struct ShadowRays {
    rays: [ShadowRay; TOGETHER],
    len: u32,
    /// Those whose light counts, a bit each.
    lit: u32,
}

impl ShadowRays {
    /// None yet.
    pub const NONE: Self = Self { rays: [ShadowRay::NONE; TOGETHER], len: 0, lit: 0 };

    /// How many, with those whose light does not count.
    #[must_use]
    pub const fn len(&self) -> u32 {
        self.len
    }

    /// Whether there is none.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Forgets them.
    pub const fn clear(&mut self) {
        self.begin(0);
    }

    /// Those whose light counts.
    pub fn lit(&self) -> impl Iterator<Item = &ShadowRay> {
        self.places().map(|(_, ray)| ray)
    }

    /// Those whose light counts, and their places.
    pub fn places(&self) -> impl Iterator<Item = (u32, &ShadowRay)> {
        let mut at = 0;
        core::iter::from_fn(move || {
            let next = self.next(at)?;
            at = next.0.wrapping_add(1);
            Some(next)
        })
    }

    /// How many of them have a light that does not count.
    #[must_use]
    pub const fn dark(&self) -> u32 {
        self.len.saturating_sub(self.lit.count_ones())
    }

    /// The first from `at` on whose light counts, and its place.
    #[inline(always)]
    #[must_use]
    pub fn next(&self, at: u32) -> Option<(u32, &ShadowRay)> {
        let left = self.lit.unbounded_shr(at);
        let place = (left != 0).then(|| at.wrapping_add(left.trailing_zeros()))?;
        Some((place, self.rays.get(place as usize)?))
    }

    /// Makes room for so many, of which none counts yet.
    #[inline(always)]
    pub(super) const fn begin(&mut self, len: u32) {
        (self.len, self.lit) = (len, 0);
    }

    #[inline(always)]
    pub(super) fn put(&mut self, at: usize, ray: Option<ShadowRay>) {
        if let (Some(place), Some(ray)) = (self.rays.get_mut(at), ray) {
            *place = ray;
            self.lit |= 1 << at;
        }
    }
}

/// As many as lanes do at once; a board, which has one, makes them one by one.
const TOGETHER: usize = if cfg!(feature = "bundles") { LANES } else { 1 };

/// Below so many rays of a bundle lanes would be empty that cost what full ones do.
pub(super) const FEW: u32 = 4;

impl Shader<'_> {
    /// Makes shadow rays of a bundle from `j` on, as many as there are and have room. They are made one after the other, from 0 up.
    pub fn shadow_rays<T: Tracer>(
        &self,
        tracer: T,
        point: &Point,
        bundle: &mut Bundle,
        j: u32,
        rays: &mut ShadowRays,
    ) {
        let len = bundle.len.saturating_sub(j).min(TOGETHER as u32);
        let samples = bundle.samples.saturating_sub(j).min(len);
        let mut made = 0;
        rays.begin(len);
        if cfg!(feature = "bundles") && samples >= FEW {
            tracer.compute(Together { shader: *self, point, bundle, j, rays, samples });
            made = samples;
        }
        for at in made..len {
            rays.put(at as usize, self.shadow_ray(point, bundle, j.wrapping_add(at)));
        }
    }

    /// Shadow ray `j` of a bundle; `None` if its light would not count. They are made one after the other, from 0 up.
    #[must_use]
    #[cfg_attr(feature = "bundles", inline(always))]
    pub fn shadow_ray(&self, point: &Point, bundle: &mut Bundle, j: u32) -> Option<ShadowRay> {
        let (sequence, index) = bundle.place(point, j);
        let made = self.made(point, bundle, sequence.points(index));
        let light = bundle.take(j, made.is_lit, made.light.into())?;
        let (origin, direction) = (made.origin.into(), made.direction.into());
        Some(ShadowRay { ray: Ray { origin, direction, t_min: 0.0, t_max: made.t_max }, light })
    }

    /// The shadow rays to these places, and their light as samples.
    #[inline(always)]
    fn made<R: Real>(&self, point: &Point, bundle: &Bundle, place: [R; 2]) -> Made<R> {
        let surface = &point.surface;
        let sample = bundle.aim.sample(place);
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
    /// The sequence of its ray `j`, and the index there.
    #[inline(always)]
    pub(super) fn place(&self, point: &Point, j: u32) -> (Sequence, u32) {
        let key = point.path.key;
        if self.is_rest(j) {
            return (Sequence::new(key, Purpose::Rest(self.light)), key.sample);
        }
        (self.sequence, key.sample.wrapping_mul(self.samples).wrapping_add(j))
    }

    /// Whether its ray `j` takes the rest of a known light.
    pub(super) const fn is_rest(&self, j: u32) -> bool {
        j >= self.samples
    }

    /// The light of its ray `j`, of which a sample brings `light`, if it counts.
    #[inline(always)]
    fn take(&mut self, j: u32, is_lit: bool, light: Vec3) -> Option<Vec3> {
        if !is_lit {
            return None;
        }
        self.deal.part(light, self.is_rest(j))
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

/// The samples of [`Shader::shadow_rays`], with all lanes.
struct Together<'a, 's> {
    shader: Shader<'s>,
    point: &'a Point,
    bundle: &'a mut Bundle,
    j: u32,
    rays: &'a mut ShadowRays,
    samples: u32,
}

impl Kernel for Together<'_, '_> {
    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) {
        let Self { shader, point, bundle, mut j, rays, samples } = self;
        let len = samples as usize;
        for first in (0..len).step_by(L::Real::COUNT) {
            let (sequence, index) = bundle.place(point, j);
            let place = sequence.points(lanes.count_from(index));
            let made = shader.made::<L::Real>(point, bundle, place);
            let is_lit = made.is_lit.lanes();
            let [mut origins, mut directions, mut lights] = [Rows::NONE; 3];
            origins.put(0, made.origin);
            directions.put(0, made.direction);
            lights.put(0, made.light);
            for lane in 0..L::Real::COUNT.min(len - first) {
                let light = bundle.take(j, is_lit >> lane & 1 != 0, lights.at(lane));
                j = j.wrapping_add(1);
                let ray = light.map(|light| {
                    let (origin, direction) = (origins.at(lane), directions.at(lane));
                    let ray = Ray { origin, direction, t_min: 0.0, t_max: made.t_max };
                    ShadowRay { ray, light }
                });
                rays.put(first + lane, ray);
            }
        }
    }
}
