//! `.kilo` files: made, written, mapped and checked. Their layout is
//! [`kiloray_core::block::format`].

mod file;
mod image;
mod share;
#[cfg(test)]
mod tests;
mod tree;
mod write;

pub use file::{KiloError, KiloFile};
pub use image::{Image, Tables};
pub use share::share;
