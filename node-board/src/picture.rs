//! The picture of the file's first view, as all machines take it.

use core::fmt;

use kiloray_core::block::KiloView;
use kiloray_core::shade::{Settings, Shader, Tables};
use kiloray_core::store::{ArenaFull, Budget, BudgetError};
use kiloray_core::view::Camera;

/// Width and height [pixels].
pub(crate) const SIZE: u32 = 32;

/// Linear radiance, rows from the top.
pub(crate) type Pixels = [[f32; 3]; (SIZE * SIZE) as usize];

/// Room for the pixels.
pub(crate) const BLACK: Pixels = [[0.0; 3]; (SIZE * SIZE) as usize];

/// What came of rendering.
#[derive(Debug)]
pub(crate) struct Done {
    /// What was traced.
    pub(crate) counts: kiloray_core::shade::Counts,
    /// How the arena was used.
    pub(crate) budget: Budget,
}

/// Why there is no picture.
#[derive(Debug, Clone, Copy)]
pub(crate) enum PictureError {
    /// The file has no view that shows anything.
    View,
    /// The arena is too small.
    Memory(BudgetError),
    /// The arena is not what was planned.
    Arena(ArenaFull),
    /// Rendering failed.
    Render(&'static str),
}

/// The camera of the file's first view.
pub(crate) fn camera(file: &KiloView<'_>) -> Result<Camera, PictureError> {
    let view = file.views().first().ok_or(PictureError::View)?;
    Camera::new(view, SIZE, SIZE, SAMPLES).ok_or(PictureError::View)
}

/// Camera paths per pixel.
const SAMPLES: u32 = 4;

/// The file's light and materials.
pub(crate) fn shader<'a>(file: &KiloView<'a>) -> Shader<'a> {
    let settings = Settings { samples: SAMPLES, ..Settings::default() };
    Shader::new(Tables::of(file), settings)
}

/// The hash of a picture, as `kiloray render --json` gives it: BLAKE3 of the pixels as 32-bit
/// little-endian floats.
///
/// Not inlined, as the hasher would lie on the stack of rendering.
#[inline(never)]
pub(crate) fn hash(pixels: &Pixels) -> impl fmt::Display {
    let mut hasher = blake3::Hasher::new();
    for x in pixels.as_flattened() {
        hasher.update(&x.to_le_bytes());
    }
    hasher.finalize().to_hex()
}

impl fmt::Display for PictureError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::View => f.write_str("the scene has no view that shows anything"),
            Self::Memory(error) => error.fmt(f),
            Self::Arena(error) => error.fmt(f),
            Self::Render(error) => f.write_str(error),
        }
    }
}
