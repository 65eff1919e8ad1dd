//! The convex region of a bundle of rays, and whether a box can be touched by one of them.

mod hull;

use super::rounding::{UNIT_ROUNDOFF, max, min};
use super::{Aabb, Primitive, Ray};
use crate::scene::{Light, LightKind};
use glam::{DVec3, Vec3};
use hull::Hull;

/// Greatest number of planes: a surface, eight sides, near and far, and six along the axes.
const PLANES_MAX: usize = 17;
/// What is allowed for the test's own rounding with a triangle, in parts of `R` and of the sum of the normal's components.
const SLACK_DIRECT: f32 = 12.0 * UNIT_ROUNDOFF;
/// What is allowed for the triangle test ([64 u](super::PreparedRay::TRIANGLE_ERROR)) and the directions of the rays, in parts of `R` and
/// of the normal's length.
const SLACK_TRIANGLE: f32 = 88.0 * UNIT_ROUNDOFF;

/// A convex region that holds every ray of a bundle: for a tile of a picture a pyramid with its apex in the eye (or a
/// prism, for a parallel view); for shadow rays the hull of where they begin and of the light's own shape.
///
/// It is the intersection of half-spaces. Any set of half-spaces that holds the bundle is
/// right, and more of them are tighter; those taken here, together with the bounds along x, y, z, separate an infinite pyramid
/// from any box that does not touch it: the sides, and for each axis the two planes along it that touch the pyramid. (The latter are the
/// cross products of a box's edges and the pyramid's, of which at most two per axis can separate. They do what the second, edge test of
/// Reinhard's pyramid clipping does.)
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pyramid {
    /// All else is relative to it: the eye, or the middle of where the rays begin.
    origin: Vec3,
    /// The light itself, if it is a sphere: no shadow ray to it hits it.
    own: Option<(Vec3, f32)>,
    /// Greatest distance along an axis between `origin` and a place where a ray begins.
    spread: f32,
    direction: Vec3,
    planes: [Plane; PLANES_MAX],
    len: u8,
    /// Lower and upper bounds of the region.
    lo: Vec3,
    hi: Vec3,
}

/// The points `x` with `normal · (x - origin) + offset >= 0`.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Plane {
    normal: Vec3,
    offset: f32,
    /// What is to be allowed for a box, per unit of `R`.
    slack: f32,
    /// What is to be allowed for a triangle itself.
    triangle_slack: f32,
}

/// The planes of a pyramid that cut a box, by bits: those of its parts need only be tested against these.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Planes(u32);

impl Planes {
    /// Nothing is known.
    pub const ALL: Self = Self(u32::MAX);
    /// None cuts it: the box lies in the pyramid, with all that is in it.
    pub const NONE: Self = Self(0);
    const BOUNDS: u32 = 1 << 31;

    /// Whether the box lies in the pyramid.
    #[must_use]
    pub const fn is_none(self) -> bool {
        self.0 == 0
    }

    /// As a number, to be stored.
    #[must_use]
    pub const fn bits(self) -> u32 {
        self.0
    }

    /// From a stored number. Any number is safe if it came from the same pyramid.
    #[must_use]
    pub const fn from_bits(bits: u32) -> Self {
        Self(bits)
    }
}

/// A box, seen from a pyramid.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Side {
    /// No ray of the bundle hits anything in the box.
    Outside,
    /// Some may.
    Partly,
    /// All of the box lies in the pyramid.
    Inside,
}

/// Allowance for rounding, in parts of `R`, the greatest distance along an axis between the pyramid's origin and the box: 16 u for the pad of
/// an own box in the box, 8 u for the directions of the rays, 2 u for the box, 1 u for the normal, 5 u for the test; rounded up.
const SLACK: f32 = 40.0 * UNIT_ROUNDOFF;

