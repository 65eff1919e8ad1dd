//! Visibility against Embree, paired in one run: primary, diffuse bounce and shadow rays, one thread.
//!
//! ```text
//! bench_visibility --peers DIR [--mesh FILE.obj|FILE.ktri] ..
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

use clap::Parser;
use kiloray_scene::compile::{Options, compile};

use crate::rays::KINDS;

fn main() {
    if let Err(error) = run() {
        eprintln!("bench_visibility: {error}");
        std::process::exit(1);
    }
}

type Error = Box<dyn std::error::Error>;

/// Visibility against Embree, paired in one run: primary, diffuse bounce and shadow rays, one thread.
#[derive(Parser)]
struct Arguments {
    /// Where `embree_bench.cpp` and `gen_mesh.py` are; without it the rays are traced that an earlier run has left, and there are no ratios.
    #[arg(long, value_name = "DIR")]
    peers: Option<PathBuf>,
    /// An `.obj` or `.ktri` file; without it a field of a million triangles.
    #[arg(long, value_name = "FILE")]
    mesh: Option<PathBuf>,
    /// Where programs are built and rays are left.
    #[arg(long, value_name = "DIR", default_value = "target/visibility")]
    work: PathBuf,
    /// Pixels along the picture.
    #[arg(long, default_value_t = 1024)]
    size: u32,
    /// Rounds, in each of which either side makes five passes.
    #[arg(long, default_value_t = 3, value_parser = clap::value_parser!(u16).range(1..))]
    rounds: u16,
    /// Size of a block.
    #[arg(long, value_name = "BYTES", default_value_t = 16 << 10)]
    block_bytes: usize,
    /// Blocks come from a mapped file, and not from memory.
    #[arg(long)]
    mapped: bool,
    /// One way of tracing: `single`, `batch`, `bundle` or `single, scalar`.
    #[arg(long, value_name = "WAY")]
    only: Option<String>,
}

fn run() -> Result<(), Error> {
    let a = Arguments::parse();
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
