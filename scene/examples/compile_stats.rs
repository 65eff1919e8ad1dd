//! Compiles a mesh and prints what came out: bytes, fill, depth, times and peak memory.
//!
//! `cargo run --release -p kiloray-scene --example compile_stats -- MESH [BLOCK_KIB..]`, with a
//! `.ktri` or `.obj` file, or a number: a sinc field of about so many triangles.

use std::error::Error;

use glam::DVec3;
use kiloray_scene::compile::{Options, compile};
use kiloray_scene::kilo::KiloFile;
use kiloray_scene::model::{Material, Model, NO_NORMAL, Triangle};

fn main() -> Result<(), Box<dyn Error>> {
    let mut args = std::env::args().skip(1);
    let mesh = args.next().ok_or("which mesh?")?;
    let mut kib: Vec<usize> = args.map(|a| a.parse()).collect::<Result<_, _>>()?;
    if kib.is_empty() {
        kib = vec![4, 16];
    }
    let model = if mesh.ends_with(".ktri") {
        ktri(&std::fs::read(&mesh)?).ok_or("not a KTRI file")?
    } else if mesh.ends_with(".obj") {
        obj(&std::fs::read_to_string(&mesh)?)?
    } else {
        sinc(mesh.parse()?)
    };
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
        KiloFile::from_bytes(compiled.bytes())?;
        println!("checked in {:.0} ms", start.elapsed().as_secs_f64() * 1e3);
    }
    Ok(())
}

fn model(vertices: Vec<DVec3>, corners: impl Iterator<Item = [u32; 3]>) -> Model {
    let triangles = corners
        .map(|vertices| Triangle { vertices, normals: [NO_NORMAL; 3], material: 0 })
        .collect();
    Model { materials: vec![Material::default()], vertices, triangles, ..Model::default() }
}

fn ktri(bytes: &[u8]) -> Option<Model> {
    let word = |at: usize| Some(u32::from_le_bytes(*bytes.get(at..)?.first_chunk()?));
    let (vertices, triangles) = (word(4)? as usize, word(8)? as usize);
    let xyz = 12 + 13 * 4;
    let real = |at: usize| Some(f64::from(f32::from_bits(word(at)?)));
    let points = (0..vertices)
        .map(|i| xyz + 12 * i)
        .map(|at| Some(DVec3::new(real(at)?, real(at + 4)?, real(at + 8)?)))
        .collect::<Option<_>>()?;
    let ijk = xyz + 12 * vertices;
    let corners: Vec<[u32; 3]> = (0..triangles)
        .map(|i| ijk + 12 * i)
        .map(|at| Some([word(at)?, word(at + 4)?, word(at + 8)?]))
        .collect::<Option<_>>()?;
    Some(model(points, corners.into_iter()))
}

fn obj(text: &str) -> Result<Model, Box<dyn Error>> {
    let (mut points, mut corners) = (Vec::new(), Vec::new());
    for line in text.lines() {
        let mut words = line.split_whitespace();
        match words.next() {
            Some("v") => {
                let v: Vec<f64> = words.map(str::parse).collect::<Result<_, _>>()?;
                points.push(DVec3::from_slice(&v));
            }
            Some("f") => {
                let index = |word: &str| word.split('/').next().unwrap_or("").parse::<u32>();
                let v: Vec<u32> = words.map(index).collect::<Result<_, _>>()?;
                corners.extend((2..v.len()).map(|i| [v[0] - 1, v[i - 1] - 1, v[i] - 1]));
            }
            _ => {}
        }
    }
    Ok(model(points, corners.into_iter()))
}

fn sinc(triangles: usize) -> Model {
    let n = ((triangles / 2) as f64).sqrt().ceil().max(1.0) as u32;
    let points = (0..=n).flat_map(|i| {
        (0..=n).map(move |j| {
            let (x, y) = (f64::from(i) / f64::from(n) - 0.5, f64::from(j) / f64::from(n) - 0.5);
            let r = 40.0 * x.hypot(y);
            DVec3::new(x, y, if r > 0.0 { r.sin() / r } else { 1.0 })
        })
    });
    let corners = (0..n * n).flat_map(|k| {
        let a = k / n * (n + 1) + k % n;
        [[a, a + n + 1, a + 1], [a + 1, a + n + 1, a + n + 2]]
    });
    model(points.collect(), corners)
}

/// Peak memory of this process [KiB], where the system tells.
fn peak_kib() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find(|line| line.starts_with("VmHWM:"));
    line.and_then(|line| line.split_whitespace().nth(1)?.parse().ok()).unwrap_or(0)
}
