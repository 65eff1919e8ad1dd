use glam::Vec3;
use kiloray_core::geometry::{Hit, Primitive, Ray};

use super::{POINT_BOUND, SHELL_BOUND, SphereTruth, TriangleTruth, distance_to_triangle};

/// All primitives of a scene, with their materials.
#[derive(Debug, Clone, Default)]
pub struct Scene {
    /// In any order.
    pub primitives: Vec<(Primitive, u16)>,
}

/// What the oracle says of a closest hit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Verdict {
    /// It is the truth: nothing is near a border.
    Right,
    /// It is within the bounds: the exact ray passes an edge or a rim within the bound, or two hits, or a hit and an
    /// end of the ray, lie as close to each other as their errors.
    WithinBounds,
    /// It is wrong.
    Wrong(Wrong),
}

/// Why a hit is wrong.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Wrong {
    /// The primitive is not in the scene, or not with this material.
    NotThere,
    /// `t` is not what the ray accepts.
    OutOfRange,
    /// The ray passes beside the primitive.
    Missed {
        /// How far beside it.
        margin: f64,
    },
    /// The point at `t` is not on the primitive.
    Off {
        /// How far off, in parts of the bound.
        parts: f64,
    },
    /// The ray surely hits this primitive before.
    Behind {
        /// Index of the primitive.
        primitive: usize,
    },
}

/// Where the ray may accept a hit of a primitive.
struct Range {
    t: f64,
    error: f64,
}

impl Scene {
    /// Holds the closest hit of a ray against the truth.
    #[must_use]
    pub fn judge(&self, ray: &Ray, hit: Option<&Hit>) -> Verdict {
        if !(ray.origin.is_finite() && ray.direction.is_finite()) || ray.direction == Vec3::ZERO {
            return hit.map_or(Verdict::Right, |_| Verdict::Wrong(Wrong::OutOfRange));
        }
        let mut near_border = false;
        if let Some(hit) = hit {
            match self.judge_hit(ray, hit) {
                Ok(near) => near_border |= near,
                Err(wrong) => return Verdict::Wrong(wrong),
            }
        }
        let end = hit.map_or(f64::INFINITY, |hit| f64::from(hit.t));
        for (i, (primitive, _)) in self.primitives.iter().enumerate() {
            if hit.is_some_and(|hit| hit.primitive == *primitive) {
                continue;
            }
            match first_sure(ray, primitive) {
                Ok(Some(sure)) if sure.t + sure.error < end => {
                    return Verdict::Wrong(Wrong::Behind { primitive: i });
                }
                Ok(Some(sure)) => near_border |= sure.t - sure.error < end,
                Ok(None) => {}
                Err(()) => near_border = true,
            }
        }
        if near_border { Verdict::WithinBounds } else { Verdict::Right }
    }

    /// Whether the hit is near a border, if it is a hit at all.
    fn judge_hit(&self, ray: &Ray, hit: &Hit) -> Result<bool, Wrong> {
        let same = |&(primitive, material): &(Primitive, u16)| {
            material == hit.material && primitive == hit.primitive
        };
        if !self.primitives.iter().any(same) {
            return Err(Wrong::NotThere);
        }
        if !(hit.t >= ray.t_min && hit.t <= ray.t_max) {
            return Err(Wrong::OutOfRange);
        }
        let point = ray.origin.as_dvec3() + ray.direction.as_dvec3() * f64::from(hit.t);
        let (margin, missed, sure, off) = match hit.primitive {
            Primitive::Triangle { vertices, .. } => {
                let truth = TriangleTruth::new(ray, vertices);
                let off = distance_to_triangle(point, vertices) / (POINT_BOUND * truth.reach);
                (truth.margin, truth.surely_missed(), truth.surely_hit(), off)
            }
            Primitive::Sphere { center, radius, .. } => {
                let truth = SphereTruth::new(ray, center, radius);
                let off = ((point - center.as_dvec3()).length() - f64::from(radius)).abs();
                let parts = off / (SHELL_BOUND * truth.reach);
                (truth.margin, truth.surely_missed(), truth.surely_hit(), parts)
            }
        };
        if missed {
            return Err(Wrong::Missed { margin });
        }
        if off > 1.0 {
            return Err(Wrong::Off { parts: off });
        }
        Ok(!sure)
    }
}

/// The first hit of a primitive that the ray surely accepts; an error if that is not sure.
fn first_sure(ray: &Ray, primitive: &Primitive) -> Result<Option<Range>, ()> {
    let (t_min, t_max) = (f64::from(ray.t_min), f64::from(ray.t_max));
    let mut roots: [Option<Range>; 2] = [None, None];
    match *primitive {
        Primitive::Triangle { vertices, .. } => {
            let truth = TriangleTruth::new(ray, vertices);
            if truth.surely_missed() {
                return Ok(None);
            }
            if !truth.surely_hit() || !truth.t.is_finite() {
                return Err(());
            }
            roots[0] = Some(Range { t: truth.t, error: truth.t_error });
        }
        Primitive::Sphere { center, radius, .. } => {
            let truth = SphereTruth::new(ray, center, radius);
            if truth.surely_missed() {
                return Ok(None);
            }
            if !truth.surely_hit() {
                return Err(());
            }
            // Off the sphere by the bound, along a ray that crosses it at this slope.
            let length = ray.direction.as_dvec3().length();
            let off = SHELL_BOUND * truth.reach;
            let half = (truth.t[1] - truth.t[0]) * 0.5 * length;
            let error = off * f64::from(radius) / half.max(off) / length + off / length;
            roots = truth.t.map(|t| Some(Range { t, error }));
        }
    }
    for root in roots.into_iter().flatten() {
        let (lo, hi) = (root.t - root.error, root.t + root.error);
        if lo >= t_min && hi <= t_max {
            return Ok(Some(root));
        }
        if hi >= t_min && lo <= t_max {
            return Err(());
        }
    }
    Ok(None)
}
