//! Pictures of linear radiance: how they are shown, and written.

mod hash;
mod read;
mod tone;
mod write;

pub(crate) use hash::hash;
pub(crate) use read::{Read, read};
pub(crate) use tone::{auto_exposure, tone_mapped};
pub(crate) use write::{Format, Saved, png_bytes, save};

pub(crate) use kiloray_render::Picture;

/// Luminance by Radiance's primaries, as its tools and ours weigh them.
pub(crate) fn luminance([r, g, b]: [f32; 3]) -> f64 {
    0.265 * f64::from(r) + 0.670 * f64::from(g) + 0.065 * f64::from(b)
}