impl Pyramid {
    /// All of space: every box lies in it.
    pub const EVERYWHERE: Self = Self {
        origin: Vec3::ZERO,
        own: None,
        spread: 0.0,
        direction: Vec3::Z,
        planes: [Plane { normal: Vec3::ZERO, offset: 0.0, slack: 0.0, triangle_slack: 0.0 };
            PLANES_MAX],
        len: 0,
        lo: Vec3::NEG_INFINITY,
        hi: Vec3::INFINITY,
    };

    /// The pyramid of a tile: of all rays between four, given in their order around it.
    ///
    /// Between means that origin and direction are a mean, with weights not below zero, of the four
    /// origins and directions; that holds for perspective and parallel views, and for lenses. If all four have an end, the
    /// rays end in the hull of their beginnings and ends (as they do at an aft clipping plane).
    /// Origins and directions of the rays may be off by some units in the last place, relative to the corners'.
    #[must_use]
    pub fn of_tile(corners: &[Ray; 4]) -> Self {
        Self::of_hull(&Hull::of_tile(corners))
    }

    /// The pyramid of all segments from a box of points, which may be a single point, to a light.
    ///
    /// It is tight around the light's own shape: polygons by their corners, discs and the side of a sphere that can be seen by eight planes. It holds the rays of
    /// [`SurfacePoint::spawn_to`](super::SurfacePoint::spawn_to) that begin in `from`.
    #[must_use]
    pub fn to_light(from: &Aabb, light: &Light) -> Self {
        Self::of_hull(&Hull::to_light(from, light)).with_own(light)
    }

    /// The same from one point, just off a surface, for rays that do not point back through it.
    pub(super) fn from_surface(origin: Vec3, normal: DVec3, light: &Light) -> Self {
        let mut hull = Hull::to_light(&Aabb { min: origin, max: origin }, light);
        hull.surface = Some(normal);
        Self::of_hull(&hull).with_own(light)
    }

    fn with_own(self, light: &Light) -> Self {
        let [radius, ..] = light.u;
        let sphere = light.kind == LightKind::Sphere as u32;
        Self { own: sphere.then_some((Vec3::from_array(light.position), radius)), ..self }
    }

    /// A direction in the middle of the bundle, of no particular length: its signs choose the order of children.
    #[must_use]
    pub fn direction(&self) -> Vec3 {
        self.direction
    }

    /// Whether a box lies outside, partly or wholly in the region.
    #[must_use]
    pub fn classify(&self, aabb: &Aabb) -> Side {
        match self.clip(aabb, Planes::ALL) {
            None => Side::Outside,
            Some(Planes::NONE) => Side::Inside,
            Some(_) => Side::Partly,
        }
    }

    /// The planes that cut a box, out of those that cut a box around it, or `None` if it lies outside.
    ///
    /// A plane is asked about two of the box's eight vertices: the farthest on its inner
    /// side, and the farthest on its outer side. If the former is outside, all are; if the latter is inside, all are.
    /// A box is outside only if it is so by more than rounding can amount to, anywhere: no hit of a ray of the bundle is lost, by
    /// the definition of a [hit](super#what-a-hit-is). NaN and infinity make a box partly inside.
    #[must_use]
    pub fn clip(&self, aabb: &Aabb, planes: Planes) -> Option<Planes> {
        let lo = aabb.min - self.origin;
        let hi = aabb.max - self.origin;
        self.clip_relative(lo, hi, greatest(lo.abs().max(hi.abs())), planes)
    }

