//! What surfaces do with light.
//!
//! A [`Surface`] is the place that a ray hit; a [`Bsdf`] is what its material does there, seen along that ray. Light
//! sampling asks [`Bsdf::evaluate`]; specular children come from [`Bsdf::sample`]; shadow rays cross panes by
//! [`crossing`].

mod bsdf;
mod depth;
pub mod fresnel;
mod pass;
#[cfg(feature = "specular")]
mod passing;
mod surface;
#[cfg(feature = "bundles")]
mod surfaces;
mod ward;

#[cfg(feature = "specular")]
pub use bsdf::Gloss;
#[cfg(feature = "bundles")]
pub(crate) use bsdf::lambert;
pub use bsdf::{Bsdf, Response, Side};
pub use depth::OpticalDepth;
pub use pass::{crossing, passes_shadow_rays};
pub use surface::Surface;
pub(crate) use surface::{Anew, Surfacing};
#[cfg(feature = "bundles")]
pub(crate) use surfaces::{Made, Surfaces};
pub use ward::{ROUGHNESS_MIN, Ward, tangents};
