//! `kiloray sweep`: every combination of some options, as a table, plots and a page.

mod page;
mod plots;
mod point;
mod pool;
mod table;

use std::{
    collections::BTreeMap,
    fs,
    path::Path,
    sync::atomic::{AtomicU64, Ordering},
};

use kiloray_sim::{Control, Options, simulate};

use self::{
    point::{Point, points},
    table::Row,
};
use super::{
    files,
    sim::{self, Baseline, Done},
};
use crate::{
    args,
    console::line,
    cores,
    failure::{self, Failure, Outcome},
    interrupt,
    output::{Folder, Output},
    progress::Progress,
    scene::Scene,
};

/// The files of a sweep, opened before the work.
struct Files {
    csv: Output,
    page: Output,
    json: Option<Output>,
}

/// Simulates all points, and writes what came of them.
pub(super) fn run(sweep: &args::Sweep) -> Outcome {
    if sweep.common.report.is_some() {
        return Err(Failure::usage("--report: a sweep writes its page into the directory of -o"));
    }
    let quiet = sweep.common.quiet;
    let folder = sweep.output.as_path();
    let mut points = points(sweep)?;
    points.iter().try_for_each(|point| files::keep(&point.sim))?;
    let scenes = load(&mut points, quiet)?;
    let _folder = Folder::create(folder)?;
    let files = Files {
        csv: Output::create(&folder.join("sweep.csv"))?,
        page: Output::create(&folder.join("index.html"))?,
        json: sweep.common.json.as_deref().map(Output::create).transpose()?,
    };
    let rows = simulate_all(&points, &scenes, sweep);
    let failed = rows.iter().filter(|row| row.error.is_some()).count();
    write(files, sweep, &rows, folder)?;
    if !quiet && sweep.common.json.as_deref() != Some(Path::new("-")) {
        table::print(&rows)?;
        line(format_args!("table  {}", folder.join("sweep.csv").display()))?;
        line(format_args!("page   {}", folder.join("index.html").display()))?;
    }
    let spared: Vec<_> = rows.iter().filter_map(|row| row.spared.as_deref()).collect();
    if let Some(first) = spared.first().filter(|_| !quiet) {
        failure::warn(&match spared.len() {
            1 => format!("in one point {first}"),
            points => format!("in the first of {points} points {first}"),
        });
    }
    if let Some((a, b)) = table::differing(&rows) {
        return Err(Failure::new(format_args!(
            "the pictures of '{a}' and '{b}' differ; this is a mistake in kiloray, please report it"
        )));
    }
    if interrupt::is_asked() {
        return Err(Failure::new("interrupted; the points that were done are in the table"));
    }
    if failed > 0 {
        return Err(Failure::new(format_args!(
            "{failed} of {} points failed; their errors are in {}",
            rows.len(),
            folder.join("sweep.csv").display()
        )));
    }
    Ok(())
}

/// Compiles the scene once for all points that mean the same by it. An error belongs to its points, unless there are no others.
fn load(points: &mut [Point], quiet: bool) -> Outcome<Vec<Outcome<Scene>>> {
    let mut scenes: Vec<Outcome<Scene>> = Vec::new();
    let mut known = BTreeMap::new();
    for point in points {
        point.scene = *known.entry(sim::scene_key(&point.sim)).or_insert(scenes.len());
        if point.scene == scenes.len() {
            let scene = sim::load(&point.sim, quiet);
            if let Ok(scene) = &scene
                && scenes.iter().all(Result::is_err)
            {
                scene.print_notes(quiet);
            }
            scenes.push(scene);
        }
    }
    match scenes.iter().position(Result::is_ok) {
        Some(_) => Ok(scenes),
        None => scenes.into_iter().map(|scene| scene.map(Ok)).collect(),
    }
}

/// What a thread does.
enum Job<'a> {
    /// A one-node run, by its place among them.
    Baseline(&'a Scene, &'a Options),
    /// A point.
    Mesh(&'a Scene, &'a Options),
}

/// What came of it.
enum Ended {
    Baseline(Option<Baseline>),
    Mesh(Result<Box<Done>, String>),
}

impl Ended {
    /// It is for the table: not a run to compare it with, nor one that was interrupted.
    fn is_point(&self) -> bool {
        matches!(self, Self::Mesh(_)) && !interrupt::is_asked()
    }
}

