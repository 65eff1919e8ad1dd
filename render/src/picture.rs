use kiloray_core::render::Tile;
use kiloray_core::shade::{Sum, Unit};

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
    /// A black picture; `None` if so many pixels cannot be.
    pub(crate) fn new(width: u32, height: u32) -> Option<Self> {
        let len = (width as usize).checked_mul(height as usize).filter(|&len| len > 0)?;
        let mut pixels = Vec::new();
        pixels.try_reserve_exact(len).ok()?;
        pixels.resize(len, [0.0; 3]);
        Some(Self { width, height, pixels })
    }

    /// Enters the mean light of a tile's pixels. Returns how many sums were too great to count.
    pub(crate) fn enter(&mut self, tile: Tile, sums: &[Sum], unit: Unit, samples: u32) -> u64 {
        let mut full = 0;
        for (row, sums) in sums.chunks(tile.width as usize).enumerate() {
            let at = (tile.y as usize + row) * self.width as usize + tile.x as usize;
            for (pixel, sum) in self.pixels[at..].iter_mut().zip(sums) {
                *pixel = unit.resolve(*sum, samples).to_array();
                full += u64::from(sum.is_full());
            }
        }
        full
    }
}
