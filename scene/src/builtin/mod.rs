//! Built-in scenes, by name and size: `cornell`, `sinc:512`, `sphereflake:4`.
//!
//! Scenes of a few triangles and of millions, each with its lights and a view, made by arithmetic
//! alone: the same name gives the same scene on every machine. Lengths are in metres, z is up
//! unless the scene says otherwise. [`list`] is the catalogue, [`build`] makes a scene.

mod catalogue;
mod clutter;
mod colour_cube;
mod conference;
mod cornell;
mod furnace;
mod glass;
mod random;
mod revolve;
mod shape;
mod sinc;
mod sphereflake;
mod studio;

pub use catalogue::{BuiltinError, Entry, Size, build, find, list};

#[cfg(test)]
mod tests;
