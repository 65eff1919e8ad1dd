use super::Dark;
use super::ellipse::Ellipse;
#[cfg(feature = "bundles")]
use super::lamp::Lamp;
use super::plane::{Glance, Plane, plane};
use super::projected::Polygon;
use super::rectangle::Rectangle;
use super::triangle::SphericalTriangle;
use crate::elementary::sin_cos_of_turns;
use crate::real::{Part, Real, Vector};
use crate::scene::LightKind;
use crate::trace::Tracer;
use glam::Vec3;

/// A parallelogram, triangle or disc in front of a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Flat {
    pub(super) plane: Plane,
    /// Distance of the point from the plane; above zero.
    height: f32,
    /// No point of it is nearer.
    pub(super) nearest: f32,
    /// Roughly, and never more than 2π.
    pub(super) solid_angle: f32,
    looks_large: bool,
    near: Near,
    /// See [`Flat::projected`], if it is known already.
    #[cfg(feature = "bundles")]
    known: Option<Option<f32>>,
}

/// How it is sampled by solid angle, where it looks large.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Near {
    /// By area.
    No,
    Rectangle(Rectangle),
    Disc(Ellipse),
    Triangle(SphericalTriangle),
}

/// A point on the shape.
pub(super) struct Found<R: Real> {
    pub(super) direction: Vector<R>,
    pub(super) distance: R,
    /// One over the density \[sr\].
    pub(super) inverse: R,
    /// See [`Aim::density`].
    pub(super) density: R,
    /// Whether there is such a point.
    pub(super) is_there: R::Mask,
}

/// Above this quotient of area and squared distance to the centre the solid angle is sampled: below it uniform area is
/// nearly the same, cheaper, and better conditioned.
const NEAR: f32 = 0.2;

impl Flat {
    /// In front of a point, if it is.
    #[inline(always)]
    pub(super) fn new(plane: Plane, glance: &Glance<f32>) -> Result<Self, Dark> {
        let &Glance { height, nearest, solid_angle, square, .. } = glance;
        if height.is_nan() || height <= 0.0 {
            return Err(Dark::FacesAway);
        }
        Ok(Self {
            plane,
            height,
            nearest,
            solid_angle,
            looks_large: plane.area > NEAR * square,
            near: Near::No,
            #[cfg(feature = "bundles")]
            known: None,
        })
    }

    /// The same, of which [`projected`](Self::projected) is known.
    #[cfg(feature = "bundles")]
    #[inline(always)]
    pub(super) const fn with_projected(self, projected: Option<f32>) -> Self {
        Self { known: Some(projected), ..self }
    }

    /// Chooses how it is sampled; costly where it looks large.
    #[cfg_attr(not(feature = "bundles"), inline(never))]
    pub(super) fn prepare(&mut self, from: Vec3) {
        if !self.looks_large {
            return;
        }
        let Plane { kind, position, u, v, normal, .. } = self.plane;
        let corner = position - from;
        let square = u.dot(u) * v.dot(v);
        let near = match kind {
            LightKind::Parallelogram if u.dot(v) * u.dot(v) <= 1e-10 * square => {
                Rectangle::new(corner, u, v).map(Near::Rectangle)
            }
            LightKind::Disc => Ellipse::new(corner, normal, u).map(Near::Disc),
            LightKind::Triangle => {
                SphericalTriangle::new(corner, corner + u, corner + v).map(Near::Triangle)
            }
            _ => None,
        };
        self.near = near.unwrap_or(Near::No);
    }

    /// The point of the shape for two numbers in [0, 1).
    #[inline(always)]
    pub(super) fn sample<R: Real>(&self, from: Vec3, numbers: [R; 2]) -> Found<R> {
        let [like, _] = numbers;
        let (to, inverse) = match &self.near {
            Near::No => (self.on_shape(numbers) + self.plane.position - from, None),
            Near::Rectangle(rectangle) => {
                (rectangle.sample(numbers), Some(like.same(rectangle.solid_angle)))
            }
            Near::Disc(ellipse) => {
                let (direction, inverse) = ellipse.sample(numbers);
                (self.along(direction), Some(inverse))
            }
            Near::Triangle(triangle) => {
                (self.along(triangle.sample(numbers)), Some(like.same(triangle.solid_angle)))
            }
        };
        Found::by_area(to, like.same(self.plane.area * self.height), inverse)
    }

