//! From a [`Model`](crate::model::Model) to blocks.
//!
//! The stages, in order; each is a file:
//!
//! | stage | what it does |
//! | --- | --- |
//! | `frame` | moves the scene's centre to the origin and scales it into [-1, 1]³ |
//! | `lights` | lights that light nothing are left out; each gets a material of its own |
//! | `tables` | materials, lights and views in scene units; what is not used is left out |
//! | `light_tree` | a tree of very many lights |
//! | `surfaces` | rounds vertices to f32, merges equal ones, boxes the primitives |
//! | `binary`, `split` | the primitives in halves and halves again, by planes chosen with the surface-area heuristic |
//! | `build` | the tree: nodes of eight children, made of the halves at the least cost |
//! | `fit` | leaves pushed down where a node would not fit a block |
//! | `cut` | the tree in treelets that fit a block (Aila & Karras 2010) |
//! | `pack`, `layout` | treelets into blocks, and every vertex to its place |
//! | `order` | the blocks of the top of the tree get the first numbers |
//! | `emit` | the bytes of each block |
//!
//! Sizes that grow with the scene are 32 bits wide. The result is a function of the model and the
//! [`Options`] alone: the same bytes on every machine, with any number of threads.

mod binary;
mod bounds;
mod build;
mod compiled;
mod cut;
mod emit;
mod fit;
mod frame;
mod layout;
mod light_tree;
mod lights;
mod options;
mod order;
mod pack;
mod pipeline;
mod split;
mod stats;
mod surfaces;
mod tables;
#[cfg(test)]
mod tests;
mod tree;

pub use compiled::Compiled;
pub use lights::Dark;
pub use options::{CompileError, Options, Progress, Stage};
pub use pipeline::compile;
pub use stats::Stats;
pub(crate) use surfaces::Surfaces;
pub use tables::view_in;
