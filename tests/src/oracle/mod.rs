//! Brute force in f64, and how far the truth is from a border: what `core` finds is held against it.
//!
//! # The bounds
//!
//! `u = 2⁻²⁴`. A ray is given by its f32 numbers, taken as exact. `R` is the greatest distance along an axis between its
//! origin and the primitive's own box. f64 errs by some `2⁻⁵⁰ R`, which is nothing beside the bounds.
//!
//! **Triangle, hit or miss.** Seen along the ray, on a plane across the axis of its greatest component, the triangle is a
//! triangle of the plane and the ray is a point. The reference test decides exactly for vertices that it has moved by at most
//! `6 u R` along both axes of the plane (six roundings: the two differences, the slope, its product, and the sum of up to `2 R`). So it may differ from the
//! truth only where the point is within `6√2 u R` of the border: [`EDGE_BOUND`].
//!
//! **Triangle, `t`.** The point at `t` lies within `64 u R` of the exact triangle, [`POINT_BOUND`]: it is at most `6√2 u R` away from a point
//! of it across, and `32 u R` times the direction's length in units of its greatest component (`√3` at most) along the ray
//! (derived at `PreparedRay::triangle`). Clamping to the own box keeps that: it moves `t` towards the `t` of that point,
//! and the distance from a convex set is convex along the ray.
//!
//! **Sphere, hit or miss.** The test works in f64: it may differ only where the line passes the sphere's rim within `2⁻⁴⁵ R`, [`RIM_BOUND`].
//!
//! **Sphere, `t`.** Its only f32 rounding is the last: the point at `t` lies within `2 u R` of the sphere, [`SHELL_BOUND`], also after clamping, which moves
//! it towards the root.

mod judge;
mod sphere;
mod triangle;

pub use judge::{Scene, Verdict, Wrong};
pub use sphere::SphereTruth;
pub use triangle::{TriangleTruth, distance_to_triangle};

/// The unit roundoff of f32.
pub const U: f64 = 1.0 / (1 << 24) as f64;
/// How near to a triangle's border, in parts of `R`, hit and miss may be taken for each other: `6√2 u`, and what f64 errs.
pub const EDGE_BOUND: f64 = 8.5 * U;
/// How far from a triangle, in parts of `R`, the point of a hit may lie.
pub const POINT_BOUND: f64 = 64.0 * U;
/// How near to a sphere's rim, in parts of `R`, hit and miss may be taken for each other.
pub const RIM_BOUND: f64 = 1.0 / (1_u64 << 45) as f64;
/// How far from a sphere, in parts of `R`, the point of a hit may lie.
pub const SHELL_BOUND: f64 = 2.0 * U;
