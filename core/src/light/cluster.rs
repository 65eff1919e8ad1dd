//! Many lights as one: what a node of the light tree shows to a point.

use super::aim::takes;
use super::{Dark, Seen};
use crate::material::Surface;
use crate::scene::LightNode;
use glam::Vec3;

/// Lengths below it, in parts of the distance, and cosines below it are taken for 0 or for it: more than all rounding, here and in looks at single lights, so
/// that no light is dark because its node is.
const SLACK: f32 = 1e-3;

/// From so many radii away a node looks small.
const NEAR: f32 = 16.0;

impl LightNode {
    /// What the lights below a node that is no leaf bring to a surface that answers light from its sides: [`Seen::Near`] where they do not look small,
    /// and [`Seen::Dark`] only if each is.
    pub(crate) fn look(&self, surface: &Surface, answers: [bool; 2]) -> Seen {
        let to = Vec3::from(self.center) - surface.position;
        let square = to.dot(to);
        let is_far = square > NEAR * NEAR * self.radius * self.radius && square < f32::MAX;
        if !is_far {
            return Seen::Near;
        }
        let distance = libm::sqrtf(square);
        let radius = self.radius + distance * SLACK;
        if distance - radius > self.reach {
            return Seen::Dark(Dark::OutOfReach);
        }
        let height = to.dot(surface.normal);
        if !takes(answers, height, radius, distance) {
            return Seen::Dark(Dark::Below);
        }
        let size = radius / distance;
        let Some(sent) = self.sent(to / distance, size) else { return Seen::Dark(Dark::FacesAway) };
        let cos = height / distance;
        let [front, back] = [cos, -cos].map(|cos| positive(cos, size));
        let taken = if answers[0] { front } else { 0.0 } + if answers[1] { back } else { 0.0 };
        let estimate = self.power * sent * taken.max(SLACK * SLACK) / square;
        if estimate > 0.0 { Seen::Far(estimate) } else { Seen::Dark(Dark::Void) }
    }

    /// The estimate of a node that looks large: of one that is chosen already, for the choice below it.
    pub(crate) fn near(&self, surface: &Surface) -> f32 {
        let to = Vec3::from(self.center) - surface.position;
        let least = self.radius * self.radius;
        self.power / to.dot(to).max(least).max(f32::MIN_POSITIVE)
    }

    /// The part of their power that the lights below send to a point that sees them in this direction, in a cone whose half angle has this sine; `None` only if
    /// all face away from it.
    fn sent(&self, direction: Vec3, sin_size: f32) -> Option<f32> {
        if self.cone_cos <= -1.0 && self.mean_cos == 0.0 {
            return Some(positive(0.0, 1.0));
        }
        let root = |square: f32| libm::sqrtf(square.max(0.0));
        let cos = -direction.dot(self.axis.into());
        let sin = root(1.0 - cos * cos);
        let (cone_cos, cone_sin) = (self.cone_cos, root(1.0 - self.cone_cos * self.cone_cos));
        // Of the difference and the sum of the angle to the axis and that of the cone: the greatest and the least cosine of a normal.
        let most = if cos >= cone_cos { 1.0 } else { cos * cone_cos + sin * cone_sin };
        let least = if cos <= -cone_cos { -1.0 } else { cos * cone_cos - sin * cone_sin };
        // Seen from elsewhere in the sphere they are greater by no more than its angle, which is below a right one.
        if most < -(sin_size + SLACK) {
            return None;
        }
        Some(positive(cos * self.mean_cos, 0.5 * (most - least)).max(SLACK * SLACK))
    }
}

/// The mean of the positive part of numbers that are spread evenly, so far up and down from their mean: as cosines are over the cap of a sphere.
fn positive(mean: f32, spread: f32) -> f32 {
    if mean >= spread {
        mean
    } else if mean <= -spread {
        0.0
    } else {
        (mean + spread) * (mean + spread) / (4.0 * spread)
    }
}
