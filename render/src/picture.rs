use crate::PictureError;
use kiloray_core::render::{Job, Tile};
use kiloray_core::scene::View;
use kiloray_core::shade::Sum;
use kiloray_core::view::Camera;

/// Linear radiance, row by row from the top.
#[derive(Debug, Clone, PartialEq)]
pub struct Picture {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Red, green and blue [W / (m² sr)].
    pub pixels: Vec<[f32; 3]>,
}

impl Picture {
    /// A black picture.
    pub(crate) fn new(width: u32, height: u32) -> Result<Self, PictureError> {
        Ok(Self { width, height, pixels: filled(width, height, [0.0; 3])? })
    }

    /// Enters the mean light of those of a tile's pixels that a job renders. Returns how many sums were too great to count.
    pub(crate) fn enter(&mut self, tile: Tile, sums: &[Sum], job: &Job<'_>) -> u64 {
        let (unit, samples) = (job.shader.unit(), job.shader.settings().samples);
        let mut full = 0;
        for (row, sums) in sums.chunks(tile.width as usize).enumerate() {
            let begin = (tile.y as usize + row) * self.width as usize + tile.x as usize;
            let row = begin..begin + sums.len();
            let enter = |(pixel, sum): (&mut [f32; 3], &Sum)| {
                *pixel = unit.resolve(*sum, samples).to_array();
                full += u64::from(sum.is_full());
            };
            let pixels = self.pixels[row.clone()].iter_mut().zip(sums);
            match job.only {
                None => pixels.for_each(enter),
                Some(only) => {
                    let some = pixels.zip(&only[row]).filter(|(_, is_rendered)| **is_rendered);
                    some.map(|(pixel, _)| pixel).for_each(enter);
                }
            }
        }
        full
    }
}

/// The camera of a picture of a view, with so many camera paths a pixel.
///
/// # Errors
/// [`PictureError`] if there is no such picture.
pub fn camera(view: &View, width: u32, height: u32, samples: u32) -> Result<Camera, PictureError> {
    pixels(width, height)?;
    Camera::new(view, width, height, samples).ok_or(PictureError::View)
}

/// The same value for each pixel of a picture, row by row.
///
/// # Errors
/// [`PictureError`] if there is no such picture.
pub fn filled<T: Clone>(width: u32, height: u32, value: T) -> Result<Vec<T>, PictureError> {
    let len = pixels(width, height)? as usize;
    let mut all = Vec::new();
    all.try_reserve_exact(len).map_err(|_| PictureError::Size { width, height })?;
    all.resize(len, value);
    Ok(all)
}

/// How many pixels a picture has.
fn pixels(width: u32, height: u32) -> Result<u32, PictureError> {
    let pixels = width.checked_mul(height).filter(|&pixels| pixels > 0);
    pixels.ok_or(PictureError::Size { width, height })
}
