use super::aim::Dark;
use crate::elementary::sin_cos_of_turns;
use crate::material::{Surface, tangents};
use crate::real::{Real, Vector};
use core::f32::consts::PI;
use glam::Vec3;

/// Directions round an axis, with light from infinitely far.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Cap {
    axis: Vec3,
    /// `1 - cos` of the half angle, at least that of a line in f32.
    versine: f32,
    pub(super) solid_angle: f32,
    /// Solid angle times cosine at the surface, roughly.
    pub(super) estimate: f32,
    hemisphere: Option<Hemisphere>,
}

/// Sampled by the cosine at the surface, the light's own size is not used.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Hemisphere {
    normal: Vec3,
    answers: [bool; 2],
}

/// A light that is wider than this (60°) is sampled as part of the hemisphere that the surface sees.
const WIDE: f32 = 0.5;

impl Cap {
    pub(super) fn new(
        axis: Vec3,
        width: Vec3,
        surface: &Surface,
        answers: [bool; 2],
    ) -> Result<Self, Dark> {
        let versine = versine(width);
        let sin = libm::sqrtf(versine * (2.0 - versine));
        // The greatest and the least height of its directions above the surface.
        let height = axis.dot(surface.normal);
        let aside = libm::sqrtf((1.0 - height * height).max(0.0));
        let highest =
            if height >= 1.0 - versine { 1.0 } else { height * (1.0 - versine) + aside * sin };
        let lowest =
            if -height >= 1.0 - versine { -1.0 } else { height * (1.0 - versine) - aside * sin };
        let slack = 1e-6;
        if !(answers[0] && highest > -slack || answers[1] && lowest < slack) {
            return Err(Dark::Below);
        }
        let solid_angle = 2.0 * PI * versine;
        let top = f32::max(
            if answers[0] { highest } else { 0.0 },
            if answers[1] { -lowest } else { 0.0 },
        );
        let hemisphere =
            (versine > WIDE).then_some(Hemisphere { normal: surface.shading, answers });
        let estimate = solid_angle.min(PI) * top.max(slack);
        Ok(Self { axis, versine, solid_angle, estimate, hemisphere })
    }

    /// A unit direction of the light, one over its density, and whether it is not beside it.
    #[inline(always)]
    pub(super) fn sample<R: Real>(&self, [a, b]: [R; 2]) -> (Vector<R>, R, R::Mask) {
        let Some(hemisphere) = &self.hemisphere else {
            let direction = around(self.axis, a * self.versine, b);
            return (direction, a.same(self.solid_angle), a.always());
        };
        // A surface that answers on both sides gives each half of the samples.
        let (a, side, halves) = match hemisphere.answers {
            [true, true] => {
                let front = a.same(0.5).above(a);
                let a = a * 2.0;
                let side = R::select(front, a.same(1.0), a.same(-1.0));
                (R::select(front, a, a - 1.0), side, 2.0)
            }
            [_, false] => (a, a.same(1.0), 1.0),
            [false, true] => (a, a.same(-1.0), 1.0),
        };
        // Cosine-weighted: cos² uniform; 1 - a is above zero.
        let cos = a.complement().sqrt();
        let direction = Vector::along(hemisphere.normal, cos * side)
            + aside(hemisphere.normal, cos.complement(), b);
        let is_beside = a.same(1.0 - self.versine).above(direction.on(self.axis));
        (direction, cos.same(halves * PI) / cos, !is_beside)
    }

    pub(super) fn solid_angle(width: Vec3) -> f32 {
        2.0 * PI * versine(width)
    }
}

/// A unit direction whose cosine to the axis is `1 - versine`, at turn `b`.
#[inline(always)]
fn around<R: Real>(axis: Vec3, versine: R, b: R) -> Vector<R> {
    Vector::along(axis, versine.complement()) + aside(axis, versine, b)
}

/// The part of it at right angles to the axis.
#[inline(always)]
fn aside<R: Real>(axis: Vec3, versine: R, b: R) -> Vector<R> {
    let (sin, cos) = sin_cos_of_turns(b);
    let (s, t) = tangents(axis);
    let sine = (versine * (-versine + 2.0)).at_least(0.0).sqrt();
    (Vector::along(s, cos) + Vector::along(t, sin)) * sine
}

/// The light's own, or that of its cosine, which f32 holds to 6e-8 only: half a percent of a sun.
pub(crate) fn versine(width: Vec3) -> f32 {
    let versine = if width.y > 0.0 { width.y } else { 1.0 - width.x };
    versine.clamp(1e-12, 2.0)
}
