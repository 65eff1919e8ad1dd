use super::distant::Cap;
use super::flat::Flat;
#[cfg(feature = "bundles")]
use super::lamp::Lamp;
#[cfg(feature = "bundles")]
use super::plane::Glance;
use super::plane::{Plane, center};
use super::sphere::Ball;
use crate::geometry::rounding::UNIT_ROUNDOFF;
use crate::material::Surface;
use crate::real::{Real, Vector};
use crate::scene::{Light, LightKind};
use crate::trace::Tracer;
use glam::Vec3;

/// A light as one point sees it. [`prepare`](Self::prepare) it before taking samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Aim {
    shape: Shape,
    from: Vec3,
    radiance: Vec3,
    cone: Vec3,
    cone_cos: f32,
    focus: f32,
    /// What the light would bring to a white surface without shadows, roughly: the greatest
    /// component of radiance times solid angle times cosine. Above zero.
    pub estimate: f32,
    /// Its solid angle, roughly; 0 for points.
    pub solid_angle: f32,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Shape {
    Flat(Flat),
    Ball(Ball),
    Point(Vec3),
    Cap(Cap),
}

/// Why a light cannot light a point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Dark {
    /// It is wholly behind the surface, or the surface takes no light from its side.
    Below,
    /// It shines to the other side, or in another direction.
    FacesAway,
    /// It is farther away than its reach.
    OutOfReach,
    /// It has no power or no size.
    Void,
}

/// Directions in which a light was looked for, one in each lane.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample<R: Real = f32> {
    /// Unit direction to the light.
    pub direction: Vector<R>,
    /// Where a shadow ray ends, just before the light; `None` if it has no end.
    pub end: Option<Vector<R>>,
    /// The distance to the light, infinite if it is infinitely far.
    pub distance: R,
    /// One over the density, which times the [radiance](Aim::radiance) is, of a point light, the irradiance at normal incidence. \[sr\]
    pub inverse: R,
    /// What [`Aim::density`] says of this direction.
    pub density: R,
    /// Whether there is something to see in it.
    pub is_lit: R::Mask,
}

/// Distance by which a shadow ray ends before the light, in parts of all lengths concerned: the clearance that
/// [`SurfacePoint::spawn_to`](crate::geometry::SurfacePoint::spawn_to) derives, 160 u, and the rounding of the point itself.
const CLEARANCE: f32 = 176.0 * UNIT_ROUNDOFF;

/// Where a shadow ray ends, just before the light.
#[inline(always)]
pub(super) fn before<R: Real>(
    from: Vector<R>,
    direction: Vector<R>,
    distance: R,
    normal: Vector<R>,
    size: R,
) -> Vector<R> {
    let off = (distance + size) * CLEARANCE;
    direction * distance + from + normal * off
}

/// How many times its share of a light that is [known](Aim::projected) a sample brings at most.
pub const MOST: f32 = 8.0;

/// Whether a surface takes light from something within this radius of a centre at this height above it and this distance.
#[inline(always)]
pub(super) fn takes<R: Real>(answers: [bool; 2], height: R, radius: R, distance: R) -> R::Mask {
    let slack = radius + (distance + radius) * (4.0 * UNIT_ROUNDOFF);
    let (any, [front, back]) = (height.always(), answers);
    let front = if front { height.above(-slack) } else { !any };
    let back = if back { slack.above(height) } else { !any };
    front | back
}

impl Aim {
    /// A light, seen from a surface that answers light from its front and from behind, or
    /// not (see [`crate::material::Bsdf::answers`]).
    ///
    /// # Errors
    /// Why it cannot light it.
    #[cfg_attr(feature = "bundles", inline(always))]
    pub fn new(light: &Light, surface: &Surface, answers: [bool; 2]) -> Result<Self, Dark> {
        let from = surface.position;
        let radiance = Vec3::from(light.radiance);
        let brightest = radiance.max_element();
        let kind = LightKind::from_u32(light.kind).ok_or(Dark::Void)?;
        if brightest.is_nan() || brightest <= 0.0 {
            return Err(Dark::Void);
        }
        let position = Vec3::from(light.position);
        let (u, v) = (Vec3::from(light.u), Vec3::from(light.v));
        let (shape, center, radius) = match kind {
            LightKind::Parallelogram | LightKind::Triangle | LightKind::Disc => {
                let plane = Plane::new(kind, position, u, v).ok_or(Dark::Void)?;
                let glance = plane.glance(from.into(), surface.normal.into());
                (Shape::Flat(Flat::new(plane, &glance)?), plane.center, plane.radius)
            }
            LightKind::Sphere => (Shape::Ball(Ball::new(position, u.x, from)?), position, u.x),
            LightKind::Point | LightKind::Spot => (Shape::Point(position), position, 0.0),
            LightKind::Distant if light.reach < f32::INFINITY => return Err(Dark::OutOfReach),
            LightKind::Distant => {
                let cap = Cap::new(u, v, surface, answers)?;
                let estimate = brightest * cap.estimate;
                return Ok(Self {
                    solid_angle: cap.solid_angle,
                    shape: Shape::Cap(cap),
                    from,
                    radiance,
                    cone: Vec3::ZERO,
                    cone_cos: -1.0,
                    focus: 0.0,
                    estimate,
                });
            }
        };
        let to = center - from;
        let seen = [libm::sqrtf(to.dot(to)), to.dot(surface.normal), radius];
        Self::finite(light, shape, to, seen, surface.position, answers)
    }

