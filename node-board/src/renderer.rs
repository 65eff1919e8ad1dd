//! The picture by the renderer: one node that owns all blocks, and no mesh.

use kiloray_core::block::KiloView;
use kiloray_core::render::{Job, Plan, PlanSettings, Renderer, SceneSize, Sight, Tiling};
use kiloray_core::scene::Needs;
use kiloray_core::shade::Counts;
use kiloray_core::store::{Arena, Chunk};
use kiloray_core::trace::Scalar;

use crate::picture::{Done, PictureError, Pixels, SIZE, camera, shader};

/// What it takes beside the arena.
#[cfg(target_os = "none")]
pub(crate) const BESIDE_BYTES: usize = 0;

/// Renders in the arena and writes the pixels.
pub(crate) fn render(
    file: &KiloView<'_>,
    memory: &mut [Chunk],
    pixels: &mut Pixels,
) -> Result<Done, PictureError> {
    let job =
        Job { shader: shader(file), camera: camera(file)?, width: SIZE, only: None, cancel: None };
    let settings = job.shader.settings();
    let size = SceneSize {
        block_bytes: file.header().block_bytes as usize,
        blocks: file.blocks() as usize,
        specular: file.needs().bits & Needs::SPECULAR != 0,
    };
    let wanted = PlanSettings { bounces: settings.bounces, in_place: true, batch_max: 0 };
    let bytes = size_of_val(memory);
    let plan = Plan::new(bytes, &size, &wanted).map_err(PictureError::Memory)?;
    let mut budget = plan.budget(bytes).map_err(PictureError::Memory)?;
    let mut renderer =
        Renderer::new(&mut Arena::new(memory), &plan).map_err(PictureError::Arena)?;

    let mut sight = Sight::new(Scalar, *file);
    let mut counts = Counts::default();
    let tiling = Tiling::new(SIZE, SIZE, plan.side as u32);
    for tile in (0..tiling.len()).filter_map(|index| tiling.tile(index)) {
        let sums = renderer.tile(&job, tile, &mut sight, &mut counts);
        let sums = sums.map_err(|_| PictureError::Render("a tile failed"))?;
        for (row, y) in sums.chunks(tile.width as usize).zip(tile.y..) {
            for (sum, x) in row.iter().zip(tile.x..) {
                if let Some(pixel) = pixels.get_mut((y * SIZE + x) as usize) {
                    *pixel = job.shader.unit().resolve(*sum, settings.samples).to_array();
                }
            }
        }
    }
    renderer.note_peaks(&mut budget);
    Ok(Done { counts, budget })
}
