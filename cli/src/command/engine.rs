//! Where the command meets the renderer.

use std::sync::atomic::{AtomicBool, Ordering};

use kiloray_core::{
    scene::View,
    shade::Settings,
    store::{BudgetError, Line},
};
use kiloray_mesh::MeshOptions;
use kiloray_render::{Control, Error, Options, Rendered, framing};

use super::division;
use crate::{
    args::{BLOCK_MIN, Bounds, Common, size::typed},
    console::count,
    failure::{Failure, Outcome},
    memory,
    progress::Progress,
    scene::Scene,
};

/// Nobody sets it: an interrupt ends the command.
static CANCEL: AtomicBool = AtomicBool::new(false);

/// Size of a block of a node that is alone, where nothing is said: small for small memories, as small blocks leave frames for more of them.
pub(super) fn default_block(memory: Option<u64>) -> u32 {
    if memory.is_some_and(|memory| memory < 512 << 10) { 4 << 10 } else { 16 << 10 }
}

/// What the renderer is told.
pub(super) fn options(common: &Common, view: View) -> Outcome<Options> {
    let Bounds { width, height } =
        Bounds::new(common.width, common.height, framing::aspect(&view)).map_err(Failure::usage)?;
    memory::for_picture(width, height)?;
    let memory = common.memory.map(usize::try_from).transpose();
    Ok(Options {
        settings: Settings {
            samples: common.samples,
            shadow_samples: common.shadow_samples.unwrap_or(0),
            lights: common.lights_per_point,
            bounces: common.bounces as u8,
            seed: common.seed,
        },
        memory: memory.map_err(|_| Failure::usage("--memory is more than can be addressed"))?,
        threads: common.threads.unwrap_or(0) as usize,
        ..Options::new(width, height, framing::fitted(view, width, height))
    })
}

/// Renders.
pub(super) fn render(scene: &Scene, options: &Options, quiet: bool) -> Outcome<Rendered> {
    let samples = u64::from(options.settings.samples);
    let paths = u64::from(options.width) * u64::from(options.height) * samples;
    let bar = Progress::new("rendering", paths, quiet);
    let progress = |done: u64, total: u64| {
        let part = paths as f64 * (done as f64 / total.max(1) as f64);
        bar.set(part as u64);
        // Of a picture with fewer camera rays than pixels nobody knows yet how many there will be.
        if options.undersampling.is_none() {
            bar.message(format!("{} of {} camera paths", count(part as u64), count(paths)));
        }
    };
    let control = Control { cancel: &CANCEL, progress: &progress };
    let rendered = kiloray_render::render(&scene.file.view(), options, &control);
    debug_assert!(!CANCEL.load(Ordering::Relaxed));
    rendered.map_err(refused)
}

/// An error of the renderer in one line.
pub(super) fn refused(error: Error) -> Failure {
    match error {
        Error::Budget(error) => too_small(&error, error.need(), 0),
        Error::Picture(error) => Failure::usage(error),
        other => Failure::new(other),
    }
}

/// What is needed and what there is: `least` bytes, which may have blocks of another size. `packet` is what was asked for, 0 for nothing: then it is as
/// small as it may be.
pub(super) fn too_small(error: &BudgetError, least: usize, packet: u16) -> Failure {
    let lines: Vec<_> = error
        .lines()
        .filter(|line| line.need > 0)
        .map(|line| format!("{} {} of {}", line.line.name(), line.have, line.need))
        .collect();
    // What takes most of what is needed tells how it could be less.
    let most = error.lines().max_by_key(|line| line.need).map(|line| line.line);
    let has_frames = error.lines().any(|line| line.line == Line::Frames && line.need > 0);
    let packet_min = MeshOptions::packet_min(BLOCK_MIN as usize);
    let advice = match most {
        Some(Line::Messages) if packet > packet_min => "smaller packets with --packet",
        // Without frames smaller blocks take as much.
        Some(Line::Messages) if !has_frames => "a --topology with fewer links",
        Some(Line::Tile) => "smaller tiles with --tile",
        Some(Line::Tables) => "more nodes to share the blocks",
        _ => "smaller blocks with --block",
    };
    let block = |memory: usize| typed(division::default_block(memory as u64).into());
    let other = if least == error.need() {
        String::new()
    } else {
        format!(", which get blocks of {} instead of {}", block(least), block(error.memory))
    };
    Failure::new(format_args!(
        "--memory {}: too small, at least {least} bytes are needed{other} (has of needs: {}); give more, or {advice}",
        typed(error.memory as u64),
        lines.join(", ")
    ))
}