fn simulate_all(points: &[Point], scenes: &[Outcome<Scene>], sweep: &args::Sweep) -> Vec<Row> {
    // Points that run at the same time share the cores.
    let threads = (cores::threads(sweep.common.threads) / points.len().max(1)).max(1);
    let prepare = |point: &Point| {
        let words = |failure: &Failure| failure.message().to_owned();
        let scene = scenes[point.scene].as_ref().map_err(words)?;
        let options = sim::options(&point.sim, scene).map_err(|failure| words(&failure))?;
        Ok((scene, Options { threads, ..options }))
    };
    let prepared: Vec<Result<(&Scene, Options), String>> = points.iter().map(prepare).collect();
    // A baseline serves all points that differ in the mesh only.
    let mut ones: Vec<(usize, &Scene, Options)> = Vec::new();
    let mut one_of = vec![None; points.len()];
    if !sweep.no_baseline {
        for ((point, prepared), one_of) in points.iter().zip(&prepared).zip(&mut one_of) {
            let Ok((scene, options)) = prepared else { continue };
            let Ok(one) = sim::baseline(options) else { continue };
            let place = ones.iter().position(|(of, _, other)| (*of, other) == (point.scene, &one));
            *one_of = place.or_else(|| {
                ones.push((point.scene, scene, one));
                Some(ones.len() - 1)
            });
        }
    }
    let mut jobs: Vec<_> = ones.iter().map(|(_, scene, one)| Job::Baseline(scene, one)).collect();
    jobs.extend(prepared.iter().flatten().map(|(scene, options)| Job::Mesh(scene, options)));
    // Those that cannot be are done.
    let refused = prepared.iter().filter(|prepared| prepared.is_err()).count();
    let (all, done) = (points.len() as u64, AtomicU64::new(refused as u64));
    let bar = Progress::new("simulating", all, sweep.common.quiet);
    let show = |done: u64| {
        bar.set(done);
        bar.message(format!("{done} of {all} points"));
    };
    show(refused as u64);
    let ended = pool::run(&jobs, sweep.common.threads, |job| {
        let ended = one(job);
        if ended.is_point() {
            show(done.fetch_add(1, Ordering::Relaxed) + 1);
        }
        ended
    });
    drop(bar);

    let mut ended = ended.into_iter();
    let baselines: Vec<_> = ended
        .by_ref()
        .take(ones.len())
        .map(|ended| if let Ok(Ended::Baseline(one)) = ended { one } else { None })
        .collect();
    let rows = points.iter().zip(&prepared).zip(one_of).map(|((point, prepared), one)| {
        let (scene, options) = match prepared {
            Ok(prepared) => prepared,
            Err(error) => return Row::failed(point, error),
        };
        match ended.next() {
            Some(Ok(Ended::Mesh(Ok(mut done)))) => {
                done.baseline = one.and_then(|one| baselines.get(one).copied().flatten());
                Row::done(point, scene, options, &done)
            }
            Some(Ok(Ended::Mesh(Err(error))) | Err(error)) => Row::failed(point, &error),
            _ => Row::failed(point, "not run"),
        }
    });
    rows.collect()
}

fn one(job: &Job<'_>) -> Ended {
    let control = Control { cancel: interrupt::gentle(), progress: &|_| {} };
    match job {
        Job::Baseline(scene, one) => {
            Ended::Baseline(sim::measured(scene, one, &control).ok().flatten())
        }
        Job::Mesh(scene, options) => {
            let ended = simulate(&scene.file.view(), options, &control);
            Ended::Mesh(match ended {
                Ok(outcome) => match sim::why_incomplete(outcome.end, options) {
                    None => Ok(Box::new(Done::of_point(outcome))),
                    Some(why) => Err(why),
                },
                Err(error) => Err(sim::refused(error, options).message().to_owned()),
            })
        }
    }
}

fn write(files: Files, sweep: &args::Sweep, rows: &[Row], folder: &Path) -> Outcome {
    files.csv.write(table::csv(sweep, rows).as_bytes())?;
    let plots = plots::of_sweep(sweep, rows);
    let drawn = || plots.iter().flat_map(|(_, plots)| plots);
    // Those of an older sweep would stand among the new ones.
    for name in plots::names().filter(|name| drawn().all(|plot| plot.name != *name)) {
        let path = folder.join(plots::file(&name));
        if path.is_file() {
            fs::remove_file(&path).map_err(|error| Failure::io(&path, &error))?;
        }
    }
    for plot in drawn() {
        let path = folder.join(plots::file(&plot.name));
        Output::create(&path)?.write(plot.svg(true).as_bytes())?;
    }
    files.page.write(page::page(sweep, rows, &plots).as_bytes())?;
    match files.json {
        Some(output) => {
            let all: Vec<_> = rows.iter().map(Row::as_json).collect();
            output.write(format!("{:#}\n", serde_json::Value::from(all)).as_bytes())
        }
        None => Ok(()),
    }
}
