use crate::undersampled::Rounds;
use crate::{Error, Lanes, Options, Picture, camera, mapped, node};
use kiloray_core::block::KiloView;
use kiloray_core::render::{Job, Plan, PlanSettings, SceneSize, Tiling};
use kiloray_core::scene::Needs;
use kiloray_core::shade::{Counts, LightRows, Shader, Tables};
use kiloray_core::store::{Budget, CacheCounts};
use kiloray_core::trace::{Scalar, Tracer};
use kiloray_simd::Auto;
use std::sync::atomic::AtomicBool;

/// How the caller follows the work, and stops it.
#[derive(Clone, Copy)]
pub struct Control<'a> {
    /// Set from anywhere, it ends the work soon.
    pub cancel: &'a AtomicBool,
    /// Hears how many of all tiles are done; from any thread, one call at a time.
    pub progress: &'a (dyn Fn(u64, u64) + Sync),
}

impl std::fmt::Debug for Control<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Control").field("cancel", self.cancel).finish_non_exhaustive()
    }
}

/// A picture, and how it came to be.
#[derive(Debug, Clone)]
pub struct Rendered {
    /// The picture.
    pub picture: Picture,
    /// Counts.
    pub report: Report,
}

/// What was done for a picture.
#[derive(Debug, Clone, Copy)]
pub struct Report {
    /// Rays, and what was skipped.
    pub counts: Counts,
    /// What the cache did; zeros where blocks are read in place.
    pub cache: CacheCounts,
    /// The memory of a thread, line by line, with its peaks: the greatest of all threads.
    pub budget: Budget,
    /// What the expanded top of the tree takes, once for all threads \[bytes\]: none in a given memory.
    pub top_bytes: usize,
    /// Threads that worked.
    pub threads: usize,
    /// Pixels whose sum was too great to count.
    pub overflows: u64,
    /// Pixels that no camera ray goes through ([`Options::undersampling`]).
    pub interpolated: u64,
}

/// Renders a picture of a file in memory.
///
/// Its blocks must have been checked before ([`KiloView::check_blocks`]). Others are no danger, but the picture may be wrong.
///
/// # Errors
/// [`Error`]: nothing of the picture is given then.
pub fn render(
    file: &KiloView<'_>,
    options: &Options,
    control: &Control<'_>,
) -> Result<Rendered, Error> {
    match options.lanes {
        Lanes::Auto => with(file, options, control, Auto::detect().quickest()),
        // Where these are the quickest of any machine, all of tracing is compiled once for both.
        Lanes::Scalar => with(file, options, control, Auto::only(Scalar)),
    }
}

/// How the memory of a node is divided for these options.
///
/// # Errors
/// [`Error::Budget`] if it is too small.
pub fn plan(file: &KiloView<'_>, options: &Options) -> Result<Plan, Error> {
    let scene = SceneSize {
        block_bytes: file.limits().block_bytes,
        blocks: file.blocks() as usize,
        specular: file.needs().bits & Needs::SPECULAR != 0,
    };
    let settings = PlanSettings {
        bounces: options.settings.bounces,
        in_place: options.memory.is_none(),
        batch_max: options.batch,
    };
    Ok(Plan::new(options.memory.unwrap_or(usize::MAX / 2), &scene, &settings)?)
}

fn with<T: Tracer + Send + Sync>(
    file: &KiloView<'_>,
    options: &Options,
    control: &Control<'_>,
    tracer: T,
) -> Result<Rendered, Error> {
    let (width, height) = (options.width, options.height);
    let camera = camera(&options.view, width, height, options.settings.samples)?;
    let mut picture = Picture::new(width, height)?;
    let rows = LightRows::new(file.lights());
    let shader = Shader::new(Tables::of(file), options.settings);
    let job = Job {
        // In a memory of its own a node has no other copy of the lights.
        shader: if options.memory.is_none() { shader.with_rows(&rows) } else { shader },
        camera,
        width,
        only: None,
        cancel: Some(control.cancel),
    };
    let plan = plan(file, options)?;
    let rounds = &mut Rounds::new(options.undersampling, &picture)?;
    let report = if let Some(memory) = options.memory {
        let tiling = Tiling::new(width, height, plan.side as u32);
        node::render(file, &job, &plan, memory, tiling, tracer, control, rounds, &mut picture)?
    } else {
        mapped::render(file, &job, plan, options.threads, tracer, control, rounds, &mut picture)?
    };
    Ok(Rendered { picture, report })
}
