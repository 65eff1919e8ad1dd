//! Rays, boxes, triangles and spheres, and the bounds of their rounding.
//!
//! All coordinates are *scene coordinates*: the compiler moves the scene's centre to the origin and
//! scales it by a power of two so that it fits the cube [-1, 1]³ (see [`crate::scene::Frame`]).
//!
//! # What a hit is
//!
//! The hit of a ray does not depend on boxes, blocks, lanes or order. Its definition, in the steps of `ARCHITECTURE.md`:
//! 1 the prepared direction, [`PreparedRay::new`]; 2 the primitive's own test, [`PreparedRay::triangle`] and
//! [`PreparedRay::sphere`]; 3 the padded own box, [`PreparedRay::own_box`]; 4 `t` clamped to it and held
//! against the ray's bounds, [`PreparedRay::accept`]; 5 the order of hits, [`Hit::is_closer_than`].
//! These are the functions that all others must reproduce bit for bit.

mod aabb;
mod order;
mod prepared;
mod pyramid;
mod ray;
pub mod rounding;
mod spawn;
mod sphere;
#[cfg(test)]
mod tests;
mod triangle;

pub use aabb::Aabb;
pub use prepared::{Interval, PreparedRay};
pub use pyramid::{Planes, Pyramid, Side};
pub use ray::{Hit, Primitive, Ray};
pub(crate) use spawn::Base;
pub use spawn::{SurfacePoint, Target};
pub use sphere::{SphereRoots, sphere_roots};
pub use triangle::{DET_MAX, DET_MIN, DET_PART, TriangleHit};
