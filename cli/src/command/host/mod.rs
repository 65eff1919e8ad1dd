//! `kiloray host`: a picture from a mesh of processes on this machine.

mod json;
mod page;
mod prepare;

use std::{
    path::{Path, PathBuf},
    time::{Duration, Instant},
};

use kiloray_core::node::Counts;
use kiloray_host::{
    Control, LineReport, NodeReport, Outcome as Hosted, ProcessMemory, Spent, Status, Supervisor,
    run_host,
};
use kiloray_mesh::MeshOptions;
use prepare::{Prepared, prepare};

use super::{
    html::{self, Shown},
    mesh::{self, Line, Loss, Why, again, total},
    node::refused,
};
use crate::{
    args::{self, Common, Division},
    console::{bytes, count, counted, duration, line},
    failure::{self, Failure, Outcome},
    interrupt,
    output::Output,
    picture::{self, Format, Saved},
    progress::Progress,
    scene::Scene,
};

/// How long nodes may take to end by themselves when it is over.
const END_LIMIT: Duration = Duration::from_millis(500);

/// What nobody can tell.
const UNCOUNTED: &str = "what the processes did that were replaced is not counted";

/// A run, and all that is told of it.
struct Run<'a> {
    common: &'a Common,
    scenes: &'a [PathBuf],
    /// With what suits processes, where it was not given.
    division: &'a Division,
    scene: &'a Scene,
    options: &'a MeshOptions,
    outcome: &'a Hosted,
    /// Sums over the nodes.
    counts: Counts,
    image_hash: String,
    /// Wall clock of all (s).
    time_s: f64,
    /// Stops of a PNG, the picture or that of the page.
    exposure: Option<f32>,
}

/// Starts nodes, renders and writes.
pub(super) fn run(host: &args::Host) -> Outcome {
    let begin = Instant::now();
    if let Some(path) = &host.output {
        Format::of(path)?;
    }
    let Prepared { common, division, scenes, scene, options, config, folder } = prepare(host)?;
    let quiet = common.quiet;
    if let Some(path) = &host.write_config {
        let text = config.to_text().map_err(refused)?;
        scene.print_notes(quiet);
        return Output::create(path)?.write(text.as_bytes());
    }
    let path = host.output.clone().unwrap_or_else(|| PathBuf::from(format!("{}.png", scene.name)));
    let cancel = interrupt::gentle();
    // Whether all can be written shows before the work.
    let output = Output::create(&path)?;
    let json_out = common.json.as_deref().map(Output::create).transpose()?;
    let files = common.report.as_deref().map(html::Files::create).transpose()?;
    scene.print_notes(quiet);

    let start = |folder| {
        let program = std::env::current_exe()
            .map_err(|error| Failure::new(format_args!("where this program is: {error}")))?;
        Supervisor::start(&program, folder, &config, cancel).map_err(refused)
    };
    let mut supervisor = folder.map(start).transpose()?;
    let outcome = {
        let pixels = u64::from(options.width) * u64::from(options.height);
        let bar = Progress::new("rendering", pixels, quiet);
        let progress = |status: &Status| {
            bar.set(status.pixels);
            bar.message(format!(
                "{} of {} pixels, {} nodes{}",
                count(status.pixels),
                count(status.pixels_all),
                status.nodes,
                if status.replaced > 0 {
                    format!(", {} replaced", status.replaced)
                } else {
                    String::new()
                }
            ));
        };
        let control = Control { cancel, progress: &progress };
        run_host(&config, &scene.file.view(), supervisor.as_mut(), &control).map_err(refused)?
    };
    if let Some(supervisor) = supervisor {
        // Whoever has interrupted it does not wait.
        supervisor.stop(if outcome.complete { END_LIMIT } else { Duration::ZERO });
    }

    let output = if outcome.complete { output } else { output.incomplete() };
    let path = Some(output.path().to_owned()).filter(|_| has_pixels(&outcome));
    let saved = match &path {
        Some(path) => picture::save(&outcome.picture, Format::of(path)?, common.exposure, output)?,
        None => Saved { exposure: None },
    };
    let time_s = begin.elapsed().as_secs_f64();
    let shown = Shown::of_report(&common, &outcome.picture)?;
    let stops = shown.as_ref().filter(|_| path.is_some()).map(|shown| shown.stops);
    let mut counts = Counts::default();
    outcome.nodes.iter().for_each(|node| counts.add(&node.counts));
    let run = Run {
        common: &common,
        scenes: &scenes,
        division: &division,
        scene: &scene,
        options: &options,
        outcome: &outcome,
        counts,
        image_hash: picture::hash(&outcome.picture),
        time_s,
        exposure: saved.exposure.or(stops),
    };
    let json = format!("{:#}\n", run.as_json());
    if let Some(output) = json_out {
        output.write(json.as_bytes())?;
    }
    if let Some((files, shown)) = files.zip(shown) {
        let files = if outcome.complete { files } else { files.incomplete() };
        files.write(
            &page::page(&run, &shown),
            &json,
            has_pixels(&outcome).then_some(&shown.png),
        )?;
    }
    let to_standard = [path.as_deref(), common.json.as_deref()].contains(&Some(Path::new("-")));
    if !quiet && !to_standard {
        run.print(path.as_deref(), &saved)?;
    }
    failure::warn_of_overflows(outcome.overflows, quiet);
    match (why_incomplete(&outcome), path) {
        (None, _) => Ok(()),
        (Some(why), Some(path)) => {
            Err(Failure::new(format_args!("{why}; what was rendered is in {}", path.display())))
        }
        (Some(why), None) => Err(Failure::new(format_args!("{why}; no pixel is complete"))),
    }
}

