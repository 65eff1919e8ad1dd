//! Compiles a mesh and prints what came out: bytes, fill, depth, times and peak memory, and how many
//! nodes, records and blocks rays visit.
//!
//! `cargo run --release -p kiloray-scene --example compile_stats -- MESH [BLOCK_KIB..]`, with a
//! `.ktri` or `.obj` file, or a number: a sinc field of about so many triangles.

mod mesh;
mod visits;

use std::error::Error;

use kiloray_scene::compile::{Options, compile};
use kiloray_scene::kilo::KiloFile;

fn main() -> Result<(), Box<dyn Error>> {
    let mut args = std::env::args().skip(1);
    let mesh = args.next().ok_or("which mesh?")?;
    let mut kib: Vec<usize> = args.map(|a| a.parse()).collect::<Result<_, _>>()?;
    if kib.is_empty() {
        kib = vec![4, 16];
    }
    let (model, camera) = mesh::load(&mesh)?;
    for kib in kib {
        let before = peak_kib();
        let options = Options { block_bytes: kib << 10 };
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
        visits::count(&file.view(), &camera);
    }
    Ok(())
}

/// Peak memory of this process [KiB], where the system tells.
fn peak_kib() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find(|line| line.starts_with("VmHWM:"));
    line.and_then(|line| line.split_whitespace().nth(1)?.parse().ok()).unwrap_or(0)
}