    /// A flat light in the table, of which what follows from the place and the normal of the surface is known.
    ///
    /// # Errors
    /// As of [`Aim::new`].
    #[cfg(feature = "bundles")]
    #[inline(always)]
    pub(crate) fn known(
        light: &Light,
        plane: &Plane,
        (glance, projected): &(Glance<f32>, Option<f32>),
        from: Vec3,
        answers: [bool; 2],
    ) -> Result<Self, Dark> {
        let flat = Flat::new(*plane, glance)?.with_projected(*projected);
        let seen = [glance.distance, glance.above, plane.radius];
        Self::finite(light, Shape::Flat(flat), plane.center - from, seen, from, answers)
    }

    /// A light at a distance, its centre at this height above the surface, in a sphere of this radius.
    #[inline(always)]
    fn finite(
        light: &Light,
        shape: Shape,
        to: Vec3,
        [distance, above, radius]: [f32; 3],
        from: Vec3,
        answers: [bool; 2],
    ) -> Result<Self, Dark> {
        let radiance = Vec3::from(light.radiance);
        let is_spot = light.kind == LightKind::Spot as u32;
        let (cone, cone_cos) = if is_spot {
            (light.u.into(), light.v[0])
        } else {
            (light.cone.into(), light.cone_cos)
        };
        if distance > light.reach {
            return Err(Dark::OutOfReach);
        }
        // Heights of the light's ends above the surface, by its bounding sphere.
        if !takes(answers, above, radius, distance) {
            return Err(Dark::Below);
        }
        let (solid_angle, strength) = match &shape {
            Shape::Flat(flat) => (flat.solid_angle, flat.solid_angle),
            Shape::Ball(ball) => (ball.solid_angle, ball.solid_angle),
            Shape::Point(_) | Shape::Cap(_) => {
                // A point on the surface itself would bring infinitely much.
                if distance * distance < f32::MIN_POSITIVE {
                    return Err(Dark::Void);
                }
                if -to.dot(cone) < cone_cos * distance {
                    return Err(Dark::FacesAway);
                }
                (0.0, 1.0 / (distance * distance))
            }
        };
        let cos = if distance > 0.0 { (above.abs() + radius) / distance } else { 1.0 };
        let (focus, brightest) = (light.focus, radiance.max_element());
        let estimate = brightest * strength * cos.min(1.0) * Light::focal_part(focus, distance);
        if estimate.is_nan() || estimate <= 0.0 {
            return Err(Dark::Void);
        }
        Ok(Self { shape, from, radiance, cone, cone_cos, focus, estimate, solid_angle })
    }

    /// Makes it ready for samples by solid angle, where it looks large; without this they are of its area.
    pub fn prepare(&mut self) {
        if let Shape::Flat(flat) = &mut self.shape {
            flat.prepare(self.from);
        }
    }

    /// The integral of the cosine over the light, in closed form: what it brings to a white surface of this normal without shadows is the radiance
    /// times this over π. `None` if it is not wholly above the surface, if there is no such form, or if a sample may bring more than [`MOST`] times its
    /// share: of a light that is long and near, one sample may have nearly all.
    #[must_use]
    pub fn projected<T: Tracer>(&self, tracer: T, normal: Vec3) -> Option<f32> {
        let (projected, center, radius, nearest, greatest) = match &self.shape {
            _ if self.is_spot() => return None,
            Shape::Flat(flat) => {
                let projected = flat.projected(tracer, self.from, normal)?;
                (projected, flat.plane.center, flat.plane.radius, flat.nearest, flat.greatest())
            }
            Shape::Ball(ball) => {
                let projected = ball.projected(normal)?;
                (projected, ball.center, ball.radius, ball.distance, ball.solid_angle)
            }
            Shape::Point(_) | Shape::Cap(_) => return None,
        };
        let height = (center - self.from).dot(normal);
        let cos = ((height + radius) / nearest).min(1.0);
        (greatest * cos <= MOST * projected).then_some(projected)
    }

