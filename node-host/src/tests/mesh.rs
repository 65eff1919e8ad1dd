//! Meshes of threads, joined by an [`Exchange`]: all of a process apart from the network and the processes.

use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Instant;

use kiloray_core::network::{HOST, NodeId, Router, Topology};
use kiloray_core::node::{Node, Picture, Time};
use kiloray_core::shade::Settings;
use kiloray_core::store::{Arena, CHUNK_BYTES, Chunk};
use kiloray_mesh::MeshOptions;
use kiloray_render::{MeshNode, ThreadScratch};
use kiloray_scene::builtin;
use kiloray_scene::compile::{self, compile};
use kiloray_scene::kilo::KiloFile;
use kiloray_simd::Auto;

use crate::drive::Drive;
use crate::host::HostEnd;
use crate::{Config, Exchange, Job, Place, drive};

pub(super) fn scene(name: &str) -> KiloFile {
    let model = builtin::build(name).expect("a built-in scene");
    let options = compile::Options::blocks_of(1024);
    KiloFile::from_compiled(compile(&model, &options, &mut ()).expect("it compiles"))
}

pub(super) fn config(file: &KiloFile, nodes: usize, topology: &str, memory: usize) -> Config {
    let joined = Topology::parse(topology, nodes as u32).expect("a topology");
    let options = MeshOptions {
        settings: Settings {
            samples: 1,
            shadow_samples: 1,
            lights: 64,
            bounces: 4,
            seed: u64::MAX,
        },
        memory,
        tile: Some(4),
        ..MeshOptions::new(24, 20, joined)
    };
    let addresses = vec![String::new(); nodes];
    Config::new("scene.kilo".into(), addresses, topology, &options, file.view().views()[0])
}

/// What `render` makes of it.
pub(super) fn reference(file: &KiloFile, job: &Job) -> Vec<[f32; 3]> {
    let (width, height) = (job.options.width, job.options.height);
    let alone = kiloray_render::Options::new(width, height, file.view().views()[0]);
    let options = kiloray_render::Options { settings: job.options.settings, threads: 1, ..alone };
    let cancel = AtomicBool::new(false);
    let control = kiloray_render::Control { cancel: &cancel, progress: &|_, _| {} };
    let rendered = kiloray_render::render(&file.view(), &options, &control);
    rendered.expect("a picture").picture.pixels
}

/// A node's life until it is `over`.
fn run_node(job: &Job, file: &KiloFile, here: NodeId, exchange: &Exchange, over: &AtomicBool) {
    let file = file.view();
    let mut chunks = vec![Chunk::ZERO; job.options.memory / CHUNK_BYTES];
    let world =
        Picture::new(Auto::detect(), job.shader(&file), job.camera, job.tiling(), file.limits())
            .working_in(ThreadScratch { together: true });
    let at = usize::from(here.0);
    let (plan, budget) = (&job.layout.plans[at], job.layout.budgets[at]);
    let rom = job.layout.rom(&file, here);
    let mut arena = Arena::new(&mut chunks);
    let node =
        Node::new(&mut arena, plan, budget, job.layout.settings, rom, job.mesh, world).unwrap();
    let mut node = MeshNode(node);
    let mut wire = exchange.join(Place::new(here));
    let settings = Drive::new(Instant::now(), job, Place::new(here));
    drive(&mut node, &mut wire, &settings, |_, _| over.load(Ordering::Relaxed));
}

/// The picture of a mesh of threads. Node `victim` is replaced by another each time so many more pixels are there.
fn picture(job: &Job, file: &KiloFile, victim: Option<(NodeId, u64)>) -> (Vec<[f32; 3]>, u32) {
    let exchange = Exchange::new(job.mesh);
    let over: Vec<AtomicBool> = (0..job.mesh.nodes()).map(|_| AtomicBool::new(false)).collect();
    let size = job.layout.host_router(&job.mesh);
    let mut chunks = vec![Chunk::ZERO; size.arena_bytes() / CHUNK_BYTES];
    let mut host = HostEnd {
        router: Router::new(&mut Arena::new(&mut chunks), job.mesh, HOST, size).unwrap(),
        ledger: job.layout.ledger(&file.view(), &job.options).unwrap(),
    };
    let mut replaced = 0;
    thread::scope(|scope| {
        let start = |node: NodeId| {
            let (exchange, over) = (&exchange, &over[usize::from(node.0)]);
            scope.spawn(move || run_node(job, file, node, exchange, over))
        };
        let mut threads: Vec<_> = job.nodes().map(|node| Some(start(node.id()))).collect();
        let mut wire = exchange.join(Place::HOST);
        let settings = Drive::new(Instant::now(), job, Place::HOST);
        drive(&mut host, &mut wire, &settings, |host, _| {
            if let Some((node, pixels)) = victim
                && host.ledger.pixels_done() >= pixels * (u64::from(replaced) + 1)
            {
                let at = usize::from(node.0);
                over[at].store(true, Ordering::Relaxed);
                threads[at].take().unwrap().join().unwrap();
                over[at].store(false, Ordering::Relaxed);
                threads[at] = Some(start(node));
                replaced += 1;
            }
            host.ledger.is_complete() || host.ledger.lost().is_some()
        });
        over.iter().for_each(|over| over.store(true, Ordering::Relaxed));
    });
    assert_eq!((host.ledger.lost(), host.ledger.counts().differing), (None, 0));
    (host.ledger.picture().pixels, replaced)
}

#[test]
fn threads_give_the_bits_of_one_node() {
    let file = scene("glass");
    for (nodes, topology, memory) in
        [(1, "full", 1 << 16), (5, "full", 1 << 16), (4, "ring", 1 << 15)]
    {
        let config = config(&file, nodes, topology, memory);
        let job = Job::new(&config, &file.view()).unwrap();
        let (pixels, _) = picture(&job, &file, None);
        assert!(pixels == reference(&file, &job), "{nodes} {topology}");
    }
}

#[test]
fn a_node_that_is_replaced_again_and_again_costs_no_pixel() {
    let file = scene("glass");
    // One that all packets of the host pass through, and one that only has blocks.
    for victim in [0, 1] {
        let mut job = Job::new(&config(&file, 3, "line", 1 << 16), &file.view()).unwrap();
        // What is lost is asked for again soon.
        job.layout.settings.patience = Time(20_000_000);
        let (pixels, replaced) = picture(&job, &file, Some((NodeId(victim), 60)));
        assert!(pixels == reference(&file, &job), "{victim}");
        assert!(replaced > 3, "{replaced}");
    }
}
