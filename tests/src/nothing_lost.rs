//! Random small runs on a simulated mesh: each ends with the bits of one machine, or names a block of which no copy is left.

use std::fmt;
use std::ops::{ControlFlow, Range};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};

use fastrand::Rng;
use glam::DVec3;
use kiloray_core::network::{NodeId, Topology};
use kiloray_core::node::{
    Dealing, Placement, PointHome, Prefetch, Schedule, ShadowPolicy, TaskOrder,
};
use kiloray_core::scene::LightKind;
use kiloray_scene::kilo::KiloFile;
use kiloray_scene::model::{Light, Model};
use kiloray_scene::{builtin, compile};
use kiloray_sim::{
    Control, Crash, Faults, Link, MeshOptions, Options, Profile, Rate, Slow, Switching, least,
    plan, simulate,
};

use crate::pool;
use crate::reference::{bits, one_thread};

/// Scenes that are drawn from.
const SCENES: [&str; 5] = ["cornell", "glass", "colour-cube:4", "sinc:12", "lamps"];
/// Sizes of blocks \[bytes\].
const BLOCKS: [usize; 2] = [1 << 10, 4 << 10];
/// Longer than any of these runs takes, all time limits of slow machines included, virtual time \[ns\]. Of 60,000 the longest that loses one packet in
/// 20 took 48 minutes; where one in five is lost on each link, 998 of 1,000 answers from the other end of a line of 14, it was 16 hours.
const LONGEST: u64 = 2 * HOUR;
const LONGEST_OF_MUCH_LOSS: u64 = 96 * HOUR;
const HOUR: u64 = 3_600_000_000_000;

/// The scenes, compiled.
#[derive(Debug)]
pub struct Scenes(Vec<(&'static str, usize, KiloFile)>);

impl Scenes {
    /// Compiles them.
    ///
    /// # Errors
    /// What the compiler says.
    pub fn new() -> Result<Self, String> {
        let mut scenes = Vec::new();
        for name in SCENES {
            let model = match name {
                "lamps" => builtin::build("cornell").map(under_many_lamps),
                _ => builtin::build(name),
            };
            let model = model.map_err(|e| e.to_string())?;
            for block_bytes in BLOCKS {
                let compiled =
                    compile::compile(&model, &compile::Options::blocks_of(block_bytes), &mut ());
                let compiled = compiled.map_err(|e| e.to_string())?;
                debug_assert!(name != "lamps" || compiled.summary.lights > 64);
                scenes.push((name, block_bytes, KiloFile::from_compiled(compiled)));
            }
        }
        Ok(Self(scenes))
    }
}

/// A scene in which 120 small lamps hang all over, facing anywhere: so many have a tree.
fn under_many_lamps(mut model: Model) -> Model {
    let mut random = Rng::with_seed(8);
    let (lo, hi) = model
        .vertices
        .iter()
        .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(lo, hi), v| (lo.min(*v), hi.max(*v)));
    let mut within = || DVec3::from_array([0; 3].map(|_| random.f64()));
    for k in 0..120 {
        let [u, v] = [within(), within()].map(|v| (v - 0.5) * (hi - lo) * 0.04);
        model.lights.push(Light {
            kind: if k % 3 == 0 { LightKind::Triangle } else { LightKind::Parallelogram },
            material: None,
            reach: f64::INFINITY,
            position: lo + (hi - lo) * within(),
            u,
            v,
            radiance: DVec3::splat(100.0),
            cone: None,
        });
    }
    model
}

/// How a run ended as it should.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum End {
    /// With the picture.
    Complete,
    /// With the name of a block all of whose holders had died.
    Lost,
}

/// A run that went wrong.
#[derive(Debug)]
pub struct Failure {
    seed: u64,
    run: u64,
    what: String,
    scene: String,
    options: Box<Options>,
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { seed, run, what, scene, options } = self;
        writeln!(f, "{what}")?;
        writeln!(f, "{scene}, {options:?}")?;
        write!(
            f,
            "again: cargo run --release -p kiloray-tests --bin nothing_lost -- --seed {seed} --run {run}"
        )
    }
}

