use super::Sample;
use super::aim::before;
use super::flat::{Found, corner};
use crate::real::{Real, Vector};
use glam::Vec3;

/// A parallelogram or triangle that a point samples by its area, and that shines in all directions.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Lamp {
    pub(crate) position: Vec3,
    pub(crate) u: Vec3,
    pub(crate) v: Vec3,
    /// Unit, on the side that shines.
    pub(crate) normal: Vec3,
    /// Its area times the height of the point above it.
    pub(crate) strength: f32,
    /// The sum of all lengths that rounding depends on.
    pub(crate) size: f32,
    pub(crate) is_triangle: bool,
}

/// A [`Lamp`] in each lane, and the point that it is seen from.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Lamps<R: Real> {
    pub(crate) from: Vector<R>,
    pub(crate) position: Vector<R>,
    pub(crate) u: Vector<R>,
    pub(crate) v: Vector<R>,
    pub(crate) normal: Vector<R>,
    pub(crate) strength: R,
    pub(crate) size: R,
    pub(crate) is_triangle: R::Mask,
}

impl<R: Real> Lamps<R> {
    /// What [`Aim::sample`](super::Aim::sample) says of each.
    #[inline(always)]
    pub(crate) fn sample(&self, [a, b]: [R; 2]) -> Sample<R> {
        let (x, y) = corner([a, b]);
        let (x, y) = (R::select(self.is_triangle, x, a), R::select(self.is_triangle, y, b));
        let to = self.u * x + self.v * y + self.position - self.from;
        let Found { direction, distance, inverse, density, is_there: is_lit } =
            Found::by_area(to, self.strength, None);
        let end = before(self.from, direction, distance, self.normal, self.size);
        Sample { direction, end: Some(end), distance, inverse, density, is_lit }
    }
}
