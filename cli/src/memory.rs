//! Memory of this machine: what is known to take much of it is refused before it is begun.

use std::fmt::Display;

use crate::{
    console::bytes,
    failure::{Failure, Outcome},
};

/// Bytes of a pixel: the picture, and what becomes of it on its way to a file.
const PIXEL_BYTES: u64 = 24;
/// Bytes of a surface while a scene is compiled.
const SURFACE_BYTES: u64 = 220;

/// Whether there is memory for a picture.
pub(crate) fn for_picture(width: u32, height: u32) -> Outcome {
    let pixels = u64::from(width) * u64::from(height);
    check(pixels * PIXEL_BYTES, format_args!("a picture of {width} x {height} pixels"), "pixels")
}

/// Whether there is memory to compile so many surfaces.
pub(crate) fn for_surfaces(surfaces: u64, name: &str) -> Outcome {
    check(surfaces.saturating_mul(SURFACE_BYTES), name, "surfaces")
}

/// Asks for so much, and gives it back.
fn check(need: u64, what: impl Display, of: &str) -> Outcome {
    let all = usize::try_from(need).ok();
    let had = all.is_some_and(|all| Vec::<u8>::new().try_reserve_exact(all).is_ok());
    if had {
        return Ok(());
    }
    Err(Failure::new(format_args!(
        "{what}: takes about {} of memory, more than can be had here; give it fewer {of}, or more memory",
        bytes(need)
    )))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_cannot_be_had_is_told() {
        assert_eq!(for_picture(64, 64), Ok(()));
        let refused = for_surfaces(u64::MAX / 1000, "huge").unwrap_err();
        let message = refused.message();
        assert!(message.starts_with("huge: takes about ") && message.contains("GiB"), "{message}");
        assert!(message.contains("fewer surfaces"), "{message}");
    }
}
