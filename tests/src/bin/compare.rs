//! `compare [SCENE] [--nodes 64] [--pairs N] ..`: what a simulated mesh takes of this machine, against a render of the same picture on one core, in turns.
//!
//! The compilation of the scene is left out on both sides. The pictures must have the same bits; the exit code is 1 if they have not. `kiloray sim` tells
//! what the mesh itself does.

use std::error::Error;
use std::process::ExitCode;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

use clap::{Parser, ValueEnum};
use cpu_time::ProcessTime;
use kiloray_core::block::KiloView;
use kiloray_core::network::Topology;
use kiloray_core::node::Schedule;
use kiloray_scene::{builtin, compile, kilo::KiloFile};
use kiloray_sim::{Control, MeshOptions, Options, Outcome, simulate};
use kiloray_tests::reference::{bits, one_thread};

/// What a simulated mesh takes of this machine, against a render of the same picture on one core, in turns.
#[derive(Parser)]
struct Arguments {
    /// A built-in scene.
    #[arg(default_value = "cornell")]
    scene: String,
    /// Nodes of the mesh.
    #[arg(long, default_value_t = 64)]
    nodes: u32,
    /// How they are connected, as in `kiloray sim`.
    #[arg(long, default_value = "torus")]
    topology: String,
    /// Memory of each node, in KiB.
    #[arg(long, default_value_t = 256)]
    memory: usize,
    /// Size of a block, in KiB.
    #[arg(long, default_value_t = 4)]
    block: usize,
    /// Pixels along the picture.
    #[arg(long, default_value_t = 256)]
    size: u32,
    /// Camera paths for each pixel.
    #[arg(long, default_value_t = 4)]
    samples: u32,
    /// Which rays migrate.
    #[arg(long, value_enum, default_value_t = Which::Hybrid)]
    schedule: Which,
    /// Pixels along a tile; without it as many as suit the mesh.
    #[arg(long)]
    tile: Option<u16>,
    /// Nodes to a sub-master; 0: without them.
    #[arg(long, default_value_t = 0)]
    group: u16,
    /// Threads of the simulation.
    #[arg(long, default_value_t = 1)]
    threads: usize,
    /// How often both are done, in turns.
    #[arg(long, default_value_t = 1)]
    pairs: usize,
    /// One side alone, for profilers.
    #[arg(long, value_enum)]
    only: Option<Side>,
    /// Also what a node takes of this machine's memory beside its arena, where the system tells.
    #[arg(long)]
    resident: bool,
}

/// [`Schedule`].
#[derive(Clone, Copy, ValueEnum)]
enum Which {
    Hybrid,
    Demand,
    Data,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Side {
    Mesh,
    Plain,
}

/// What a picture took of one thing or the other \[s\].
#[derive(Clone, Copy, Default)]
struct Took {
    wall: f64,
    processors: f64,
}

fn main() -> ExitCode {
    match run(&Arguments::parse()) {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => {
            eprintln!("compare: the pictures differ");
            ExitCode::FAILURE
        }
        Err(error) => {
            eprintln!("compare: {error}");
            ExitCode::from(2)
        }
    }
}

/// Whether all pictures are the same.
fn run(arguments: &Arguments) -> Result<bool, Box<dyn Error>> {
    let model = builtin::build(&arguments.scene)?;
    let blocks = compile::Options::blocks_of(arguments.block << 10);
    let file = KiloFile::from_compiled(compile::compile(&model, &blocks, &mut ())?);
    let view = file.view();
    let options = options(arguments, &view)?;
    if arguments.resident {
        resident(&view, &options)?;
    }
    let MeshOptions { width, height, settings, .. } = options.mesh;
    let (mut meshes, mut plains) = (Took::default(), Took::default());
    let mut same = true;
    for _ in 0..arguments.pairs {
        let (mut pictures, mut events) = (Vec::new(), None);
        if arguments.only != Some(Side::Plain) {
            let (outcome, took) = timed(|| simulated(&view, &options))?;
            let virtual_ms = outcome.report.virtual_ns as f64 / 1e6;
            took.print("mesh", &mut meshes);
            pictures.push(outcome.picture);
            events = Some((outcome.report.events, virtual_ms));
        }
        if arguments.only != Some(Side::Mesh) {
            let (picture, took) =
                timed(|| one_thread(&file, width, height, options.view, settings))?;
            took.print("plain", &mut plains);
            pictures.push(picture);
        }
        if let Some((events, virtual_ms)) = events {
            println!("{events} events, {virtual_ms:.3} ms of virtual time");
        }
        same &= pictures.windows(2).all(|two| bits(&two[0]) == bits(&two[1]));
    }
    if arguments.only.is_none() {
        println!("ratio of times {:.3}", meshes.wall / plains.wall);
        println!("ratio of processors' times {:.3}", meshes.processors / plains.processors);
    }
    Ok(same)
}

fn options(arguments: &Arguments, file: &KiloView<'_>) -> Result<Options, Box<dyn Error>> {
    let view = *file.views().first().ok_or("the scene has no view")?;
    let topology = Topology::parse(&arguments.topology, arguments.nodes)?;
    let mut options = Options::new(arguments.size, arguments.size, view, topology);
    options.threads = arguments.threads;
    options.mesh.settings.samples = arguments.samples;
    options.mesh.memory = arguments.memory << 10;
    options.mesh.tile = arguments.tile;
    options.mesh.group = arguments.group;
    options.mesh.schedule = match arguments.schedule {
        Which::Hybrid => Schedule::Hybrid,
        Which::Demand => Schedule::Demand,
        Which::Data => Schedule::Data,
    };
    Ok(options)
}

impl Took {
    fn print(self, name: &str, sum: &mut Self) {
        println!("{name} {:.3} s, {:.3} of processors", self.wall, self.processors);
        sum.wall += self.wall;
        sum.processors += self.processors;
    }
}

fn timed<T, E>(task: impl FnOnce() -> Result<T, E>) -> Result<(T, Took), E> {
    let (processors, wall) = (ProcessTime::now(), Instant::now());
    let done = task()?;
    let wall = wall.elapsed().as_secs_f64();
    Ok((done, Took { wall, processors: processors.elapsed().as_secs_f64() }))
}

/// Prints what a node takes of this machine's memory.
fn resident(file: &KiloView<'_>, options: &Options) -> Result<(), Box<dyn Error>> {
    // What is there once, whatever the number of nodes, is there before.
    let mut few = options.clone();
    few.mesh.topology = Topology::Full { nodes: 2 };
    simulated(file, &few)?;
    let before = resident_peak().ok_or("the system does not tell what is resident")?;
    let outcome = simulated(file, options)?;
    let after = resident_peak().unwrap_or(before);
    let nodes = u64::from(outcome.report.mesh.nodes);
    let each = (after - before) / nodes.saturating_sub(2).max(1);
    println!(
        "resident: {} KiB more than before, {each} bytes a node, {} beside its arena",
        (after - before) >> 10,
        each as i64 - options.mesh.memory as i64
    );
    Ok(())
}

/// The greatest resident set of this process so far \[bytes\], where it can be known.
fn resident_peak() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    line.trim().strip_suffix(" kB")?.parse::<u64>().ok().map(|kib| kib << 10)
}

fn simulated(file: &KiloView<'_>, options: &Options) -> Result<Outcome, kiloray_sim::Error> {
    let control = Control { cancel: &AtomicBool::new(false), progress: &|_| {} };
    simulate(file, options, &control)
}
