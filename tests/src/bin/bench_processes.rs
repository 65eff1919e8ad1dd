//! `bench_processes [SCENE] [--nodes 8,2] ..`: a mesh of processes on this machine against `render` with as many threads as it has
//! processors, both with all blocks at hand, one after the other in each round; and against what the simulator predicts.
//!
//! Starting the processes is counted apart. Beside the clock it prints what all processes had of the processors, which does not depend on
//! what else the machine does: their ratio to `render` is what a mesh costs, the rest is what processors stood idle.

use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

use clap::Parser;
use cpu_time::ProcessTime;
use kiloray_core::network::Topology;
use kiloray_core::shade::Settings;
use kiloray_host::{Config, Control, Folder, Outcome, Spent, Supervisor, run_host};
use kiloray_mesh::MeshOptions;
use kiloray_render::Picture;
use kiloray_scene::kilo::KiloFile;
use kiloray_scene::{builtin, compile};
use kiloray_sim::Profile;
use kiloray_tests::{kills, reference::bits, statistics::median};

/// A mesh of processes on this machine against `render`, paired, and against the simulator.
#[derive(Parser)]
struct Arguments {
    /// A built-in scene.
    #[arg(default_value = "sphereflake:4")]
    scene: String,
    /// Processes of the meshes.
    #[arg(long, value_delimiter = ',', default_value = "8,2")]
    nodes: Vec<u16>,
    /// Pixels along the picture.
    #[arg(long, default_value_t = 512)]
    size: u32,
    /// Camera paths for each pixel.
    #[arg(long, default_value_t = 16)]
    samples: u32,
    /// Memory of each node, in MiB.
    #[arg(long, default_value_t = 64)]
    memory: usize,
    /// Greatest packet in bytes, header included; 0: by the memory.
    #[arg(long, default_value_t = 0)]
    packet: u16,
    /// Size of a block, in KiB.
    #[arg(long, default_value_t = 16)]
    block: usize,
    /// Threads of `render`; 0: as many as there are processors.
    #[arg(long, default_value_t = 0)]
    threads: usize,
    /// Rounds.
    #[arg(long, default_value_t = 3)]
    rounds: usize,
    /// Without the simulator, which takes about as long as one thread for each mesh.
    #[arg(long)]
    no_sim: bool,
    /// How fast this machine is: a file of `kiloray calibrate`; without it the simulator takes it for a `pc`.
    #[arg(long)]
    profile: Option<PathBuf>,
    /// Where the time of each process went.
    #[arg(long)]
    verbose: bool,
}

fn main() -> ExitCode {
    let typed: Vec<_> = std::env::args().skip(1).collect();
    let done = kills::node(&typed).unwrap_or_else(|| bench(&Arguments::parse()));
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("error: {message}");
            ExitCode::FAILURE
        }
    }
}

const TOPOLOGY: &str = "full";

/// What a round took \[s\]: the clock, the processors, the start.
#[derive(Clone, Copy)]
struct Took {
    wall: f64,
    cpu: f64,
    start: f64,
}

fn bench(arguments: &Arguments) -> Result<(), String> {
    let model = builtin::build(&arguments.scene).map_err(|e| e.to_string())?;
    let options = compile::Options::blocks_of(arguments.block << 10);
    let compiled = compile::compile(&model, &options, &mut ()).map_err(|e| e.to_string())?;
    let file = KiloFile::from_compiled(compiled);
    let (mut renders, mut meshes) = (Vec::new(), vec![Vec::new(); arguments.nodes.len()]);
    for round in 0..arguments.rounds.max(1) {
        let (picture, took) = rendered(&file, arguments)?;
        println!("round {round}: render {:.2} s, {:.2} s of processors", took.wall, took.cpu);
        renders.push(took);
        for (&nodes, all) in arguments.nodes.iter().zip(&mut meshes) {
            let (outcome, mesh) = hosted(&file, arguments, nodes)?;
            if bits(&outcome.picture) != bits(&picture) {
                return Err(format!("{nodes} processes gave other bits"));
            }
            println!(
                "round {round}: {nodes} processes {:.2} s, {:.2} s of processors, {:.2} s to start; clock {:.3}, processors {:.3} of render",
                mesh.wall,
                mesh.cpu,
                mesh.start,
                mesh.wall / took.wall,
                mesh.cpu / took.cpu
            );
            if arguments.verbose {
                print(&outcome);
            }
            all.push(mesh);
        }
    }
    for (&nodes, all) in arguments.nodes.iter().zip(&meshes) {
        let of = |ratio: fn(&Took, &Took) -> f64| {
            let ratios: Vec<_> = all.iter().zip(&renders).map(|(a, b)| ratio(a, b)).collect();
            median(&ratios)
        };
        println!(
            "{nodes} processes / render, median of {}: clock {:.3}, processors {:.3}",
            all.len(),
            of(|mesh, render| mesh.wall / render.wall),
            of(|mesh, render| mesh.cpu / render.cpu)
        );
        // It gives each node a processor.
        let processors = std::thread::available_parallelism().map_or(1, usize::from);
        if !arguments.no_sim && usize::from(nodes) <= processors {
            let profile = profile(arguments)?;
            let name = profile.name.clone();
            let predicted = simulated(&file, arguments, nodes, profile)?;
            let wall = median(&all.iter().map(|mesh| mesh.wall).collect::<Vec<_>>());
            println!(
                "{nodes} processes: {wall:.2} s, the simulator says {predicted:.2} s with profile {name}: ratio {:.3}",
                wall / predicted
            );
        }
    }
    Ok(())
}

