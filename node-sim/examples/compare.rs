//! Renders a built-in scene on a simulated mesh and on one core of this machine, one after the other, and
//! prints whether the pictures are the same, what each took, and where the mesh's time went.
//!
//! With `PAIRS=n` it does both n times in turns, and prints the ratio of their times and of their processor times; with `ONLY=mesh` or `ONLY=plain` one of
//! the two, `REPEAT` times. `GROUP`, `SHADOW`, `POINTS`, `BW`, `LATENCY`, `PACKET`, `TOP`, `TILE`, `PROFILE` and `SEED` set options of the mesh, `THREADS` those of this machine. What a node took of this machine
//! beside its arena is printed where that can be known.
//!
//! `cargo run --release -p kiloray-sim --example compare -- SCENE TOPOLOGY NODES MEMORY_KIB SIDE [SCHEDULE [BLOCK_KIB [SAMPLES]]]`

use kiloray_core::block::KiloView;
use kiloray_core::network::Topology;
use kiloray_core::node::{PointHome, Schedule};
use kiloray_scene::{builtin, compile, kilo::KiloFile};
use kiloray_sim::{Control, MeshOptions, Options, Outcome, Profile, simulate};
use std::sync::atomic::AtomicBool;
use std::time::Instant;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let text = |at: usize, default: &'static str| {
        arguments.get(at).map_or(default.to_owned(), String::clone)
    };
    let scene = text(0, "cornell");
    let nodes: u32 = text(2, "64").parse()?;
    let topology = Topology::parse(&text(1, "torus"), nodes)?;
    let memory: usize = text(3, "256").parse()?;
    let side: u32 = text(4, "128").parse()?;
    let block: usize = text(6, "4").parse()?;
    let model = builtin::build(&scene)?;
    let file = compile::compile(&model, &compile::Options::blocks_of(block << 10), &mut ())?;
    let file = KiloFile::from_compiled(file);
    let file = file.view();
    let mut options = Options::new(side, side, file.views()[0], topology);
    options.mesh.settings.samples = text(7, "4").parse()?;
    if let Ok(p) = std::env::var("SHADOW") {
        options.mesh.settings.shadow_samples = p.parse()?;
    }
    if let Ok(p) = std::env::var("BW") {
        options.link.bandwidth = p.parse()?;
    }
    if let Ok(p) = std::env::var("LATENCY") {
        options.link.latency = p.parse()?;
    }
    if let Ok(p) = std::env::var("PACKET") {
        options.mesh.packet = p.parse()?;
    }
    if let Ok(p) = std::env::var("TOP") {
        options.mesh.top = Some(p.parse()?);
    }
    if let Ok(p) = std::env::var("TILE") {
        options.mesh.tile = Some(p.parse()?);
    }
    if let Ok(p) = std::env::var("PROFILE") {
        options.profile = Profile::named(&p).ok_or("there is no such profile")?;
    }
    if let Ok(p) = std::env::var("THREADS") {
        options.threads = p.parse()?;
    }
    if let Ok(p) = std::env::var("GROUP") {
        options.mesh.group = p.parse()?;
    }
    if std::env::var("POINTS").is_ok_and(|home| home == "owner") {
        options.mesh.points = PointHome::Owner;
    }
    if let Ok(p) = std::env::var("SEED") {
        options.mesh.settings.seed = p.parse()?;
    }
    options.mesh.memory = memory << 10;
    options.mesh.schedule = match text(5, "hybrid").as_str() {
        "demand" => Schedule::Demand,
        "data" => Schedule::Data,
        _ => Schedule::Hybrid,
    };
    let only = std::env::var("ONLY").unwrap_or_default();
    if !only.is_empty() {
        for _ in 0..std::env::var("REPEAT").map_or(1, |n| n.parse().unwrap_or(1)) {
            let begin = cpu_time::ProcessTime::now();
            let virtual_ns = if only == "mesh" {
                simulated(&file, &options)?.report.virtual_ns
            } else {
                rendered(&file, &options)?;
                0
            };
            println!("{only} {:.3} s, virtual {virtual_ns}", begin.elapsed().as_secs_f64());
        }
        return Ok(());
    }
    if let Ok(pairs) = std::env::var("PAIRS") {
        let mut all = [0.0; 4];
        for _ in 0..pairs.parse()? {
            let clocks = || (cpu_time::ProcessTime::now(), Instant::now());
            let past = |(processor, wall): (cpu_time::ProcessTime, Instant)| {
                (processor.elapsed().as_secs_f64(), wall.elapsed().as_secs_f64())
            };
            let begin = clocks();
            simulated(&file, &options)?;
            let mesh = past(begin);
            let begin = clocks();
            rendered(&file, &options)?;
            let plain = past(begin);
            println!("mesh {:.3} s, {:.3} of processors", mesh.1, mesh.0);
            println!("plain {:.3} s, {:.3} of processors", plain.1, plain.0);
            let took = [mesh.0, plain.0, mesh.1, plain.1];
            all.iter_mut().zip(took).for_each(|(all, took)| *all += took);
        }
        let [mesh_processors, plain_processors, mesh, plain] = all;
        println!("ratio of times {:.3}", mesh / plain);
        println!("ratio of processors' times {:.3}", mesh_processors / plain_processors);
        return Ok(());
    }
    // What is there once, whatever the number of nodes, is there before.
    let mut few = options.clone();
    few.mesh.topology = Topology::Full { nodes: 2 };
    simulated(&file, &few)?;
    let before = resident_peak();
    let begin = Instant::now();
    let outcome = simulated(&file, &options)?;
    let mesh = begin.elapsed().as_secs_f64();
    if let (Some(before), Some(after)) = (before, resident_peak()) {
        let each = (after - before) / u64::from(nodes).saturating_sub(2).max(1);
        println!(
            "resident: {} KiB more than before, {each} bytes a node, {} beside its arena",
            (after - before) >> 10,
            each as i64 - options.mesh.memory as i64
        );
    }
    let begin = Instant::now();
    let picture = rendered(&file, &options)?;
    let plain = begin.elapsed().as_secs_f64();
    let report = &outcome.report;
    let same = outcome.picture.pixels == picture.pixels;
    println!("{} blocks; complete {}, same {same}", file.blocks(), outcome.is_complete());
    println!("wall: mesh {mesh:.3} s, plain {plain:.3} s, ratio {:.3}", mesh / plain);
    let all = report.virtual_ns as f64 * f64::from(report.mesh.nodes);
    println!(
        "virtual {:.3} ms, one core {:.3} ms, events {}, packets {}, control {}, link bytes {}",
        report.virtual_ns as f64 / 1e6,
        plain * 1e3,
        report.events,
        report.totals.packets,
        report.totals.control_packets,
        report.totals.link_bytes
    );
    for (name, ns) in report.totals.time.parts() {
        println!("  {name:<14} {:6.2} %", 100.0 * ns as f64 / all);
    }
    let steps: u64 = report.nodes.iter().map(|node| node.steps).sum();
    println!("steps {steps}; {:?}", report.totals.counts);
    println!("host: {:?}", report.tiles);
    if options.mesh.group > 0 {
        let masters = report.nodes.iter().step_by(options.mesh.group.into());
        let (mut sent, mut received) = (0, 0);
        for node in masters {
            sent += node.counts.sent.tile.count;
            received += node.counts.received.tile.count;
        }
        println!("messages of sub-masters about tiles: {sent} sent, {received} received");
    }
    println!("{:?}", report.totals.work);
    println!("{:?}", report.latencies);
    let mut fetches: Vec<u64> =
        report.nodes.iter().map(|n| n.counts.received.fetch.count).collect();
    fetches.sort_unstable();
    println!("fetches served by a node: {fetches:?}");
    let mut busy: Vec<u64> =
        report.links.iter().map(|l| l.busy_ns * 100 / report.virtual_ns.max(1)).collect();
    busy.sort_unstable();
    println!("links busy %: {busy:?}");
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

fn rendered(
    file: &KiloView<'_>,
    options: &Options,
) -> Result<kiloray_render::Picture, kiloray_render::Error> {
    let MeshOptions { width, height, settings, .. } = options.mesh;
    let plain = kiloray_render::Options {
        settings,
        threads: 1,
        ..kiloray_render::Options::new(width, height, options.view)
    };
    let cancel = AtomicBool::new(false);
    let control = kiloray_render::Control { cancel: &cancel, progress: &|_, _| {} };
    Ok(kiloray_render::render(file, &plain, &control)?.picture)
}
