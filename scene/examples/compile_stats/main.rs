//! Compiles a mesh and prints what came out: bytes, fill, depth, times and peak memory, and how many
//! nodes, records and blocks rays visit.
//!
//! `cargo run --release -p kiloray-scene --example compile_stats -- MESH [BLOCK_KIB..] [--smooth]
//! [--rays]`, with a `.ktri` or `.obj` file, or a number: a sinc field of about so many triangles.
//! `--smooth` adds shading normals and eight materials, `--rays` counts visits. On one core: set
//! `RAYON_NUM_THREADS=1`.

mod mesh;
mod visits;

use std::error::Error;

use kiloray_scene::compile::{Options, compile};
use kiloray_scene::kilo::KiloFile;

fn main() -> Result<(), Box<dyn Error>> {
    let (flags, args): (Vec<_>, Vec<_>) =
        std::env::args().skip(1).partition(|arg| arg.starts_with("--"));
    let smooth = flags.iter().any(|flag| flag == "--smooth");
    let rays = flags.iter().any(|flag| flag == "--rays");
    let mut args = args.into_iter();
    let mesh = args.next().ok_or("which mesh?")?;
    let mut kib: Vec<usize> = args.map(|a| a.parse()).collect::<Result<_, _>>()?;
    if kib.is_empty() {
        kib = vec![4, 16];
    }
    let (mut model, camera) = mesh::load(&mesh)?;
    if smooth {
        mesh::smooth(&mut model);
    }
    for kib in kib {
        let before = peak_kib();
        let options = Options::blocks_of(kib << 10);
        let compiled = compile(&model, &options, &mut ())?;
        let stats = compiled.stats.clone();
        println!("{stats}");
        let peak = peak_kib() * 1024 / stats.triangles.max(1);
        println!(
            "peak of the process {peak} bytes per triangle, {} before",
            before * 1024 / stats.triangles.max(1)
        );
        let start = std::time::Instant::now();
        let file = KiloFile::from_bytes(compiled.bytes())?;
        println!("checked in {:.0} ms", start.elapsed().as_secs_f64() * 1e3);
        if rays {
            visits::count(&file.view(), &camera);
        }
    }
    Ok(())
}

/// Peak memory of this process \[KiB\], where the system tells.
fn peak_kib() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find(|line| line.starts_with("VmHWM:"));
    line.and_then(|line| line.split_whitespace().nth(1)?.parse().ok()).unwrap_or(0)
}
