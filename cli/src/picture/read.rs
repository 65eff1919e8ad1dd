use std::path::Path;

use super::Picture;
use crate::{
    failure::{Failure, Outcome},
    input,
};

/// Most pixels of a picture: as many as one that is rendered can have.
const PIXELS_MAX: u64 = 1 << 28;
/// Greatest file: so many pixels in a format that does not compress them, and what stands before them.
const BYTES_MAX: u64 = PIXELS_MAX * 16;

/// A picture of a file.
pub(crate) struct Read {
    /// As linear RGB.
    pub(crate) picture: Picture,
    /// It was made for the eye.
    pub(crate) is_png: bool,
}

/// Reads a picture: `.exr`, `.hdr` and `.pic`, or `.png`, which is taken as sRGB.
pub(crate) fn read(path: &Path) -> Outcome<Read> {
    let bytes = input::read(path, BYTES_MAX)?;
    let picture = kiloray_picture::read(&bytes, PIXELS_MAX);
    let picture = picture.map_err(|error| Failure::file(path, error))?;
    Ok(Read { picture, is_png: kiloray_picture::is_png(&bytes) })
}
