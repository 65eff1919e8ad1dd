//! The convex region of a bundle of rays, and whether a box can be touched by one of them.

mod hull;

use super::rounding::{UNIT_ROUNDOFF, max, min};
use super::{Aabb, Ray};
use crate::scene::Light;
use glam::Vec3;
use hull::Hull;

/// Greatest number of planes: eight sides, near and far, and six along the axes.
const PLANES_MAX: usize = 16;

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
    /// What is to be allowed for, per unit of `R`.
    slack: f32,
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
/// an own box in the box, 8 u for the directions of the rays, 1 u for the normal, 5 u for the test; rounded up.
const SLACK: f32 = 40.0 * UNIT_ROUNDOFF;

impl Pyramid {
    /// All of space: every box lies in it.
    pub const EVERYWHERE: Self = Self {
        origin: Vec3::ZERO,
        spread: 0.0,
        direction: Vec3::Z,
        planes: [Plane { normal: Vec3::ZERO, offset: 0.0, slack: 0.0 }; PLANES_MAX],
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
        Self::of_hull(&Hull::to_light(from, light))
    }

    /// A direction in the middle of the bundle, of no particular length: its signs are the order of octants.
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
        if planes.is_none() {
            return Some(planes);
        }
        let lo = aabb.min - self.origin;
        let hi = aabb.max - self.origin;
        let far = lo.abs().max(hi.abs());
        let reach = max(max(far.x, far.y), far.z) + self.spread;
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
    fn add(&mut self, hull: &Hull, normal: glam::DVec3) {
        let greatest = normal.abs().max_element();
        let Some(plane) = self.planes.get_mut(usize::from(self.len)) else { return };
        if !(greatest > 0.0 && greatest < f64::INFINITY) {
            return;
        }
        let normal = normal / greatest;
        let Some(support) = hull.support(normal) else { return };
        let offset = (-support) as f32;
        let normal = normal.as_vec3();
        let slack = SLACK * (normal.x.abs() + normal.y.abs() + normal.z.abs());
        *plane = Plane { normal, offset: offset + offset.abs() * 2.0 * UNIT_ROUNDOFF, slack };
        self.len += 1;
    }
}

#[cfg(test)]
mod tests;
