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
//! # Light that is known without shadows
//!
//! What a lamp of simple shape brings to a diffuse surface is known in closed form ([`Aim::projected`](crate::light::Aim::projected)), as long as nothing
//! is in the way. A bundle of shadow rays then [deals out](Bundle::unshadowed) exactly that, each ray about the light that it would bring as a sample: so
//! what the samples of a lamp lack or exceed is no error where all of it is seen, and who knows that all of it is seen need not make the rays.
//! (Heitz, Hill, McGuire 2018, "Combining analytic direct illumination and stochastic shadows", weigh with the quotient of both instead.)
//!
//! # No light twice
//!
//! Diffuse surfaces see lights by shadow rays only, perfect mirrors and clear panes by specular rays only. A glossy lobe sees them by both, and each light is shared
//! between the two by the balance heuristic (Veach & Guibas 1995): a specular ray carries the density with which it was sent; where it
//! finds a light, the light's own density follows from the ray's origin, so neither side needs to know what the other did.

#[cfg(feature = "specular")]
mod children;
mod counts;
mod deal;
mod direct;
#[cfg(feature = "bundles")]
mod few;
#[cfg(feature = "bundles")]
mod glances;
mod memo;
mod packed;
mod path;
mod point;
#[cfg(feature = "bundles")]
mod rows;
mod settings;
mod shader;
mod shadows;
mod sum;
#[cfg(test)]
mod tests;
mod trace;
#[cfg(feature = "many-lights")]
mod tree;

#[cfg(feature = "specular")]
pub use children::Child;
pub use counts::Counts;
pub use direct::{Bundle, Direct, FEW_LIGHTS};
#[cfg(feature = "bundles")]
pub use few::FewRays;
#[cfg(feature = "bundles")]
pub(crate) use glances::Glances;
pub use memo::Memo;
pub use packed::{PackedHit, PathRay, Shadow, Task};
pub use path::Path;
pub use point::{Point, SPLITS};
#[cfg(feature = "bundles")]
pub use rows::LightRows;
pub use settings::Settings;
pub use shader::{Shader, Tables};
pub use shadows::{ShadowRay, ShadowRays};
pub use sum::{Sum, Unit};
pub use trace::{BATCH, Visibility};
