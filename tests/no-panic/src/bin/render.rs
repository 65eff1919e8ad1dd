//! A tile of any picture, in any memory, from blocks of any bytes.
#![no_std]
#![no_main]

use core::hint::black_box;
use kiloray_core::block::KiloView;
use kiloray_core::path::PathKey;
use kiloray_core::render::{Job, Plan, PlanSettings, Renderer, SceneSize, Sight, Tiling};
use kiloray_core::shade::{Counts, Shader, Tables};
use kiloray_core::store::{Arena, BlockCache, Chunk, FetchedBlocks};
use kiloray_core::trace::Scalar;
use kiloray_core::view::Camera;
use kiloray_no_panic::{any, any_bytes, any_room, any_shading, entry, print};

#[inline(never)]
fn plan(memory: usize) -> Option<Plan> {
    let scene = SceneSize { block_bytes: any(), blocks: any(), specular: any::<u8>() == 0 };
    let wanted = PlanSettings { bounces: any(), in_place: any::<u8>() == 0, batch_max: any() };
    match Plan::new(memory, &scene, &wanted) {
        Ok(plan) => Some(plan),
        Err(error) => {
            print(&error);
            None
        }
    }
}

#[inline(never)]
fn draw(file: KiloView<'_>, memory: &mut [Chunk], plan: &Plan) {
    let settings = any_shading();
    let Some(camera) = file.views().first().and_then(|view| Camera::new(view, any(), any(), any()))
    else {
        return;
    };
    let job = Job {
        shader: Shader::new(Tables::of(&file), settings),
        camera,
        width: any(),
        only: black_box(None),
        cancel: None,
    };
    let mut arena = Arena::new(memory);
    let (Ok(mut renderer), Ok(cache)) = (
        Renderer::new(&mut arena, plan),
        BlockCache::new(&mut arena, plan.block_bytes, plan.frames),
    ) else {
        return;
    };
    let blocks = FetchedBlocks::new(cache, file, file.limits());
    let mut sight = Sight::new(Scalar, blocks);
    let mut counts = Counts::default();
    let tiling = Tiling::new(any(), any(), any());
    black_box(PathKey::camera(any(), any(), any()));
    for index in 0..tiling.len() {
        let Some(tile) = tiling.shuffled(index, any()) else { break };
        black_box(tiling.tile(index));
        match renderer.tile(&job, tile, &mut sight, &mut counts) {
            Ok(sums) => {
                for sum in sums {
                    black_box(job.shader.unit().resolve(*sum, any()));
                }
            }
            Err(error) => print(&error),
        }
    }
    if let Ok(mut budget) = plan.budget(any()) {
        renderer.note_peaks(&mut budget);
        black_box(budget);
    }
}

entry!({
    let mut memory = [Chunk::ZERO; 8];
    let memory = any_room(&mut memory);
    if let Some(plan) = plan(memory.len().wrapping_mul(64))
        && let Ok(file) = KiloView::parse(any_bytes())
    {
        draw(file, memory, &plan);
    }
});
