//! `kiloray sim`: a picture from a simulated mesh, and what it cost.

mod cut;
#[cfg(test)]
mod fixture;
mod host;
mod json;
mod lost;
mod options;
mod page;
mod run;
mod summary;
#[cfg(test)]
mod tests;
mod trace;

use std::{path::PathBuf, sync::atomic::Ordering};

use kiloray_core::network::PacketHeader;
use kiloray_sim::{End, LineReport, LinkReport, Options, Report};

use self::{
    cut::Cut,
    lost::{Bound, bounds},
};
pub(super) use self::{
    lost::Baseline,
    options::{baseline, on, options, refused},
    run::{Done, measured},
    summary::spared,
};
use super::{
    division, engine, frames, html, least,
    mesh::{self, Line, Why},
};
use crate::{
    args,
    failure::{self, Failure, Outcome},
    interrupt,
    output::Output,
    picture::{self, Format},
    scene::{self, Scene},
};

/// A loss of links above one in so many, and a jitter above so many latencies, is noted before the run, and is what one that does not end is put down to.
const LOSS_HEAVY: u64 = 5;
const JITTER_HEAVY: u64 = 100;

/// A run, and all that is told of it.
pub(super) struct Run<'a> {
    pub(super) sim: &'a args::Sim,
    pub(super) scene: &'a Scene,
    pub(super) options: &'a Options,
    pub(super) done: &'a Done,
    /// The topology, with its sizes.
    topology: String,
    cut: Option<Cut>,
    /// Stops of a PNG, the picture or that of the page.
    pub(super) exposure: Option<f32>,
}

/// Simulates and writes.
pub(super) fn run(sim: &args::Sim) -> Outcome {
    let common = &sim.common;
    let quiet = common.quiet;
    if let Some(path) = &sim.output {
        Format::of(path)?;
    }
    // What makes no sense is said before the scene is read.
    sim.mesh.division.topology().map_err(Failure::usage)?;
    let mut scene = load(sim, quiet)?;
    let (options, few_frames) = {
        let mesh = least::Mesh {
            sources: &sim.scene,
            block: common.block,
            scene: &scene,
            options: |scene: &Scene| options(sim, scene),
        };
        let (options, layout) = mesh.check(engine::too_small)?;
        let few_frames = frames::of_mesh(&scene.file.view(), &options.mesh, &layout);
        (options, few_frames)
    };
    scene.notes.extend(few_frames);
    let path = sim.output.clone().unwrap_or_else(|| PathBuf::from(format!("{}.png", scene.name)));
    let cancel = interrupt::gentle();
    // Whether all can be written shows before the work.
    let output = Output::create(&path)?;
    let json_out = common.json.as_deref().map(Output::create).transpose()?;
    let trace_out = sim.trace.as_deref().map(Output::create).transpose()?;
    let files = common.report.as_deref().map(html::Files::create).transpose()?;
    scene.print_notes(quiet);
    let heavy = heavy(&options);
    // A run in which all packets are lost does not begin.
    let begins = options.faults.loss.count < options.faults.loss.of;
    if begins && !heavy.is_empty() && !quiet {
        let faults = heavy.join(" and ");
        failure::warn(&format!(
            "many packets are lost or late, which can take very long: give less of {faults}"
        ));
    }

    let done = {
        let at_once = common.threads != Some(1);
        run::run(&scene, &options, !sim.no_baseline, at_once, cancel, quiet)?
    };
    let complete = done.outcome.is_complete();
    let output = if complete { output } else { output.incomplete() };
    let path = output.path().to_owned();
    let saved = picture::save(&done.outcome.picture, Format::of(&path)?, common.exposure, output)?;
    let shown = html::Shown::of_report(common, &done.outcome.picture)?;
    let exposure = saved.exposure.or(shown.as_ref().map(|shown| shown.stops));
    let run = Run::new(sim, &scene, &options, &done, exposure);
    if let Some(output) = json_out {
        output.write(format!("{:#}\n", run.as_json()).as_bytes())?;
    }
    if let Some(output) = trace_out {
        output.write_with(|out| trace::write(&done.outcome.report, &options, out))?;
        let cut = trace::cut(&done.outcome.report, &options);
        if !cut.is_empty() && !quiet {
            failure::warn(&cut);
        }
    }
    if let Some((files, shown)) = files.zip(shown) {
        let files = if complete { files } else { files.incomplete() };
        files.write(&page::page(&run, &shown), &run.as_json_with_details(), Some(&shown.png))?;
    }
    let is_standard = |p: &std::path::Path| p == std::path::Path::new("-");
    let to_standard = [Some(path.as_path()), common.json.as_deref(), sim.trace.as_deref()]
        .into_iter()
        .flatten()
        .any(is_standard);
    if !quiet && !to_standard {
        summary::print(&run, &path, &saved)?;
    }
    let outcome = &done.outcome;
    failure::note(
        host::waits(&outcome.report, &outcome.division, &options.faults).as_deref(),
        quiet,
    );
    failure::note(spared(&done.outcome.report, &options).as_deref(), quiet);
    failure::warn_of_overflows(done.outcome.overflows, quiet);
    match why_incomplete(done.outcome.end, &options) {
        Some(why) => {
            Err(Failure::new(format_args!("{why}; what was rendered is in {}", path.display())))
        }
        None if cancel.load(Ordering::Relaxed) => {
            Err(Failure::new("interrupted; the picture is complete, the efficiency is not known"))
        }
        None => Ok(()),
    }
}