fn settings(arguments: &Arguments) -> Settings {
    Settings { samples: arguments.samples, ..Settings::default() }
}

/// The same for processes and the simulator.
fn options(arguments: &Arguments, nodes: u16) -> Result<MeshOptions, String> {
    let topology = Topology::parse(TOPOLOGY, nodes.into()).map_err(|e| e.to_string())?;
    Ok(MeshOptions {
        settings: settings(arguments),
        memory: arguments.memory << 20,
        packet: arguments.packet,
        ..MeshOptions::new(arguments.size, arguments.size, topology)
    })
}

fn rendered(file: &KiloFile, arguments: &Arguments) -> Result<(Picture, Took), String> {
    let view = file.view();
    let options = kiloray_render::Options {
        settings: settings(arguments),
        threads: arguments.threads,
        ..kiloray_render::Options::new(arguments.size, arguments.size, view.views()[0])
    };
    let control = kiloray_render::Control { cancel: &AtomicBool::new(false), progress: &|_, _| {} };
    let (begin, cpu) = (Instant::now(), ProcessTime::now());
    let rendered = kiloray_render::render(&view, &options, &control).map_err(|e| e.to_string())?;
    let (wall, cpu) = (begin.elapsed().as_secs_f64(), cpu.elapsed().as_secs_f64());
    Ok((rendered.picture, Took { wall, cpu, start: 0.0 }))
}

fn hosted(file: &KiloFile, arguments: &Arguments, nodes: u16) -> Result<(Outcome, Took), String> {
    let folder = Folder::new().map_err(|e| e.to_string())?;
    let scene = folder.path().join("scene.kilo");
    file.write(&scene).map_err(|e| e.to_string())?;
    let view = file.view();
    let options = options(arguments, nodes)?;
    let addresses = folder.addresses(nodes);
    let config = Config::new(scene, addresses, TOPOLOGY, &options, view.views()[0]);
    let program = std::env::current_exe().map_err(|e| e.to_string())?;
    let cancel = &AtomicBool::new(false);
    let mut supervisor =
        Supervisor::start(&program, folder, &config, cancel).map_err(|e| e.to_string())?;
    let control = Control { cancel, progress: &|_| {} };
    let outcome =
        run_host(&config, &view, Some(&mut supervisor), &control).map_err(|e| e.to_string())?;
    supervisor.stop(Duration::from_secs(2));
    if !outcome.complete {
        return Err(format!("{nodes} processes did not complete the picture"));
    }
    let nodes = outcome.nodes.iter().map(|node| node.time.process_cpu_ns);
    let cpu = nodes.sum::<u64>() + outcome.host.process_cpu_ns;
    let took = Took {
        wall: outcome.render.as_secs_f64(),
        cpu: cpu as f64 / 1e9,
        start: outcome.start.unwrap_or_default().as_secs_f64(),
    };
    Ok((outcome, took))
}

/// Where the time of each process went.
fn print(outcome: &Outcome) {
    println!(
        "         busy network | idle: data answers credit host work |  cpu: driver others | steps, packets out (KiB), in; tiles, again [ms]"
    );
    let row = |name: String, time: &Spent| {
        let ms = |ns: u64| ns as f64 / 1e6;
        print!(
            "{name:>5} {:>7.0} {:>7.0} | {:>10.0} {:>7.0} {:>6.0} {:>4.0} {:>4.0} | {:>12.0} {:>6.0} | {}, {} ({}), {}",
            ms(time.busy_ns),
            ms(time.network_ns),
            ms(time.idle_data_ns),
            ms(time.idle_answers_ns),
            ms(time.idle_credit_ns),
            ms(time.idle_master_ns),
            ms(time.idle_work_ns),
            ms(time.driver_cpu_ns),
            ms(time.process_cpu_ns.saturating_sub(time.driver_cpu_ns)),
            time.steps,
            time.packets_sent,
            time.bytes_sent >> 10,
            time.packets_received,
        );
    };
    row("host".into(), &outcome.host);
    let ledger = outcome.ledger;
    println!("; given {}, again {}", ledger.given, ledger.given_again);
    for node in &outcome.nodes {
        row(node.node.to_string(), &node.time);
        let counts = &node.counts;
        println!(
            "; {}, {} (fetched {}, migrated {}, refused {}, rays again {}, fetches again {})",
            counts.tiles,
            counts.tiles_again,
            counts.cache.fetched,
            counts.migrated,
            counts.refused,
            counts.rays_again,
            counts.fetches_again
        );
    }
}

/// How fast this machine is taken to be.
fn profile(arguments: &Arguments) -> Result<Profile, String> {
    let Some(path) = &arguments.profile else { return Ok(Profile::PC) };
    let text = std::fs::read(path).map_err(|e| format!("{}: {e}", path.display()))?;
    serde_json::from_slice(&text).map_err(|e| format!("{}: {e}", path.display()))
}

/// What the simulator says of as many processors as nodes \[s\].
fn simulated(
    file: &KiloFile,
    arguments: &Arguments,
    nodes: u16,
    profile: Profile,
) -> Result<f64, String> {
    let view = file.view();
    let mesh = options(arguments, nodes)?;
    let (size, topology) = (arguments.size, mesh.topology);
    let options = kiloray_sim::Options {
        mesh,
        profile,
        ..kiloray_sim::Options::new(size, size, view.views()[0], topology)
    };
    let control = kiloray_sim::Control { cancel: &AtomicBool::new(false), progress: &|_| {} };
    let outcome = kiloray_sim::simulate(&view, &options, &control).map_err(|e| e.to_string())?;
    Ok(outcome.report.virtual_ns as f64 / 1e9)
}
