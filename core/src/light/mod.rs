//! Lights as seen from a point, and samples of them.
//!
//! [`Aim::new`] looks at a light from one point, or says why it cannot light it; [`Aim::sample`] takes two numbers
//! to a direction, with the radiance from there and one over its density in solid angle. How a light is sampled:
//!
//! | light | where it looks large | elsewhere |
//! | --- | --- | --- |
//! | rectangle | uniform solid angle (Ureña, Fajardo, King 2013) | uniform area |
//! | disc | the ellipse of directions (after Guillén et al. 2017) | uniform area |
//! | triangle | uniform solid angle (Arvo 1995) | uniform area |
//! | other parallelogram | uniform area | uniform area |
//! | sphere | the cone of visible directions | the same |
//! | distant | cosine-weighted hemisphere, those outside the light are lost | uniform solid angle |
//! | point, spot | the point | the point |
//!
//! All maps are continuous in both numbers, so that they keep the evenness of a low-discrepancy sequence.

mod aim;
#[cfg(feature = "many-lights")]
mod cluster;
mod distant;
mod ellipse;
mod far;
mod flat;
#[cfg(feature = "bundles")]
mod lamp;
mod locate;
mod plane;
mod projected;
mod rectangle;
mod sphere;
mod triangle;

pub use aim::{Aim, Dark, MOST, Sample};
pub(crate) use distant::versine;
#[cfg(feature = "bundles")]
pub(crate) use far::{Far, FarRows};
pub(crate) use far::{Look, Seen};
#[cfg(feature = "bundles")]
pub(crate) use lamp::Lamps;
#[cfg(feature = "bundles")]
pub(crate) use plane::{Glance, GlanceRows, Plane};
