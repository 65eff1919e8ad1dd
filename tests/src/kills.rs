//! Meshes of processes whose nodes are killed or frozen at random: each gives the bits of one machine, and leaves no process behind.

use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};
use std::{fs, thread};

use fastrand::Rng;
use kiloray_core::network::Topology;
use kiloray_core::node::Schedule;
use kiloray_core::shade::Settings;
use kiloray_host::{Config, Control, Folder, Supervisor, run_host, run_node, tie};
use kiloray_mesh::MeshOptions;
use kiloray_render::Picture;
use kiloray_scene::kilo::KiloFile;
use kiloray_scene::{builtin, compile};

use crate::reference::one_thread;
use crate::signals::send;

/// A run in which something went wrong.
pub type Failure = String;

/// Pixels along the picture.
const SIDE: u32 = 96;
/// How it is rendered.
const SETTINGS: Settings =
    Settings { samples: 2, shadow_samples: 4, lights: 64, bounces: 6, seed: 7 };
/// Longest that a run may take.
const LONGEST: Duration = Duration::from_secs(120);

/// What came of the runs.
#[derive(Debug, Default, Clone, Copy)]
pub struct Sums {
    /// Runs.
    pub runs: u64,
    /// Nodes that were killed.
    pub kills: u64,
    /// Nodes that were frozen.
    pub freezes: u64,
    /// Nodes that were replaced.
    pub replaced: u64,
}

/// The life of a node, if that is what this program was started for: `node --config FILE --node N --incarnation I --tied`.
///
/// # Errors
/// Why it cannot begin.
pub fn node(arguments: &[String]) -> Option<Result<(), String>> {
    let [command, _, config, _, node, _, incarnation, _] = arguments else { return None };
    if command != "node" {
        return None;
    }
    let config = Path::new(config);
    tie(config);
    let run = || -> Result<(), String> {
        let node = node.parse().map_err(|_| "no node")?;
        let incarnation = incarnation.parse().map_err(|_| "no incarnation")?;
        let config = Config::read(config).map_err(|e| e.to_string())?;
        run_node(&config, node, incarnation, true).map_err(|e| e.to_string())
    };
    Some(run())
}

/// Runs with the nodes of `program`, which must begin with [`node`]. `done` is called after each.
///
/// # Errors
/// The first run that went wrong.
pub fn all(
    program: &Path,
    seed: u64,
    runs: std::ops::Range<u64>,
    done: &dyn Fn(),
) -> Result<Sums, Failure> {
    let model = builtin::build("glass").map_err(|e| e.to_string())?;
    let options = compile::Options::blocks_of(1 << 10);
    let compiled = compile::compile(&model, &options, &mut ()).map_err(|e| e.to_string())?;
    let file = KiloFile::from_compiled(compiled);
    let reference = one_thread(&file, SIDE, SIDE, file.view().views()[0], SETTINGS)?;
    let mut sums = Sums::default();
    for number in runs {
        let rng = Rng::with_seed(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15).wrapping_add(number));
        run(program, &file, &reference, rng, &mut sums).map_err(|what| {
            format!("{what}\nagain: cargo run --release -p kiloray-tests --bin kills -- --seed {seed} --run {number}")
        })?;
        sums.runs += 1;
        done();
    }
    Ok(sums)
}

