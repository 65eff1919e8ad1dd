//! One picture from every mesh: all scenes, sizes of blocks, numbers of nodes, topologies, memories, schedules and faults, against
//! the picture of one machine.

use std::fmt;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};

use fastrand::Rng;
use kiloray_core::network::{NodeId, Topology};
use kiloray_core::node::{PointHome, Schedule};
use kiloray_core::scene::View;
use kiloray_core::shade::Settings;
use kiloray_render::framing;
use kiloray_scene::import::{self, ImportOptions};
use kiloray_scene::kilo::KiloFile;
use kiloray_scene::{builtin, compile};
use kiloray_sim::{Control, Crash, Options, Rate, least, simulate};

use crate::reference::{bits, one_thread};

/// Scenes of the full matrix; the last has as many triangles as a scanned mesh.
pub const SCENES: [&str; 4] = ["cornell", "colour-cube", "glass", "sinc:190"];
/// Sizes of blocks \[bytes\].
const BLOCKS: [usize; 3] = [1 << 10, 4 << 10, 16 << 10];
const NODES: [u16; 5] = [1, 4, 16, 64, 256];
const SHAPES: [&str; 4] = ["mesh", "torus", "hypercube", "ring"];
/// Memories, in what a node needs at least.
const MEMORIES: [usize; 3] = [1, 2, 8];
const SCHEDULES: [(&str, Schedule); 3] =
    [("hybrid", Schedule::Hybrid), ("demand", Schedule::Demand), ("data", Schedule::Data)];
/// Each for every second case.
const POINTS: [(&str, PointHome); 2] = [("finder", PointHome::Finder), ("owner", PointHome::Owner)];
/// Pixels of a side of the picture.
const SIDE: u32 = 64;
/// Virtual time that no run takes \[ns\]. With the least memory a ray that needs a hundred blocks fetches a hundred; where each of 128 hops loses one packet in a
/// hundred, three of four requests are lost on the way there or back, or twelve of thirteen at the worst; time limits grow, and 896 s have been seen.
const LONGEST: u64 = 3_600_000_000_000;

/// A scene in blocks of one size, and its picture.
#[derive(Debug)]
struct Scene {
    name: String,
    block: usize,
    file: KiloFile,
    view: View,
    reference: Vec<[u32; 3]>,
}

/// What goes wrong in a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Fault {
    None,
    /// Of a hundred packets one is lost on each link.
    Loss,
    /// The middle node dies at this time \[ns\]; there are two copies of each block.
    Crash(u64),
}

