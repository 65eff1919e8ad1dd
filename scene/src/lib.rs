//! From an input to blocks: importers, built-in scenes, and the compiler.
//!
//! [`model`] is what every importer and built-in scene makes, and what the compiler takes.

pub mod builtin;
pub mod compile;
pub mod import;
pub mod kilo;
pub mod model;
pub mod needs;
pub mod regular;