/// Runs of a seed, by number, on so many threads: how many of them have lost a block. `done` is called after each.
///
/// # Errors
/// [`Failure`]: one that went wrong; the others are left then.
pub fn all(
    scenes: &Scenes,
    seed: u64,
    runs: Range<u64>,
    threads: usize,
    done: &(dyn Fn() + Sync),
) -> Result<u64, Failure> {
    let (lost, failure) = (AtomicU64::new(0), Mutex::new(None));
    pool::each(runs, threads, &|number| match run(scenes, seed, number) {
        Ok(end) => {
            lost.fetch_add(u64::from(end == End::Lost), Ordering::Relaxed);
            done();
            ControlFlow::Continue(())
        }
        Err(found) => {
            *failure.lock().unwrap_or_else(PoisonError::into_inner) = Some(found);
            ControlFlow::Break(())
        }
    });
    match failure.into_inner().unwrap_or_else(PoisonError::into_inner) {
        Some(failure) => Err(failure),
        None => Ok(lost.into_inner()),
    }
}

/// One run of a seed.
///
/// # Errors
/// [`Failure`]: another picture, none, a wrong cause, a panic, or no end.
pub fn run(scenes: &Scenes, seed: u64, run: u64) -> Result<End, Failure> {
    let mut random = Rng::with_seed(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ run);
    let (name, block_bytes, file) = &scenes.0[random.usize(..scenes.0.len())];
    let options = drawn(&mut random, file);
    let ended = catch_unwind(AssertUnwindSafe(|| check(file, &options)));
    let ended = ended.unwrap_or_else(|_| Err("it panics".into()));
    ended.map_err(|what| {
        let scene = format!("{name}, blocks of {block_bytes} bytes");
        Failure { seed, run, what, scene, options: Box::new(options.clone()) }
    })
}

fn one_of<T: Clone>(random: &mut Rng, all: &[T]) -> T {
    all[random.usize(..all.len())].clone()
}

/// What a seed makes of a run.
fn drawn(random: &mut Rng, file: &KiloFile) -> Options {
    let (topology, nodes) = loop {
        let nodes = random.u16(1..=16);
        let shapes = ["line", "ring", "mesh", "torus", "hypercube", "tree:2", "tree:3", "full"];
        let shape = one_of(random, &shapes);
        if let Ok(topology) = Topology::parse(shape, nodes.into()) {
            break (topology, nodes);
        }
    };
    let (width, height) = (random.u32(1..=20), random.u32(1..=20));
    let mut options = Options::new(width, height, file.view().views()[0], topology);
    options.threads = 1;
    options.mesh.settings.samples = random.u32(1..=2);
    options.mesh.settings.shadow_samples = random.u16(1..=2);
    options.mesh.settings.bounces = random.u8(0..=6);
    options.mesh.settings.seed = random.u64(..);
    options.seed = random.u64(..);
    options.mesh.schedule = one_of(random, &[Schedule::Hybrid, Schedule::Demand, Schedule::Data]);
    options.mesh.shadow =
        one_of(random, &[ShadowPolicy::Keep, ShadowPolicy::Offer, ShadowPolicy::Steal]);
    options.mesh.points = one_of(random, &[PointHome::Finder, PointHome::Owner]);
    options.mesh.dealing = one_of(random, &[Dealing::Subtrees, Dealing::RoundRobin]);
    options.mesh.top = Some(random.u32(1..=3));
    options.mesh.prefetch =
        one_of(random, &[Prefetch::All, Prefetch::Nearest(0), Prefetch::Nearest(2)]);
    options.mesh.order = one_of(random, &[TaskOrder::Made, TaskOrder::Ready]);
    options.mesh.group = one_of(random, &[0, 0, 2, 4]);
    options.mesh.refusals = random.u8(0..=4);
    options.mesh.tile = one_of(random, &[None, Some(1), Some(4), Some(8)]);
    options.mesh.owned_in_arena = random.u8(..8) == 0;
    options.profile = one_of(random, &[Profile::PC, Profile::RP2350, Profile::T800]);
    options.link = Link {
        bandwidth: one_of(random, &[1_000_000, 1_000_000_000]),
        latency: one_of(random, &[100, 1_000, 50_000]),
        switching: one_of(random, &[Switching::StoreAndForward, Switching::CutThrough]),
    };
    options.faults = faults(random, nodes);
    options.mesh.replicas = match options.faults.crashes.len() {
        0 => random.u16(1..=2),
        crashes => (crashes as u16 + random.u16(0..=1)).max(1),
    };
    memory(random, file, &mut options);
    options
}

