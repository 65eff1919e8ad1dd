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

/// Reads a picture as linear RGB: `.exr`, `.hdr` and `.pic`, or `.png`, which is taken as sRGB.
pub(crate) fn read(path: &Path) -> Outcome<Picture> {
    let bytes = input::read(path, BYTES_MAX)?;
    kiloray_picture::read(&bytes, PIXELS_MAX).map_err(|error| Failure::file(path, error))
}
