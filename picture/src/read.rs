use std::io;

use super::{Picture, exr_file, png_file, rgbe};

/// Greatest width or height.
const SIDE_MAX: u32 = 1 << 16;
/// Bytes of a pixel that decoders take beside the picture, at most.
const DECODER_BYTES: usize = 28;

/// Why there is no picture in a file.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// It begins like no file of pictures.
    #[error("is no picture that can be read; give .exr, .hdr or .png")]
    Unknown,
    /// It is not whole.
    #[error("the picture is damaged: {0}")]
    Damaged(String),
    /// It is larger than was allowed, or than the memory of this machine.
    #[error(
        "a picture of {width} x {height} pixels cannot be read: there is no room for it; make it smaller"
    )]
    Size {
        /// Columns.
        width: u32,
        /// Rows.
        height: u32,
    },
    /// A sound picture of a kind that is not read.
    #[error("{0}")]
    Kind(String),
}

/// Reads a picture as linear RGB: OpenEXR, Radiance's RGBE, or PNG, which is taken as sRGB. What it is shows its content: a name may lie.
///
/// # Errors
/// [`Error`]; one of more than `pixels_max` pixels is refused before there is memory for it.
pub fn read(bytes: &[u8], pixels_max: u64) -> Result<Picture, Error> {
    if bytes.starts_with(&[0x76, 0x2f, 0x31, 0x01]) {
        exr_file::read(bytes, pixels_max)
    } else if bytes.starts_with(b"#?") {
        rgbe::read(bytes, pixels_max)
    } else if is_png(bytes) {
        png_file::read(bytes, pixels_max)
    } else {
        Err(Error::Unknown)
    }
}

/// Whether a file begins as a PNG does: a picture for the eye, where the others hold radiance.
#[must_use]
pub fn is_png(bytes: &[u8]) -> bool {
    bytes.starts_with(b"\x89PNG")
}

/// A black picture, if it may be so large.
pub(crate) fn black(width: u32, height: u32, pixels_max: u64) -> Result<Picture, Error> {
    let pixels = u64::from(width) * u64::from(height);
    if pixels == 0 {
        return Err(Error::Damaged("it has no pixels".into()));
    }
    let refused = || Error::Size { width, height };
    let fits = pixels <= pixels_max && width.max(height) <= SIDE_MAX;
    let len = usize::try_from(pixels).ok().filter(|_| fits).ok_or_else(refused)?;
    let mut all = Vec::new();
    all.try_reserve_exact(len).map_err(|_| refused())?;
    // They do not ask.
    let besides = len.checked_mul(DECODER_BYTES).ok_or_else(refused)?;
    Vec::<u8>::new().try_reserve_exact(besides).map_err(|_| refused())?;
    all.resize(len, [0.0; 3]);
    Ok(Picture { width, height, pixels: all })
}

/// What the system said of a file that was written.
pub(crate) fn in_io(error: image::ImageError) -> io::Error {
    match error {
        image::ImageError::IoError(error) => error,
        other => io::Error::other(other),
    }
}
