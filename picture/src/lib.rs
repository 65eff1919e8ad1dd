//! Files of pictures, as bytes: OpenEXR and Radiance's RGBE, which hold linear radiance, and PNG.

mod exr_file;
mod png_file;
mod read;
mod rgbe;
mod srgb;

pub use exr_file::write as write_exr;
pub use kiloray_render::Picture;
pub use png_file::write as write_png;
pub use read::{Error, is_png, read};
pub use rgbe::write as write_hdr;
pub use srgb::{decode as decode_srgb, encode as encode_srgb};
