//! Visibility against Embree, paired in one run: primary, diffuse bounce and shadow rays, one thread.
//!
//! ```text
//! bench_visibility --peers DIR [--mesh FILE.obj|FILE.ktri] [--work DIR] [--size 1024] [--rounds 3]
//!                  [--block-bytes 16384] [--mapped] [--only NAME]
//! ```
//! `DIR` holds `embree_bench.cpp` and `gen_mesh.py`; they are built and run in `--work`
//! (`target/visibility`). Without `--peers` it traces the rays that an earlier run has left there,
//! and prints no ratios. In each round either side takes the median of five passes over the same rays, ours right after theirs, and the ratio is the median
//! of those of the rounds. Rates are of the CPU time of the thread, medians over the rounds; beside them stands the best pass of all, which others on a shared
//! machine delayed least.

mod count;
mod embree;
mod mesh;
mod rates;
mod rays;
mod trace;

use std::path::PathBuf;

use kiloray_scene::compile::{Options, compile};

use crate::rays::KINDS;

fn main() {
    if let Err(error) = run() {
        eprintln!("bench_visibility: {error}");
        std::process::exit(1);
    }
}

type Error = Box<dyn std::error::Error>;

struct Arguments {
    peers: Option<PathBuf>,
    mesh: Option<PathBuf>,
    work: PathBuf,
    size: u32,
    rounds: usize,
    block_bytes: usize,
    mapped: bool,
    only: Option<String>,
}

fn arguments() -> Result<Arguments, Error> {
    let mut a = Arguments {
        peers: None,
        mesh: None,
        work: PathBuf::from("target/visibility"),
        size: 1024,
        rounds: 3,
        block_bytes: 16 << 10,
        mapped: false,
        only: None,
    };
    let mut args = std::env::args().skip(1);
    while let Some(name) = args.next() {
        let mut value = || args.next().ok_or(format!("{name} needs a value"));
        match name.as_str() {
            "--peers" => a.peers = Some(value()?.into()),
            "--mesh" => a.mesh = Some(value()?.into()),
            "--work" => a.work = value()?.into(),
            "--size" => a.size = value()?.parse()?,
            "--rounds" => a.rounds = value()?.parse::<usize>()?.max(1),
            "--block-bytes" => a.block_bytes = value()?.parse()?,
            "--mapped" => a.mapped = true,
            "--only" => a.only = Some(value()?),
            _ => return Err(format!("unknown argument {name}").into()),
        }
    }
    Ok(a)
}

fn run() -> Result<(), Error> {
    let a = arguments()?;
    let ways = trace::Way::all(a.only.as_deref());
    if ways.is_empty() {
        return Err("--only: single, batch, bundle and 'single, scalar' are ways".into());
    }
    std::fs::create_dir_all(&a.work)?;
    let ktri = mesh::prepare(a.mesh.as_deref(), a.peers.as_deref(), &a.work)?;
    let file = ktri.with_extension("rays");
    let peer = a.peers.as_deref().map(|peers| embree::Bench::build(peers, &a.work)).transpose()?;
    if let Some(peer) = &peer {
        peer.write_rays(&ktri, a.size, &file)?;
    }
    let mesh = mesh::read(&ktri)?;
    let options = Options::blocks_of(a.block_bytes);
    let compiled = compile(&mesh, &options, &mut ())?;
    let sets = rays::read(&file, &compiled.header().frame)?;
    let scene = trace::Scene::new(compiled.bytes(), &a.work, a.mapped)?;
    let per_triangle = |bytes: usize| bytes as f64 / mesh.triangles.len() as f64;
    println!(
        "{}: {} triangles, {} blocks of {} bytes, {:.1} bytes per triangle and {:.1} for the top, expanded; lanes {}",
        ktri.display(),
        mesh.triangles.len(),
        compiled.header().blocks,
        a.block_bytes,
        per_triangle(compiled.bytes().len()),
        per_triangle(scene.top.bytes()),
        kiloray_simd::Auto::detect().name(),
    );
    trace::count(&scene, &sets)?;
    let rivals: Vec<_> = ways.iter().map(|way| way.rival).collect();
    let (mut ours, mut theirs) = (trace::Table::default(), embree::Table::default());
    for _ in 0..a.rounds {
        if let Some(peer) = &peer {
            peer.run(&ktri, a.size, &rivals, &mut theirs, |rival, kind| {
                let mut held = ways.iter().filter(|way| way.rival == rival);
                held.try_for_each(|&way| trace::run(&scene, &sets, kind, way, &mut ours))
            })?;
        } else {
            for &way in &ways {
                for kind in KINDS {
                    trace::run(&scene, &sets, kind, way, &mut ours)?;
                }
            }
        }
    }
    theirs.print();
    ours.print(&theirs);
    Ok(())
}