fn run(
    program: &Path,
    file: &KiloFile,
    reference: &Picture,
    mut rng: Rng,
    sums: &mut Sums,
) -> Result<(), Failure> {
    let nodes: u16 = rng.u16(2..6);
    let topology = ["full", "ring", "line"][rng.usize(0..3)];
    let replicas = 1 + rng.u16(0..2);
    let schedule = [Schedule::Hybrid, Schedule::Demand, Schedule::Data][rng.usize(0..3)];
    let folder = Folder::new().map_err(|e| e.to_string())?;
    let marker = folder.path().display().to_string();
    let scene = folder.path().join("scene.kilo");
    file.write(&scene).map_err(|e| e.to_string())?;
    let joined = Topology::parse(topology, nodes.into()).map_err(|e| e.to_string())?;
    let options = MeshOptions {
        settings: SETTINGS,
        memory: 64 << 10,
        schedule,
        replicas,
        tile: Some(8),
        ..MeshOptions::new(SIDE, SIDE, joined)
    };
    let addresses = folder.addresses(nodes);
    let config = Config::new(scene, addresses, topology, &options, file.view().views()[0]);
    let (cancel, is_over) = (AtomicBool::new(false), AtomicBool::new(false));
    let mut supervisor =
        Supervisor::start(program, folder, &config, &cancel).map_err(|e| e.to_string())?;
    let processes = Mutex::new(supervisor.processes());
    let (kills, freezes) = (1 + rng.u64(0..3), rng.u64(0..2));
    let outcome = thread::scope(|scope| {
        let (processes, is_over, cancel) = (&processes, &is_over, &cancel);
        let marker = &marker;
        scope.spawn(move || {
            let begin = Instant::now();
            let mut signals = vec!["-KILL"; kills as usize];
            signals.extend(vec!["-STOP"; freezes as usize]);
            rng.shuffle(&mut signals);
            for signal in signals {
                thread::park_timeout(Duration::from_millis(rng.u64(0..400)));
                let all = processes.lock().unwrap_or_else(PoisonError::into_inner).clone();
                let victim = all[rng.usize(0..all.len())];
                if is_over.load(Ordering::Relaxed) {
                    return;
                }
                // Its number may belong to another by now: it must be one of ours.
                if is_ours(victim, marker) {
                    let _ = send(signal, victim);
                }
            }
            while !is_over.load(Ordering::Relaxed) {
                if begin.elapsed() > LONGEST {
                    cancel.store(true, Ordering::Relaxed);
                    return;
                }
                thread::park_timeout(Duration::from_millis(50));
            }
        });
        let progress = |status: &kiloray_host::Status| {
            let mut all = processes.lock().unwrap_or_else(PoisonError::into_inner);
            all.clone_from(&status.processes);
        };
        let control = Control { cancel, progress: &progress };
        let outcome = run_host(&config, &file.view(), Some(&mut supervisor), &control);
        is_over.store(true, Ordering::Relaxed);
        outcome
    });
    let what = format!(
        "{nodes} nodes, {topology}, {schedule:?}, {replicas} copies, {kills} kills, {freezes} freezes"
    );
    let outcome = outcome.map_err(|error| format!("{error} ({what})"))?;
    supervisor.stop(Duration::from_secs(1));
    if !outcome.complete {
        return Err(format!("not complete after {LONGEST:?} ({what})"));
    }
    let differing = outcome.picture.pixels.iter().zip(&reference.pixels).filter(|(a, b)| a != b);
    let differing = differing.count();
    if differing > 0 || outcome.ledger.differing > 0 {
        return Err(format!("{differing} pixels differ ({what})"));
    }
    let left = left_over(&marker);
    if !left.is_empty() || Path::new(&marker).exists() {
        return Err(format!("left behind: {left:?}, {marker} ({what})"));
    }
    sums.kills += kills;
    sums.freezes += freezes;
    sums.replaced += outcome.replacements.len() as u64;
    Ok(())
}

/// Processes that were started for the nodes of a directory.
fn left_over(marker: &str) -> Vec<u32> {
    let all = fs::read_dir("/proc").into_iter().flatten().flatten();
    let numbers = all.filter_map(|entry| entry.file_name().to_str()?.parse().ok());
    numbers.filter(|&number| is_ours(number, marker)).collect()
}

fn is_ours(process: u32, marker: &str) -> bool {
    let line = fs::read(format!("/proc/{process}/cmdline")).unwrap_or_default();
    String::from_utf8_lossy(&line).contains(marker)
}
