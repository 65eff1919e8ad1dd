use std::{
    fs,
    io::{self, Cursor},
    path::Path,
};

use image::{DynamicImage, ImageDecoder, Limits, codecs::png};

use super::{Picture, exr_file, rgbe, tone::decode_srgb};
use crate::failure::{Failure, Outcome};

/// Greatest picture that is read [bytes, decoded].
const BYTES_MAX: u64 = 4 << 30;

/// Reads a picture as linear RGB: `.exr`, `.hdr` and `.pic`, or `.png`, which is taken as sRGB.
pub(crate) fn read(path: &Path) -> Outcome<Picture> {
    let bytes = fs::read(path).map_err(|error| Failure::io(path, &error))?;
    // By content: a name may lie.
    let picture = if bytes.starts_with(&[0x76, 0x2f, 0x31, 0x01]) {
        exr_file::read(&bytes)
    } else if bytes.starts_with(b"#?") {
        rgbe::read(Cursor::new(&bytes)).map_err(|error| error.to_string())
    } else if bytes.starts_with(b"\x89PNG") {
        read_png(&bytes).map_err(|error| error.to_string())
    } else {
        return Err(Failure::file(path, "is no picture that can be read; give .exr, .hdr or .png"));
    };
    picture.map_err(|cause| Failure::file(path, format!("the picture is damaged: {cause}")))
}

fn read_png(bytes: &[u8]) -> image::ImageResult<Picture> {
    let mut limits = Limits::default();
    limits.max_alloc = Some(BYTES_MAX);
    let decoder = png::PngDecoder::with_limits(Cursor::new(bytes), limits)?;
    buffer(decoder.total_bytes().saturating_mul(4))?;
    let image = DynamicImage::from_decoder(decoder)?.into_rgb16();
    let linear = |c: u16| decode_srgb(f64::from(c) / 65_535.0) as f32;
    Ok(Picture {
        width: image.width(),
        height: image.height(),
        pixels: image.pixels().map(|p| p.0.map(linear)).collect(),
    })
}

/// A buffer for a picture that claims to be this large.
pub(super) fn buffer(bytes: u64) -> image::ImageResult<Vec<u8>> {
    let mut buffer = Vec::new();
    let refused = || io::Error::other(format!("it claims to have {bytes} bytes of pixels"));
    let len = usize::try_from(bytes).ok().filter(|_| bytes <= BYTES_MAX).ok_or_else(refused)?;
    buffer.try_reserve_exact(len).map_err(|_| refused())?;
    buffer.resize(len, 0);
    Ok(buffer)
}
