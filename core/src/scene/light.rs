use crate::real::Real;
use bytemuck::{Pod, Zeroable};

/// The shape of a light.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u32)]
pub enum LightKind {
    /// `position + a * u + b * v`, `a, b` in [0, 1]; emits to the side of `u × v`.
    Parallelogram = 0,
    /// `position + a * u + b * v`, `a, b >= 0`, `a + b <= 1`; emits to the side of `u × v`.
    Triangle = 1,
    /// `position + a * u + b * v`, `a² + b² <= 1`, with `u` and `v` orthogonal radii; emits to the side of `u × v`.
    Disc = 2,
    /// Centre `position`, radius `u.x`; emits outward.
    Sphere = 3,
    /// A point; `radiance` is its intensity [W/sr, in scene units].
    Point = 4,
    /// A point that shines within a cone round `u` (unit), of half angle `acos(v.x)`.
    Spot = 5,
    /// Infinitely far: the directions within the half angle `acos(v.x)` of `u` (unit, towards the
    /// light). A small one is a sun, one of half angle π is a sky all around. `v.y` is `1 - v.x`, computed in f64 (a sun's
    /// cosine is too near 1 for f32); 0 stands for the difference in f32.
    Distant = 6,
}

impl LightKind {
    /// The kind with this number.
    #[must_use]
    pub const fn from_u32(kind: u32) -> Option<Self> {
        Some(match kind {
            0 => Self::Parallelogram,
            1 => Self::Triangle,
            2 => Self::Disc,
            3 => Self::Sphere,
            4 => Self::Point,
            5 => Self::Spot,
            6 => Self::Distant,
            _ => return None,
        })
    }
}

/// An entry of the light table: what direct lighting samples.
///
/// The visible surface of an area light is in the blocks as well, with a material that emits. The table is in the order of
/// `material`, lights without one last ([`Material::light`](super::Material::light)).
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Light {
    /// A [`LightKind`].
    pub kind: u32,
    /// Index of the material of its visible surface; `u32::MAX` where it has none.
    pub material: u32,
    /// Greatest distance at which it lights a surface [scene units]; infinity as a rule (Radiance's glow has a limit).
    pub reach: f32,
    /// Corner, centre or place.
    pub position: [f32; 3],
    /// See [`LightKind`].
    pub u: [f32; 3],
    /// See [`LightKind`].
    pub v: [f32; 3],
    /// Radiance [W / (m² sr)], or intensity for points and spots.
    pub radiance: [f32; 3],
    /// Cosine bounds of a spotlight that covers an area: an area light emits only within the half angle
    /// `acos(cone_cos)` of `cone`; -1 for no limit.
    pub cone_cos: f32,
    /// Unit axis of that cone.
    pub cone: [f32; 3],
    /// The focal length of a spotlight [scene units]: at distance `d` it brings as much as from `d + focus`, which is the part
    /// `(d / (d + focus))²` of its light; 0 for none.
    pub focus: f32,
}

impl Light {
    /// The part of its light that one of this focal length brings over a distance; all without one.
    #[inline(always)]
    #[must_use]
    pub fn focal_part<R: Real>(focus: f32, distance: R) -> R {
        if focus <= 0.0 {
            return distance.same(1.0);
        }
        let part = distance / (distance + focus);
        part * part
    }
}

const _: () = assert!(size_of::<Light>() == 80);