/// Runs that differ in their faults alone.
#[derive(Debug, Clone, Copy)]
pub struct Case {
    scene: usize,
    topology: Topology,
    shape: &'static str,
    memory: usize,
    schedule: (&'static str, Schedule),
    points: (&'static str, PointHome),
}

impl Case {
    /// How many nodes it has.
    #[must_use]
    pub fn nodes(&self) -> u16 {
        self.topology.nodes()
    }
}

/// All of it.
#[derive(Debug)]
pub struct Matrix {
    scenes: Vec<Scene>,
    cases: Vec<Case>,
}

impl Matrix {
    /// Of built-in scenes or files, in an order that the seed gives: any part from its beginning is a fair sample.
    ///
    /// # Errors
    /// What the importer, compiler or renderer says; and a scene whose picture depends on the size of its blocks.
    pub fn new(names: &[String], seed: u64) -> Result<Self, String> {
        let mut scenes: Vec<Scene> = Vec::new();
        for name in names {
            let model = match builtin::build(name) {
                Ok(model) => model,
                Err(error) if !Path::new(name).exists() => return Err(error.to_string()),
                Err(_) => {
                    import::load(&[name], &ImportOptions::default()).map_err(|e| e.to_string())?
                }
            };
            let first = scenes.len();
            for block in BLOCKS {
                let compiled =
                    compile::compile(&model, &compile::Options::blocks_of(block), &mut ());
                let file = KiloFile::from_compiled(compiled.map_err(|e| e.to_string())?);
                let view = file.view().views().first().copied();
                let view = view.ok_or_else(|| format!("{name} has no view"))?;
                let view = framing::fitted(view, SIDE, SIDE);
                let reference = bits(&one_thread(&file, SIDE, SIDE, view, settings())?);
                scenes.push(Scene { name: name.clone(), block, file, view, reference });
                if scenes[first].reference != scenes[scenes.len() - 1].reference {
                    return Err(format!("{name}: other bits with blocks of {block} bytes"));
                }
            }
        }
        let mut cases = Vec::new();
        for scene in 0..scenes.len() {
            for (nodes, shape) in NODES.iter().flat_map(|n| SHAPES.map(|shape| (*n, shape))) {
                let topology =
                    Topology::parse(shape, nodes.into()).map_err(|e| format!("{shape}: {e}"))?;
                for memory in MEMORIES {
                    for schedule in SCHEDULES {
                        let points = POINTS[cases.len() % 2];
                        cases.push(Case { scene, topology, shape, memory, schedule, points });
                    }
                }
            }
        }
        Rng::with_seed(seed).shuffle(&mut cases);
        Ok(Self { scenes, cases })
    }

    /// All cases.
    #[must_use]
    pub fn cases(&self) -> &[Case] {
        &self.cases
    }

    /// What a case is called.
    #[must_use]
    pub fn name(&self, case: &Case) -> String {
        let Case { topology, shape, memory, schedule, points, .. } = case;
        let Scene { name, block, .. } = &self.scenes[case.scene];
        let (kib, nodes) = (block >> 10, topology.nodes());
        format!("{name}/{kib}KiB/{shape}/{nodes}/{memory}x/{}/{}", schedule.0, points.0)
    }

    /// Runs a case without and with faults; how many runs that were.
    ///
    /// # Errors
    /// [`Failure`]: the first that went wrong.
    pub fn run(&self, case: &Case) -> Result<u64, Failure> {
        let time = self.check(case, Fault::None)?;
        self.check(case, Fault::Loss)?;
        // Someone must be left.
        if case.topology.nodes() == 1 {
            return Ok(2);
        }
        self.check(case, Fault::Crash(time / 2))?;
        Ok(3)
    }

    /// One run; its virtual time.
    fn check(&self, case: &Case, fault: Fault) -> Result<u64, Failure> {
        let scene = &self.scenes[case.scene];
        let options = options(scene, case, fault);
        let failure = |what: String| Failure {
            what,
            scene: scene.name.clone(),
            case: self.name(case),
            sim: options.as_ref().map_or_else(|_| String::new(), |o| command(scene, case, o)),
        };
        let options = options.as_ref().map_err(|e| failure(e.clone()))?;
        let ended = catch_unwind(AssertUnwindSafe(|| compare(scene, options)));
        ended.unwrap_or_else(|_| Err("it panics".into())).map_err(failure)
    }
}

fn settings() -> Settings {
    Settings { samples: 1, shadow_samples: 1, ..Settings::default() }
}

fn options(scene: &Scene, case: &Case, fault: Fault) -> Result<Options, String> {
    let mut options = Options::new(SIDE, SIDE, scene.view, case.topology);
    options.threads = 1;
    options.mesh.settings = settings();
    options.mesh.schedule = case.schedule.1;
    options.mesh.points = case.points.1;
    match fault {
        Fault::None => {}
        Fault::Loss => options.faults.loss = Rate { count: 1, of: 100 },
        Fault::Crash(at) => {
            options.mesh.replicas = 2;
            options.faults.crashes = vec![Crash { node: NodeId(case.topology.nodes() / 2), at }];
        }
    }
    let least = least(&scene.file.view(), &options).map_err(|e| e.to_string())?;
    options.mesh.memory = least * case.memory;
    Ok(options)
}

fn compare(scene: &Scene, options: &Options) -> Result<u64, String> {
    let cancel = AtomicBool::new(false);
    let progress = |status: &kiloray_sim::Status| {
        cancel.fetch_or(status.virtual_ns > LONGEST, Ordering::Relaxed);
    };
    let control = Control { cancel: &cancel, progress: &progress };
    let outcome = simulate(&scene.file.view(), options, &control).map_err(|e| e.to_string())?;
    let report = &outcome.report;
    if let Some(block) = outcome.lost() {
        return Err(format!("block {block} counts as lost"));
    }
    if !outcome.is_complete() {
        return Err(format!(
            "it takes more than {} ms of virtual time",
            report.virtual_ns / 1_000_000
        ));
    }
    if let Some(node) = report.nodes.iter().find(|node| node.peak_bytes > node.memory) {
        let (node, peak, memory) = (node.node, node.peak_bytes, node.memory);
        return Err(format!("node {node} has used {peak} of {memory} bytes"));
    }
    let wrong = bits(&outcome.picture).iter().zip(&scene.reference).filter(|(a, b)| a != b).count();
    if wrong > 0 {
        return Err(format!("{wrong} pixels have other bits"));
    }
    Ok(report.virtual_ns)
}

/// The same by the command that a person types.
fn command(scene: &Scene, case: &Case, options: &Options) -> String {
    let (Case { topology, shape, .. }, Scene { name, block, .. }) = (case, scene);
    let mut words = format!(
        "kiloray sim {name} --width {SIDE} --height {SIDE} --samples 1 --shadow-samples 1 --block {block} --nodes {} --topology {shape} --memory {} --schedule {} --points {}",
        topology.nodes(),
        options.mesh.memory,
        case.schedule.0,
        case.points.0
    );
    if options.faults.loss.count > 0 {
        words += " --loss 1/100";
    }
    for crash in &options.faults.crashes {
        words += &format!(" --block-replicas 2 --crash {}@{}ns", crash.node.0, crash.at);
    }
    words
}

/// A run that went wrong.
#[derive(Debug)]
pub struct Failure {
    what: String,
    scene: String,
    case: String,
    sim: String,
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { what, scene, case, sim } = self;
        writeln!(f, "{case}: {what}")?;
        writeln!(f, "  {sim}")?;
        write!(f, "  cargo run --release -p kiloray-tests --bin same_bits -- {scene} --only {case}")
    }
}
