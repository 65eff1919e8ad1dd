//! Ray tracing in fixed memory.
//!
//! The part of Kiloray that every host shares: a PC, a process of a mesh, a simulated node and a
//! Cortex-M run these very functions, and get the same bits. Nothing here allocates, blocks, reads
//! a clock or panics; memory, time and random keys come in as arguments.
//!
//! Modules, lowest first; each knows only those above it in this list, but that [`geometry`] takes a function of angles from
//! [`light`], [`shade`] the arena of [`store`], and [`network`] the reader of a packet from [`protocol`]:
//!
//! | module | what it holds |
//! | --- | --- |
//! | [`real`] | numbers of one sample, or of as many at once as a vector holds |
//! | [`scene`] | the tables of a scene: materials, lights, views |
//! | [`geometry`] | rays, boxes, triangles, spheres, pyramids, and the bounds of their rounding |
//! | [`block`] | a piece of the tree in bytes, the file that holds them, and their checked reader |
//! | [`trace`] | closest hit and any hit over blocks: single rays, batches, bundles |
//! | [`path`] | names of paths |
//! | [`random`] | low-discrepancy numbers as functions of those names |
//! | [`view`] | from pixels to rays |
//! | [`material`] | what surfaces do with light |
//! | [`light`] | lights as seen from a point, and samples of them |
//! | [`shade`] | the rendering equation: what a ray brings, and which rays follow it |
//! | [`store`] | a node's memory: arena, budget, block cache and queues |
//! | [`network`] | topologies and their routes, credits of links |
//! | [`protocol`] | what nodes say to each other |
//! | [`render`] | a picture on one node: tiles of pixels, rendered inside one arena |
//! | [`node`] | the actor: a node of a mesh in one arena |
#![cfg_attr(not(test), no_std)]
#![forbid(unsafe_code)]
#![cfg_attr(
    not(test),
    warn(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::indexing_slicing)
)]

pub mod block;
mod elementary;
pub mod geometry;
pub mod light;
pub mod material;
pub mod network;
pub mod node;
pub mod path;
pub mod protocol;
pub mod random;
pub mod real;
pub mod render;
pub mod scene;
pub mod shade;
pub mod store;
mod tally;
#[cfg(test)]
mod tests;
pub mod trace;
pub mod view;
