//! The rendering equation for direct and specular light.
//!
//! A ray [arrives](Shader::arrive) with its [`Path`]: it brings emitted light, and makes a [`Point`] where the surface answers light. The
//! point sends [bundles](Shader::next_bundle) of [shadow rays](Shader::shadow_ray), and up to two specular
//! [children](Shader::children). All are functions of fixed-size values, so a ray and its path may travel, a point may
//! wait, and either may be made again; [`Shader::trace`] does all of it in place, and is the reference for what must come out.
//!
//! Every ray carries the part of its light that reaches the pixel, so what it brings is a [`Sum`] in the unit of the picture. Sums are integers: who adds
//! them, where and in what order, does not matter, and an answer can go to the parent, or past it to whoever waits for that.
//!
//! # No light twice
//!
//! Diffuse surfaces see lights by shadow rays only, perfect mirrors and clear panes by specular rays only. A glossy lobe sees them by both, and each light is shared
//! between the two by the balance heuristic (Veach & Guibas 1995): a specular ray carries the density with which it was sent; where it
//! finds a light, the light's own density follows from the ray's origin, so neither side needs to know what the other did.

#[cfg(feature = "specular")]
mod children;
mod counts;
mod direct;
mod packed;
mod path;
mod point;
mod settings;
mod shader;
mod sum;
#[cfg(test)]
mod tests;
mod trace;

#[cfg(feature = "specular")]
pub use children::Child;
pub use counts::Counts;
pub use direct::{Bundle, Direct, ShadowRay};
pub use packed::{PackedHit, PathRay, Shadow, Task};
pub use path::Path;
pub use point::{Point, SPLITS};
pub use settings::Settings;
pub use shader::{Shader, Tables};
pub use sum::{Sum, Unit};
pub use trace::{BATCH, Visibility};