    /// As one of many, if it is.
    #[cfg(feature = "bundles")]
    pub(super) fn lamp(&self) -> Option<Lamp> {
        let Plane { kind, position, u, v, normal, area, size, .. } = self.plane;
        let is_plain = matches!(self.near, Near::No) && kind != LightKind::Disc;
        let is_triangle = kind == LightKind::Triangle;
        is_plain.then_some(Lamp {
            position,
            u,
            v,
            normal,
            strength: area * self.height,
            size,
            is_triangle,
        })
    }

    /// The integral of the cosine over all of it, if it is wholly above the surface and has corners.
    pub(super) fn projected<T: Tracer>(&self, tracer: T, from: Vec3, normal: Vec3) -> Option<f32> {
        #[cfg(feature = "bundles")]
        if let Some(known) = self.known {
            return known;
        }
        Polygon::of(&self.plane)?.projected(tracer, from, normal, self.height)
    }

    /// One over the density of its samples is no greater \[sr\].
    pub(super) fn greatest(&self) -> f32 {
        match &self.near {
            Near::No => {
                self.plane.area * self.height / (self.nearest * self.nearest * self.nearest)
            }
            Near::Rectangle(rectangle) => rectangle.solid_angle,
            Near::Triangle(triangle) => triangle.solid_angle,
            Near::Disc(_) => f32::INFINITY,
        }
    }

    /// The vector to the plane in a unit direction; without end where there is none.
    #[inline(always)]
    fn along<R: Real>(&self, direction: Vector<R>) -> Vector<R> {
        let cos = -direction.on(self.plane.normal);
        direction * (cos.same(self.height) / cos.at_least(0.0))
    }

    pub(super) fn density(
        kind: LightKind,
        u: Vec3,
        v: Vec3,
        direction: Vec3,
        distance: f32,
    ) -> f32 {
        let Some((normal, area)) = plane(kind, u, v) else { return 0.0 };
        let cos = -direction.dot(normal);
        if cos > 0.0 { distance * distance / (area * cos) } else { 0.0 }
    }

    #[inline(always)]
    fn on_shape<R: Real>(&self, [a, b]: [R; 2]) -> Vector<R> {
        let (x, y) = match self.plane.kind {
            LightKind::Triangle => corner([a, b]),
            LightKind::Disc => concentric(a, b),
            _ => (a, b),
        };
        Vector::along(self.plane.u, x) + Vector::along(self.plane.v, y)
    }
}

impl<R: Real> Found<R> {
    /// The point at `to`, of a shape whose area times the height of who looks is `strength`; by its area, unless one over the density is known.
    #[inline(always)]
    pub(super) fn by_area(to: Vector<R>, strength: R, inverse: Option<R>) -> Self {
        let square = to.dot(to);
        let distance = square.sqrt();
        // The height is the same for all points of the plane: more exact than the product of direction and normal.
        let by_area = strength / (square * distance);
        let density = distance.same(1.0) / by_area;
        let inverse = match inverse {
            Some(inverse) => inverse,
            None => by_area,
        };
        let is_there = by_area.is_positive() & density.is_positive();
        Self { direction: to / distance, distance, inverse, density, is_there }
    }
}

/// From the unit square to the triangle below its diagonal: continuous, with the evenness of the square kept along both axes (Turk 1990).
#[inline(always)]
pub(super) fn corner<R: Real>([a, b]: [R; 2]) -> (R, R) {
    let root = a.sqrt();
    (root * b.complement(), root * b)
}

/// The map of Shirley & Chiu 1997 from the unit square to the unit disc.
#[inline(always)]
pub(super) fn concentric<R: Real>(a: R, b: R) -> (R, R) {
    R::apart(Concentric(a, b))
}

struct Concentric<R>(R, R);

impl<R: Real> Part for Concentric<R> {
    type Result = (R, R);

    #[inline(always)]
    fn run(self) -> (R, R) {
        let (x, y) = (self.0 * 2.0 - 1.0, self.1 * 2.0 - 1.0);
        let is_flat = x.abs().above(y.abs());
        let (radius, aside) = (R::select(is_flat, x, y), R::select(is_flat, y, x));
        // In the middle both are 0, and any angle will do.
        let (sin, cos) = sin_cos_of_turns((aside / radius).at_least(-1.0) * 0.125);
        let (along, aside) = (radius * cos, radius * sin);
        (R::select(is_flat, along, aside), R::select(is_flat, aside, along))
    }
}
