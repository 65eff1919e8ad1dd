//! Files that are read whole.

use std::path::Path;

use crate::failure::{Failure, Outcome};

/// The bytes of a regular file that has at most so many: a pipe or a device may have no end, or never begin.
pub(crate) fn read(path: &Path, bytes_max: u64) -> Outcome<Vec<u8>> {
    kiloray_scene::regular::read(path, bytes_max).map_err(|error| Failure::io(path, &error))
}
