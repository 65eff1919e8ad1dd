//! Long runs against the oracle. `stress --help` says what there is.

use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};

use clap::{Parser, Subcommand};
use indicatif::{ProgressBar, ProgressStyle};
use kiloray_scene::import::{ImportOptions, load};
use kiloray_tests::stress::hits::{self, Counts};
use kiloray_tests::stress::{leaks, scales};
use rayon::prelude::*;

/// Traces random rays and holds what is found against an oracle in f64.
#[derive(Parser)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Closest hits over random scenes: hit or miss may differ from the truth only where the exact ray passes an edge within
    /// the derived bound, and `t` only by its bound.
    Hits {
        /// Rays in all.
        #[arg(long, default_value_t = 1_000_000_000)]
        rays: u64,
        /// Scenes, of up to about a thousand primitives each.
        #[arg(long, default_value_t = 8000)]
        scenes: u64,
        /// Makes the run again.
        #[arg(long, default_value_t = 1)]
        seed: u64,
        /// Only this scene of the run.
        #[arg(long)]
        scene: Option<u64>,
    },
    /// Rays from inside closed meshes: none may get out. Meshes that are not closed are named and left out.
    Leaks {
        /// Meshes (.obj).
        #[arg(required = true)]
        meshes: Vec<PathBuf>,
        /// Rays in all.
        #[arg(long, default_value_t = 100_000_000)]
        rays: u64,
        /// Makes the run again.
        #[arg(long, default_value_t = 1)]
        seed: u64,
    },
    /// A scene a million times smaller and larger, and ten thousand sizes away: errors against what f32 allows.
    Scales {
        /// Rays of each row.
        #[arg(long, default_value_t = 1_000_000)]
        rays: u64,
    },
}

fn main() -> ExitCode {
    let result = match Arguments::parse().command {
        Command::Hits { rays, scenes, seed, scene } => hits(rays, scenes.max(1), seed, scene),
        Command::Leaks { meshes, rays, seed } => leaks(&meshes, rays, seed),
        Command::Scales { rays } => scales(rays),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("error: {message}");
            ExitCode::FAILURE
        }
    }
}

fn bar(len: u64, what: &str) -> ProgressBar {
    let template = format!("{{bar:40}} {{human_pos}} of {{human_len}} {what}, {{eta}} left");
    let style =
        ProgressStyle::with_template(&template).unwrap_or_else(|_| ProgressStyle::default_bar());
    ProgressBar::new(len).with_style(style)
}

fn hits(rays: u64, scenes: u64, seed: u64, only: Option<u64>) -> Result<(), String> {
    let numbers = only.map_or(0..scenes, |n| n..n + 1);
    let each = rays.div_ceil(scenes);
    let bar = bar(numbers.end - numbers.start, "scenes");
    let counts: Vec<Counts> = numbers
        .into_par_iter()
        .map(|number| {
            let counts = hits::run(seed, number, each).map_err(|failure| failure.to_string());
            bar.inc(1);
            counts
        })
        .collect::<Result<_, _>>()?;
    bar.finish_and_clear();
    let all = counts.into_iter().fold(Counts::default(), Counts::plus);
    println!(
        "{} rays over {} scenes of {} primitives, seed {seed}: {} hits, {} within the bounds of an edge or of each other, 0 wrong",
        all.rays, all.scenes, all.primitives, all.hits, all.within_bounds
    );
    Ok(())
}

fn leaks(paths: &[PathBuf], rays: u64, seed: u64) -> Result<(), String> {
    let mut closed = Vec::new();
    for path in paths {
        let model = load(&[path], &ImportOptions::default()).map_err(|e| e.to_string())?;
        let open = leaks::open_edges(&model);
        if open == 0 && !model.triangles.is_empty() {
            println!("{}: closed, {} triangles", path.display(), model.triangles.len());
            closed.push((path, leaks::Mesh::new(&model)?));
        } else {
            println!("{}: not closed, {open} open edges: left out", path.display());
        }
    }
    if closed.is_empty() {
        return Err("none of these meshes is closed".into());
    }
    const ROUNDS: u64 = 64;
    let each = rays.div_ceil(closed.len() as u64 * ROUNDS);
    let bar = bar(closed.len() as u64 * ROUNDS, "parts");
    let shot = AtomicU64::new(0);
    let leak = Mutex::new(None);
    let work: Vec<_> = closed.iter().flat_map(|mesh| (0..ROUNDS).map(move |r| (mesh, r))).collect();
    work.into_par_iter().for_each(|((path, mesh), round)| {
        match mesh.shoot(seed.wrapping_mul(1_000_003) ^ round, each) {
            Ok(n) => _ = shot.fetch_add(n, Ordering::Relaxed),
            Err(found) => {
                if let Ok(mut leak) = leak.lock() {
                    *leak = Some(format!("{}: {found:?}", path.display()));
                }
            }
        }
        bar.inc(1);
    });
    bar.finish_and_clear();
    match leak.into_inner() {
        Ok(None) => {
            let rays = shot.into_inner();
            println!("{rays} rays from inside {} meshes, seed {seed}: no leak", closed.len());
            Ok(())
        }
        Ok(Some(leak)) => Err(format!("a ray got out, seed {seed}: {leak}")),
        Err(_) => Err("a thread has failed".into()),
    }
}

fn scales(rays: u64) -> Result<(), String> {
    println!("{:>8} {:>8} {:>10} {:>12} {:>12}", "size", "offset", "hits", "worst", "allowed");
    for size in [1e-6, 1.0, 1e6] {
        for offset in [0.0, 1e4] {
            let row = scales::measure(size, offset, rays)?;
            println!(
                "{:>8.0e} {:>8.0e} {:>10} {:>12.2e} {:>12.2e}",
                row.size, row.offset, row.hits, row.worst, row.allowed
            );
        }
    }
    Ok(())
}