    /// Whether it brings more in some directions, or over some distances, than its size says.
    fn is_spot(&self) -> bool {
        self.cone_cos > -1.0 || self.focus > 0.0
    }

    /// Its radiance.
    #[must_use]
    pub const fn radiance(&self) -> Vec3 {
        self.radiance
    }

    /// The light's direction for two numbers in [0, 1).
    #[inline(always)]
    #[must_use]
    pub fn sample<R: Real>(&self, numbers: [R; 2]) -> Sample<R> {
        let [like, _] = numbers;
        let (direction, distance, normal, size, inverse, density, is_there) = match &self.shape {
            Shape::Flat(flat) => {
                let found = flat.sample(self.from, numbers);
                (
                    found.direction,
                    found.distance,
                    Vector::same(like, flat.plane.normal),
                    flat.plane.size,
                    found.inverse,
                    found.density,
                    found.is_there,
                )
            }
            Shape::Ball(ball) => {
                let (direction, distance, normal) = ball.sample(self.from, numbers);
                let (inverse, density) = (ball.solid_angle, 1.0 / ball.solid_angle);
                let (inverse, density) = (like.same(inverse), like.same(density));
                (direction, distance, normal, ball.size, inverse, density, like.always())
            }
            Shape::Point(position) => {
                let to = *position - self.from;
                let square = to.dot(to);
                let distance = libm::sqrtf(square);
                return Sample {
                    direction: Vector::same(like, to / distance),
                    end: Some(Vector::same(like, *position)),
                    distance: like.same(distance),
                    inverse: like.same(Light::focal_part(self.focus, distance) / square),
                    density: like.same(f32::INFINITY),
                    is_lit: like.always(),
                };
            }
            Shape::Cap(cap) => {
                let (direction, inverse, is_lit) = cap.sample(numbers);
                return Sample {
                    direction,
                    end: None,
                    distance: like.same(f32::INFINITY),
                    inverse,
                    density: like.same(1.0 / cap.solid_angle),
                    is_lit,
                };
            }
        };
        let mut is_lit = is_there;
        if self.cone_cos > -1.0 {
            is_lit = is_lit & !like.same(self.cone_cos).above(-direction.on(self.cone));
        }
        let from = Vector::same(like, self.from);
        let end = before(from, direction, distance, normal, like.same(size));
        let inverse = inverse * Light::focal_part(self.focus, distance);
        Sample { direction, end: Some(end), distance, inverse, density, is_lit }
    }

    /// As one of many that are sampled together, if it is.
    #[cfg(feature = "bundles")]
    pub(crate) fn lamp(&self) -> Option<Lamp> {
        match &self.shape {
            Shape::Flat(flat) if !self.is_spot() => flat.lamp(),
            _ => None,
        }
    }

    /// The density [1/sr] by which light sampling counts, against that of a ray that found `light` by itself, at
    /// `distance` in the unit `direction`. 0 if sampling cannot find it.
    ///
    /// It need not be the density of [`Aim::sample`], as long as both sides use the same; this one is cheap.
    #[must_use]
    pub fn density(light: &Light, from: Vec3, direction: Vec3, distance: f32) -> f32 {
        let position = Vec3::from(light.position);
        let (u, v) = (Vec3::from(light.u), Vec3::from(light.v));
        match LightKind::from_u32(light.kind) {
            Some(kind @ (LightKind::Parallelogram | LightKind::Triangle | LightKind::Disc)) => {
                Flat::density(kind, u, v, direction, distance)
            }
            Some(LightKind::Sphere) => {
                Ball::new(position, u.x, from).map_or(0.0, |ball| 1.0 / ball.solid_angle)
            }
            Some(LightKind::Distant) => 1.0 / Cap::solid_angle(v),
            _ => 0.0,
        }
    }

    /// The centre of a light's shape; of a distant one its direction.
    #[cfg_attr(feature = "bundles", inline)]
    #[must_use]
    pub fn center(light: &Light) -> Vec3 {
        let position = Vec3::from(light.position);
        let (u, v) = (Vec3::from(light.u), Vec3::from(light.v));
        match LightKind::from_u32(light.kind) {
            Some(LightKind::Distant) => u,
            Some(kind) => center(kind, position, u, v),
            None => position,
        }
    }
}