fn faults(random: &mut Rng, nodes: u16) -> Faults {
    let rates = [(0, 1), (0, 1), (1, 1000), (1, 100), (1, 20), (1, 5)];
    let [loss, duplicate] = [(); 2].map(|()| one_of(random, &rates));
    let [loss, duplicate] = [loss, duplicate].map(|(count, of)| Rate { count, of });
    let mut nodes: Vec<u16> = (0..nodes).collect();
    random.shuffle(&mut nodes);
    let most = one_of(random, &[0, 0, 1, 1, 2, 3]).min(nodes.len() - 1);
    let crashes = nodes[..most].iter().map(|&node| {
        let within = 1 << random.u32(10..=25);
        Crash { node: NodeId(node), at: random.u64(..within) }
    });
    let crashes = crashes.collect();
    Faults {
        loss,
        duplicate,
        crashes,
        jitter: one_of(random, &[0, 0, 2_000, 20_000]),
        slow: match random.u8(..4) {
            0 => vec![Slow {
                node: NodeId(nodes[nodes.len() - 1]),
                factor: random.f64() * 30.0 + 0.1,
            }],
            _ => Vec::new(),
        },
    }
}

/// From the least memory upwards.
fn memory(random: &mut Rng, file: &KiloFile, options: &mut Options) {
    options.mesh.memory = 16 << 20;
    let Ok(least) = least(&file.view(), options) else { return };
    let times = one_of(random, &[100, 100, 110, 150, 200, 400, 800]);
    options.mesh.memory = least * times / 100;
    if plan(&file.view(), options).is_err() {
        options.mesh.memory = least;
    }
}

fn check(file: &KiloFile, options: &Options) -> Result<End, String> {
    let control = Control { cancel: &AtomicBool::new(false), progress: &|_| {} };
    let outcome = simulate(&file.view(), options, &control).map_err(|e| e.to_string())?;
    let time = outcome.report.virtual_ns;
    let much = options.faults.loss == Rate { count: 1, of: 5 };
    if time > if much { LONGEST_OF_MUCH_LOSS } else { LONGEST } {
        return Err(format!("it takes {time} ns"));
    }
    if let Some(block) = outcome.lost() {
        let placement = Placement {
            dealing: options.mesh.dealing,
            blocks: file.view().blocks(),
            nodes: options.mesh.topology.nodes(),
            top: options.mesh.top.unwrap_or_default(),
            replicas: options.mesh.replicas,
        };
        let died = |node: u16| {
            options.faults.crashes.iter().any(|c| c.node == NodeId(node) && c.at <= time)
        };
        let alive = (0..options.mesh.topology.nodes())
            .find(|&n| placement.holds(NodeId(n), block) && !died(n));
        return match alive {
            Some(node) => Err(format!("block {block} counts as lost, but node {node} has it")),
            None if outcome.is_complete() => Err("it is complete, and a block is lost".into()),
            None => Ok(End::Lost),
        };
    }
    if !outcome.is_complete() {
        return Err("it is not complete, and says not why".into());
    }
    let MeshOptions { width, height, settings, .. } = options.mesh;
    match bits(&outcome.picture) == bits(&one_thread(file, width, height, options.view, settings)?)
    {
        true => Ok(End::Complete),
        false => Err("the picture differs".into()),
    }
}
