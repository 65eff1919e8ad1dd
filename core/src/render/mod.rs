//! A picture on one node: tiles of pixels, rendered inside one arena.
//!
//! | part | what it is |
//! | --- | --- |
//! | [`Tiling`], [`Tile`] | the picture in tiles, and the order of work in one |
//! | [`Plan`] | how the node's memory is divided |
//! | [`Renderer`] | the wavefront: rays of a tile in batches, from the camera to the lights |
//!
//! # How a tile is rendered
//!
//! 1. A *batch* of rays is traced: the deepest of those that wait, or new camera rays.
//! 2. What each ray hit is shaded at once. Emitted light goes to the pixel's sum, specular children wait,
//!    shadow rays queue up.
//! 3. When the queue of shadow rays is full, or the tile is at its end, it is sorted by light and traced in bundles;
//!    what is not hidden goes to the sums.
//!
//! Nothing waits for an answer: each ray carries the part of its light that reaches its pixel, and sums are integers
//! ([`crate::shade`]). So the sizes of batches, queues, tiles and caches decide about time and never about pixels.
//!
//! # Why it ends in any memory
//!
//! A point has at most two children, and only the first [`SPLITS`](crate::shade::SPLITS) bounces of a path have more than one. The stack of waiting rays
//! keeps a place in reserve for each bounce that may still split: a ray of depth `d` comes to lie no higher than
//! `capacity - reserve(d - 1)`, so when it is on top its own children fit. That is rule 7 of the mesh ("a point at bounce d
//! takes a slot only if one stays for each deeper bounce") for a stack. Batches shrink as the stack fills, down to a single ray.

#[cfg(not(feature = "bundles"))]
mod alone;
mod clear;
mod clearing;
#[cfg(feature = "bundles")]
mod neighbours;
mod plan;
mod renderer;
mod scratch;
mod shuffle;
mod sight;
mod sort;
mod stack;
mod tile;
#[cfg(feature = "bundles")]
mod together;
mod trust;

pub(crate) use clear::is_clear;
pub(crate) use clearing::Clearings;
#[cfg(feature = "bundles")]
pub use neighbours::Neighbours;
pub use plan::{Plan, PlanSettings, SceneSize};
pub use renderer::{Job, RenderError, Renderer};
pub use scratch::Scratch;
pub use sight::Sight;
pub(crate) use sort::sort_by_key;
#[cfg(feature = "bundles")]
pub(crate) use sort::sort_large_by_key;
pub(crate) use tile::Places;
pub use tile::{Tile, Tiling};
pub(crate) use trust::Trust;
