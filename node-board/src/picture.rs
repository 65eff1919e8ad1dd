//! A picture of the file's first view, rendered in one arena, the blocks read in place.

use core::fmt;

use kiloray_core::block::{KiloView, NoBlock};
use kiloray_core::render::{
    Job, Plan, PlanSettings, RenderError, Renderer, SceneSize, Sight, Tiling,
};
use kiloray_core::scene::Needs;
use kiloray_core::shade::{Counts, Settings, Shader, Tables};
use kiloray_core::store::{Arena, ArenaFull, Budget, BudgetError, Chunk};
use kiloray_core::trace::Scalar;
use kiloray_core::view::Camera;

/// Width and height [pixels].
pub(crate) const SIZE: u32 = 32;

/// Linear radiance, rows from the top.
pub(crate) type Pixels = [[f32; 3]; (SIZE * SIZE) as usize];

/// Room for the pixels.
pub(crate) const BLACK: Pixels = [[0.0; 3]; (SIZE * SIZE) as usize];

/// Why there is no picture.
#[derive(Debug)]
pub(crate) enum PictureError {
    /// The file has no view that shows anything.
    View,
    /// The arena is too small.
    Memory(BudgetError),
    /// The arena is not what was planned.
    Arena(ArenaFull),
    /// A tile failed.
    Render(RenderError<NoBlock>),
}

/// Renders in the arena and writes the pixels; says what was traced, and how the memory was used.
pub(crate) fn render(
    file: &KiloView<'_>,
    memory: &mut [Chunk],
    pixels: &mut Pixels,
) -> Result<(Counts, Budget), PictureError> {
    let needs = *file.needs();
    let settings = Settings { samples: 4, ..Settings::default() };
    let size = SceneSize {
        block_bytes: file.header().block_bytes as usize,
        blocks: file.blocks() as usize,
        specular: needs.bits & Needs::SPECULAR != 0,
    };
    let wanted = PlanSettings { bounces: settings.bounces, in_place: true, batch_max: 0 };
    let bytes = memory.len() * size_of::<Chunk>();
    let plan = Plan::new(bytes, &size, &wanted).map_err(PictureError::Memory)?;
    let mut budget = plan.budget(bytes).map_err(PictureError::Memory)?;
    let mut renderer =
        Renderer::new(&mut Arena::new(memory), &plan).map_err(PictureError::Arena)?;

    let view = file.views().first().ok_or(PictureError::View)?;
    let tables = Tables { materials: file.materials(), lights: file.lights(), needs };
    let job = Job {
        shader: Shader::new(tables, settings),
        camera: Camera::new(view, SIZE, SIZE).ok_or(PictureError::View)?,
        width: SIZE,
        cancel: None,
    };
    let mut sight = Sight::new(Scalar, *file);
    let mut counts = Counts::default();
    let tiling = Tiling::new(SIZE, SIZE, plan.side as u32);
    for tile in (0..tiling.len()).filter_map(|index| tiling.tile(index)) {
        let sums = renderer.tile(&job, tile, &mut sight, &mut counts);
        let sums = sums.map_err(PictureError::Render)?;
        for (row, y) in sums.chunks(tile.width as usize).zip(tile.y..) {
            for (sum, x) in row.iter().zip(tile.x..) {
                if let Some(pixel) = pixels.get_mut((y * SIZE + x) as usize) {
                    *pixel = job.shader.unit().resolve(*sum, settings.samples).to_array();
                }
            }
        }
    }
    renderer.note_peaks(&mut budget);
    Ok((counts, budget))
}

/// The hash of a picture, as `kiloray render --json` gives it: BLAKE3 of the pixels as 32-bit
/// little-endian floats.
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
            Self::Render(error) => error.fmt(f),
        }
    }
}