    /// As [`clip`](Self::clip), of a box relative to [`origin`](Self::origin), whose bounds may be off by two roundings of
    /// `reach`, which is at least the greatest distance along an axis between the origin and the box.
    #[must_use]
    pub fn clip_relative(&self, lo: Vec3, hi: Vec3, reach: f32, planes: Planes) -> Option<Planes> {
        if planes.is_none() {
            return Some(planes);
        }
        let reach = reach + self.spread;
        let mut cut = 0;
        if planes.0 & Planes::BOUNDS != 0 {
            let pad = Vec3::splat(reach * SLACK);
            if (lo - pad).cmpgt(self.hi).any() || (hi + pad).cmplt(self.lo).any() {
                return None;
            }
            if !((lo - pad).cmpge(self.lo).all() && (hi + pad).cmple(self.hi).all()) {
                cut = Planes::BOUNDS;
            }
        }
        for (i, plane) in self.planes.iter().take(usize::from(self.len)).enumerate() {
            if planes.0 >> i & 1 == 0 {
                continue;
            }
            let (a, b) = (plane.normal * lo, plane.normal * hi);
            let most = max(a.x, b.x) + max(a.y, b.y) + max(a.z, b.z) + plane.offset;
            let slack = reach * plane.slack;
            if most < -slack {
                return None;
            }
            let least = min(a.x, b.x) + min(a.y, b.y) + min(a.z, b.z) + plane.offset;
            let inside = least >= slack;
            if !inside {
                cut |= 1 << i;
            }
        }
        Some(Planes(cut))
    }

    /// Whether a ray of the bundle may hit a primitive. Sharper than a box: a triangle that lies beyond one plane is not
    /// touched, though its box may be; nor is the light that the shadow rays go to.
    #[must_use]
    pub fn touches(&self, primitive: &Primitive, planes: Planes) -> bool {
        let own = match *primitive {
            Primitive::Triangle { vertices, .. } => {
                if !planes.is_none() && self.beyond(vertices.map(|v| v - self.origin)) {
                    return false;
                }
                Aabb::of_triangle(vertices)
            }
            Primitive::Sphere { center, radius, .. } => {
                if self.own == Some((center, radius)) {
                    return false;
                }
                Aabb::of_sphere(center, radius)
            }
        };
        self.clip(&own, planes).is_some()
    }

    /// Whether a triangle lies beyond one plane.
    fn beyond(&self, vertices: [Vec3; 3]) -> bool {
        let [a, b, c] = vertices;
        let reach = greatest(a.abs().max(b.abs()).max(c.abs())) + self.spread;
        self.planes.iter().take(usize::from(self.len)).any(|plane| {
            let [a, b, c] = vertices.map(|v| plane.normal.dot(v) + plane.offset);
            let slack = -reach * plane.triangle_slack;
            // A NaN is not beyond.
            a < slack && b < slack && c < slack
        })
    }

    /// The point that all is relative to: the eye of a tile, the middle of where shadow rays begin.
    #[must_use]
    pub fn origin(&self) -> Vec3 {
        self.origin
    }

    fn of_hull(hull: &Hull) -> Self {
        let mut pyramid = Self::EVERYWHERE;
        if !hull.is_finite() {
            return pyramid;
        }
        pyramid.direction = hull.axis.as_vec3();
        pyramid.origin = hull.origin;
        pyramid.spread = hull.spread as f32;
        (pyramid.lo, pyramid.hi) = hull.bounds();
        hull.normals(&mut |normal| pyramid.add(hull, normal));
        pyramid
    }

    /// Adds the half-space of a normal that holds the hull and touches it; none, if the hull is unbounded there.
    fn add(&mut self, hull: &Hull, normal: DVec3) {
        let greatest = normal.abs().max_element();
        let Some(plane) = self.planes.get_mut(usize::from(self.len)) else { return };
        if !(greatest > 0.0 && greatest < f64::INFINITY) {
            return;
        }
        let Some(support) = hull.support(normal) else { return };
        let offset = (-support / greatest) as f32;
        let normal = (normal / greatest).as_vec3();
        let sum = normal.x.abs() + normal.y.abs() + normal.z.abs();
        let slack = SLACK * sum;
        let triangle_slack = SLACK_DIRECT * sum + SLACK_TRIANGLE * libm::sqrtf(normal.dot(normal));
        let offset = offset + offset.abs() * 2.0 * UNIT_ROUNDOFF;
        *plane = Plane { normal, offset, slack, triangle_slack };
        self.len += 1;
    }
}

fn greatest(v: Vec3) -> f32 {
    max(max(v.x, v.y), v.z)
}

#[cfg(test)]
mod tests;
