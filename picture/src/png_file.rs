//! PNG: for the eye.

use std::io::{self, Cursor, Write};

use image::{DynamicImage, ExtendedColorType, ImageDecoder, ImageEncoder, Limits, codecs::png};

use super::{
    Picture,
    read::{Error, black, in_io},
    srgb::decode,
};

/// Bytes of a pixel of any PNG, at most.
const PIXEL_BYTES: u64 = 8;

/// Writes 8-bit RGB.
///
/// # Errors
/// Those of `out`.
pub fn write(width: u32, height: u32, rgb: &[u8], out: &mut dyn Write) -> io::Result<()> {
    png::PngEncoder::new_with_quality(out, png::CompressionType::Default, png::FilterType::Adaptive)
        .write_image(rgb, width, height, ExtendedColorType::Rgb8)
        .map_err(in_io)
}

/// Reads any PNG, which is taken as sRGB; transparency is left out.
pub(crate) fn read(bytes: &[u8], pixels_max: u64) -> Result<Picture, Error> {
    let damaged = |error: image::ImageError| Error::Damaged(error.to_string());
    let mut limits = Limits::default();
    limits.max_alloc = Some(pixels_max.saturating_mul(PIXEL_BYTES));
    let decoder = png::PngDecoder::with_limits(Cursor::new(bytes), limits).map_err(damaged)?;
    let (width, height) = decoder.dimensions();
    let mut picture = black(width, height, pixels_max)?;
    let image = DynamicImage::from_decoder(decoder).map_err(damaged)?.into_rgb16();
    let linear = |c: u16| decode(f64::from(c) / 65_535.0) as f32;
    for (to, from) in picture.pixels.iter_mut().zip(image.pixels()) {
        *to = from.0.map(linear);
    }
    Ok(picture)
}
