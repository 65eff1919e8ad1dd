//! The tables of a scene: plain data that a file holds once and every node keeps, read-only.

mod frame;
mod light;
#[cfg(feature = "many-lights")]
mod light_node;
mod material;
mod needs;
mod view;

pub use frame::Frame;
pub use light::{Light, LightKind};
#[cfg(feature = "many-lights")]
pub use light_node::LightNode;
pub use material::{Material, MaterialKind};
pub use needs::Needs;
pub use view::{View, ViewKind};
