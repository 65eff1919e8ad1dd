use std::{fmt, hint::black_box, sync::atomic::AtomicBool, thread};

use cpu_time::ProcessTime;
use kiloray_core::{network::Topology, scene::View};
use kiloray_scene::{builtin, compile, kilo::KiloFile};
use kiloray_sim::estimates;

use super::fit::Row;
use crate::{
    command::{engine, sim},
    failure::{Failure, Outcome},
};

/// Size of a block \[bytes\].
const BLOCK: usize = 16 << 10;
/// A memory that holds all blocks of these scenes \[bytes\].
const MEMORY: usize = 4 << 20;
/// Nobody sets it: an interrupt ends the command.
static CANCEL: AtomicBool = AtomicBool::new(false);

/// A picture to measure.
#[derive(Clone, Copy)]
pub(super) struct Picture {
    /// A built-in scene.
    pub(super) scene: &'static str,
    /// Pixels each way.
    pub(super) side: u32,
    /// How many times as many pixels there would be each way, were this not the middle of a greater picture: the greater it is, the more do
    /// neighbours have in common.
    pub(super) zoom: f32,
    /// Camera paths for each pixel.
    pub(super) samples: u32,
}

impl fmt::Display for Picture {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { scene, side, zoom, samples } = self;
        let part =
            if *zoom > 1.0 { format!(" of {0} x {0}", *side as f32 * zoom) } else { String::new() };
        let name = format!("{scene} {side} x {side}{part}, {samples} samples");
        f.pad(&name)
    }
}

/// A picture, with what one simulated node counts for it.
pub(super) struct Subject {
    file: KiloFile,
    options: kiloray_render::Options,
    /// Its time is the shortest so far.
    pub(super) row: Row,
}

impl Picture {
    /// Compiles the scene, and counts.
    pub(super) fn count(&self) -> Outcome<Subject> {
        let model = builtin::build(self.scene).map_err(Failure::new)?;
        let options = compile::Options::blocks_of(BLOCK);
        let compiled = compile::compile(&model, &options, &mut ()).map_err(Failure::new)?;
        let file = KiloFile::from_compiled(compiled);
        let scene = file.view();
        let view = *scene.views().first().ok_or_else(|| Failure::new("the scene has no view"))?;
        let view = View { size: view.size.map(|size| size / self.zoom), ..view };

        let topology = Topology::parse("line", 1).map_err(Failure::new)?;
        let mut options = kiloray_sim::Options::new(self.side, self.side, view, topology);
        options.mesh.settings.samples = self.samples;
        options.mesh.memory = MEMORY;
        let control = kiloray_sim::Control { cancel: &CANCEL, progress: &|_| {} };
        let simulated = kiloray_sim::simulate(&scene, &options, &control)
            .map_err(|error| sim::refused(error, &options))?;
        let row = Row::new(&simulated.report.totals.work, estimates(&scene, true));

        let options = kiloray_render::Options {
            settings: options.mesh.settings,
            threads: 1,
            ..kiloray_render::Options::new(self.side, self.side, view)
        };
        Ok(Subject { file, options, row })
    }
}

impl Subject {
    /// Times it, on so many threads that each render it. One thread of `render` has all blocks at hand, so that a node's operations
    /// cost what they cost there.
    pub(super) fn time(&mut self, threads: usize) -> Outcome {
        let (file, options) = (self.file.view(), &self.options);
        let render = || {
            let control = kiloray_render::Control { cancel: &CANCEL, progress: &|_, _| {} };
            kiloray_render::render(&file, options, &control)
        };
        let begin = ProcessTime::now();
        thread::scope(|scope| {
            let all: Vec<_> = (0..threads).map(|_| scope.spawn(render)).collect();
            all.into_iter().try_for_each(|thread| match thread.join() {
                Ok(rendered) => rendered.map(|all| drop(black_box(all))).map_err(engine::refused),
                Err(panic) => std::panic::resume_unwind(panic),
            })
        })?;
        let ns = begin.elapsed().as_nanos() as f64 / threads as f64;
        self.row.ns = self.row.ns.min(ns);
        Ok(())
    }
}