/// Why there is no picture, or only a part of one.
pub(super) fn why_incomplete(end: End, options: &Options) -> Option<String> {
    match end {
        End::Complete => None,
        End::Cancelled => Some("interrupted".into()),
        End::Lost(block) => Some(Why::NoneLives.lost(block)),
        End::Slow(node) => {
            let slow = options.faults.slow.iter().find(|slow| slow.node == node);
            let factor = slow.map_or(1.0, |slow| slow.factor);
            Some(format!(
                "nothing moves any more but node {}, slow by a factor of {factor}, for which the others wait: give less in --slow",
                node.0
            ))
        }
        End::Stuck => {
            let why = match heavy(options).as_slice() {
                [] => "a mistake of Kiloray: please report the command".to_owned(),
                faults => format!(
                    "too many packets are lost or late: give less of {}",
                    faults.join(" and ")
                ),
            };
            Some(format!("nothing moves any more, {why}"))
        }
    }
}

/// Faults of links that were asked for, and may be more than a run survives: one packet in five lost, or a delay of many times the latency.
fn heavy(options: &Options) -> Vec<&'static str> {
    // Over a link without latency a packet takes time as well.
    let (faults, latency) = (&options.faults, options.link.bundle_age(PacketHeader::BYTES) / 2);
    let loss = u64::from(faults.loss.count) * LOSS_HEAVY > faults.loss.of.into();
    let jitter = faults.jitter > latency.saturating_mul(JITTER_HEAVY);
    [("--loss", loss), ("--jitter", jitter)]
        .into_iter()
        .filter_map(|(name, heavy)| heavy.then_some(name))
        .collect()
}

/// Reads and compiles the scene, in blocks that suit the nodes' memory.
pub(super) fn load(sim: &args::Sim, quiet: bool) -> Outcome<Scene> {
    let scene = scene::load(&sim.scene, sim.common.block, default_block(sim), quiet)?;
    Ok(scene.with_view(sim.common.view.as_ref()))
}

/// What [`load`] depends on, of the options that a sweep can vary: commands in which it is the same have the same blocks.
pub(super) fn scene_key(sim: &args::Sim) -> (Option<u32>, u32, u32) {
    let block = sim.common.block;
    (block, block.unwrap_or_else(|| default_block(sim)), sim.scene.lights)
}

fn default_block(sim: &args::Sim) -> u32 {
    division::default_block(division::memory(&sim.common))
}

impl<'a> Run<'a> {
    /// Of a run that ended.
    pub(super) fn new(
        sim: &'a args::Sim,
        scene: &'a Scene,
        options: &'a Options,
        done: &'a Done,
        exposure: Option<f32>,
    ) -> Self {
        let topology = sim.mesh.division.topology_name(&options.mesh.topology);
        let cut = cut::worst(&done.outcome.report, options.link.bandwidth);
        Self { sim, scene, options, done, topology, cut, exposure }
    }

    fn busiest_link(&self) -> Option<&LinkReport> {
        self.done.outcome.report.links.iter().max_by_key(|link| link.busy_ns)
    }

    /// See [`bounds`].
    fn bounds(&self) -> Vec<Bound> {
        bounds(&self.done.outcome.report, self.done.compared(), self.cut.as_ref())
    }
}

/// The lines of a node's memory, each with the peak of the node that had the greatest.
pub(super) fn lines(report: &Report) -> Vec<Line<'static>> {
    let line = |&LineReport { name, capacity, bytes, peak, peak_bytes }: &LineReport| Line {
        name,
        capacity,
        bytes,
        peak,
        peak_bytes,
    };
    mesh::greatest(report.nodes.iter().flat_map(|node| &node.lines).map(line))
}