/// Why there is no picture, or only a part of one.
fn why_incomplete(outcome: &Hosted) -> Option<String> {
    match outcome {
        Hosted { complete: true, .. } => None,
        Hosted { lost: Some(block), .. } => Some(Why::NoneAnswers.lost(*block)),
        Hosted { start: None, .. } => Some("interrupted before all nodes were there".into()),
        _ => Some("interrupted".into()),
    }
}

/// Whether there is a picture at all.
fn has_pixels(outcome: &Hosted) -> bool {
    outcome.ledger.pixels > 0
}

impl Run<'_> {
    /// What a person wants to know first.
    fn print(&self, path: Option<&Path>, saved: &Saved) -> Outcome {
        let (outcome, options, counts) = (self.outcome, self.options, &self.counts);
        line(format_args!(
            "{}: {} x {}, {} samples per pixel{}{}",
            path.map_or_else(|| "no picture".into(), |path| path.display().to_string()),
            options.width,
            options.height,
            options.settings.samples,
            saved.said(),
            mesh::so_far(&outcome.picture, outcome.complete, &outcome.ledger.into()),
        ))?;
        line(format_args!("mesh       {}", self.mesh()))?;
        match outcome.start {
            Some(start) => line(format_args!(
                "time       {}, and {} until all nodes were there",
                duration(outcome.render.as_nanos() as u64),
                duration(start.as_nanos() as u64),
            ))?,
            None => line(format_args!("time       not all nodes were there"))?,
        }
        let sent = counts.sent.named();
        line(format_args!(
            "messages   {}, {}; {} blocks fetched, {} rays migrated",
            count(total(sent.iter().map(|(_, kind)| kind.count))),
            bytes(total(sent.iter().map(|(_, kind)| kind.bytes))),
            count(counts.cache.fetched),
            count(counts.migrated),
        ))?;
        if let Some(fullest) = self.fullest() {
            line(format_args!(
                "memory     {} of {} at the fullest node, {}",
                bytes(fullest.peak_bytes as u64),
                bytes(options.memory as u64),
                fullest.node,
            ))?;
        }
        if let Some((process, peak)) = self.greatest() {
            line(format_args!(
                "processes  {} of {} at the greatest, program and network included{}",
                bytes(peak),
                bytes(process.budget_bytes),
                if process.limit_bytes.is_some() { ", enforced" } else { "" },
            ))?;
        }
        let replaced = outcome.replacements.len();
        if replaced > 0 {
            line(format_args!(
                "faults     {} replaced, {} requests made again, {} tiles given to others; {UNCOUNTED}",
                counted(replaced as u64, ["node", "nodes"]),
                count(again(&self.counts)),
                count(outcome.ledger.given_again),
            ))?;
        }
        match &self.common.report {
            Some(folder) => {
                line(format_args!("report     {}", folder.join("index.html").display()))
            }
            None => Ok(()),
        }
    }

    /// The mesh, in a line.
    fn mesh(&self) -> String {
        let options = self.options;
        let nodes = options.topology.nodes();
        format!(
            "{nodes} {} of {}, {}, schedule {}",
            if nodes == 1 { "process" } else { "processes" },
            bytes(options.memory as u64),
            self.division.topology_name(&options.topology),
            format!("{:?}", options.schedule).to_lowercase(),
        )
    }

    /// The part of all nodes' time that they were at work.
    fn busy(&self) -> f64 {
        self.part(|time| time.busy_ns)
    }

    /// What the rest of it went to.
    fn lost(&self) -> Vec<Loss> {
        let mut lost = vec![
            ("data", "waiting for blocks", self.part(|time| time.idle_data_ns)),
            ("answers", "waiting for answers to rays", self.part(|time| time.idle_answers_ns)),
            ("credit", "waiting for room to send", self.part(|time| time.idle_credit_ns)),
            ("master", "waiting for the host's answers", self.part(|time| time.idle_master_ns)),
            ("imbalance", "no work left to ask for", self.part(|time| time.idle_work_ns)),
            ("messages", "taking packets from the network", self.part(|time| time.network_ns)),
        ];
        let absent = 1.0 - self.part(Spent::all_ns);
        lost.push(("absent", "processes that ended, and starts of others", absent));
        lost.into_iter().map(|(name, words, part)| Loss { name, words, part }).collect()
    }

    fn part(&self, of: impl Fn(&Spent) -> u64) -> f64 {
        total(self.outcome.nodes.iter().map(|node| of(&node.time))) as f64 / self.all_ns() as f64
    }

    /// All nodes' time \[ns\]: of each from the first to the last pixel, or longer, as some begin before and end after.
    fn all_ns(&self) -> u64 {
        let render = self.outcome.render.as_nanos() as u64;
        let known = self.outcome.nodes.iter().map(|node| node.time.all_ns());
        let unknown = u64::from(self.options.topology.nodes()).saturating_sub(known.len() as u64);
        (render * unknown + total(known.map(|ns| ns.max(render)))).max(1)
    }

    /// The lines of a node's memory, each of the node that had most in it.
    fn lines(&self) -> Vec<Line<'_>> {
        let line = |line| {
            let &LineReport { ref name, capacity, bytes, peak, peak_bytes } = line;
            Line { name, capacity, bytes, peak, peak_bytes }
        };
        mesh::greatest(self.outcome.nodes.iter().flat_map(|node| &node.lines).map(line))
    }

    fn fullest(&self) -> Option<&NodeReport> {
        self.outcome.nodes.iter().max_by_key(|node| node.peak_bytes)
    }

    /// The process that held most, and how much.
    fn greatest(&self) -> Option<(&ProcessMemory, u64)> {
        let processes = self.outcome.nodes.iter().map(|node| &node.process);
        processes
            .filter_map(|process| Some((process, process.peak_bytes?)))
            .max_by_key(|&(_, peak)| peak)
    }
}
