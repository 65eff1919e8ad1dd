//! Rays, boxes, triangles and spheres, and the bounds of their rounding.
//!
//! All coordinates are *scene coordinates*: the compiler moves the scene's centre to the origin and
//! scales it by a power of two so that it fits the cube [-1, 1]³ (see [`crate::scene::Frame`]).

mod ray;

pub use ray::{Hit, Primitive, Ray};
