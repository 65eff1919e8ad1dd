use std::{
    sync::{
        OnceLock,
        atomic::{AtomicBool, Ordering},
    },
    thread,
    time::Instant,
};

use kiloray_sim::{Control, Error, Options, Outcome as Simulated, Status, simulate};

use super::{
    lost::{self, Baseline},
    options,
};
use crate::{
    console::{count, duration},
    failure::Outcome,
    picture,
    progress::Progress,
    scene::Scene,
};

/// A finished run, or what there is of it.
#[derive(Debug)]
pub(in crate::command) struct Done {
    pub(in crate::command) outcome: Simulated,
    /// Of the pixels.
    pub(in crate::command) image_hash: String,
    /// The one-node run, unless it was left out or cut short.
    pub(in crate::command) baseline: Option<Baseline>,
    /// Wall clock of the mesh (s).
    pub(in crate::command) mesh_s: f64,
    /// Wall clock of all (s).
    pub(in crate::command) all_s: f64,
}

impl Done {
    /// Of many: without the pixels, and without what differs from run to run.
    pub(in crate::command) fn of_point(mut outcome: Simulated) -> Self {
        let image_hash = picture::hash(&outcome.picture);
        outcome.picture.pixels = Vec::new();
        Self { outcome, image_hash, baseline: None, mesh_s: 0.0, all_s: 0.0 }
    }

    /// T1 / (nodes × TN), where both are known.
    pub(in crate::command) fn efficiency(&self) -> Option<f64> {
        Some(lost::efficiency(&self.outcome.report, self.compared()?))
    }

    /// The one-node run, where the picture is complete: a part of one is not compared with all of it. (Whether the one node had come to its end when
    /// a mesh was given up is chance.)
    pub(in crate::command) fn compared(&self) -> Option<&Baseline> {
        self.baseline.as_ref().filter(|_| self.outcome.is_complete())
    }
}

/// Simulates the mesh and, on a second thread (at the same time, or after it), the one node to compare it with.
pub(super) fn run(
    scene: &Scene,
    options: &Options,
    with_baseline: bool,
    at_once: bool,
    cancel: &AtomicBool,
    quiet: bool,
) -> Outcome<Done> {
    let start = Instant::now();
    let one = if with_baseline { Some(options::baseline(options)?) } else { None };
    let is_over = AtomicBool::new(false);
    let bar = OnceLock::new();
    let result = thread::scope(|scope| {
        let (is_over, bar) = (&is_over, &bar);
        let begin = |one| scope.spawn(move || baseline(scene, one, cancel, is_over, bar));
        let (now, later) = if at_once { (one.as_ref(), None) } else { (None, one.as_ref()) };
        let second = now.map(begin);
        let result = mesh(scene, options, cancel, quiet);
        let mesh_s = start.elapsed().as_secs_f64();
        if !matches!(&result, Ok(outcome) if outcome.is_complete()) {
            is_over.store(true, Ordering::Relaxed);
        }
        let baseline = second.or_else(|| later.map(begin)).and_then(|thread| {
            let pixels = u64::from(options.mesh.width) * u64::from(options.mesh.height);
            let _ = bar.set(Progress::new("one node", pixels, quiet));
            thread.join().ok().flatten()
        });
        let hash = |outcome: Simulated| {
            let image_hash = picture::hash(&outcome.picture);
            Done { outcome, image_hash, baseline, mesh_s, all_s: 0.0 }
        };
        result.map(hash)
    });
    let all_s = start.elapsed().as_secs_f64();
    result.map(|done| Done { all_s, ..done })
}

fn mesh(scene: &Scene, options: &Options, cancel: &AtomicBool, quiet: bool) -> Outcome<Simulated> {
    let bar = Progress::new(
        "simulating",
        u64::from(options.mesh.width) * u64::from(options.mesh.height),
        quiet,
    );
    let progress = |status: &Status| {
        bar.set(status.pixels);
        bar.message(format!(
            "{} of {} pixels, {} rays, {} of virtual time",
            count(status.pixels),
            count(status.pixels_all),
            count(status.rays),
            duration(status.virtual_ns)
        ));
    };
    let control = Control { cancel, progress: &progress };
    simulate(&scene.file.view(), options, &control)
        .map_err(|error| options::refused(error, options))
}

/// The one-node run; `None` if it was cut short, or cannot be.
fn baseline(
    scene: &Scene,
    one: &Options,
    cancel: &AtomicBool,
    is_over: &AtomicBool,
    bar: &OnceLock<Progress>,
) -> Option<Baseline> {
    let progress = |status: &Status| {
        if cancel.load(Ordering::Relaxed) {
            is_over.store(true, Ordering::Relaxed);
        }
        if let Some(bar) = bar.get() {
            bar.set(status.pixels);
            bar.message("the baseline of efficiency".into());
        }
    };
    measured(scene, one, &Control { cancel: is_over, progress: &progress }).ok().flatten()
}

/// Runs a baseline; `None` if it was cancelled.
pub(in crate::command) fn measured(
    scene: &Scene,
    one: &Options,
    control: &Control<'_>,
) -> Result<Option<Baseline>, Error> {
    let outcome = simulate(&scene.file.view(), one, control)?;
    let report = &outcome.report;
    let baseline = Baseline { virtual_ns: report.virtual_ns, time: report.totals.time };
    Ok(outcome.is_complete().then_some(baseline))
}
