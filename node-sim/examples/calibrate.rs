//! Fits the profile `pc`: the time that one core of this machine takes to render some scenes, as a sum over the operations that a
//! simulated node counts for the same pictures. Prints the profile, and what it predicts for scenes that it has not seen.
//!
//! `cargo run --release -p kiloray-sim --example calibrate`
//!
//! The times are those of `render` with one thread, which has all blocks at hand, so that a node's operations cost what they cost there.
//! Scenes in which most light falls on glossy or clear surfaces take longer than predicted (`conference` by a tenth, `glass-cube` by more): what a
//! material does with light is counted as one operation, whatever the material.
//! Bytes checked and copied are timed by themselves, as one node does neither.

use cpu_time::{ProcessTime, ThreadTime};
use kiloray_core::network::Topology;
use kiloray_core::node::Work;
use kiloray_scene::{builtin, compile, kilo::KiloFile};
use kiloray_sim::{Control, Options, Profile, simulate};
use std::hint::black_box;
use std::sync::atomic::AtomicBool;

type Failure = Box<dyn std::error::Error>;

/// Scenes, sides of pictures and samples that the fit sees.
const SEEN: [(&str, u32, u32); 12] = [
    ("cornell", 128, 4),
    ("cornell", 64, 16),
    ("colour-cube:6", 64, 2),
    ("colour-cube:20", 64, 2),
    ("sphereflake", 48, 2),
    ("glass", 64, 2),
    ("glass", 48, 8),
    ("sinc", 64, 4),
    ("conference", 64, 2),
    ("sinc:40", 48, 4),
    ("studio", 64, 2),
    ("studio", 48, 8),
];
/// Those that it predicts.
const UNSEEN: [(&str, u32, u32); 3] =
    [("cornell", 96, 8), ("glass", 64, 4), ("sphereflake", 64, 4)];

/// Operations that are fitted.
const TERMS: usize = 13;
/// How often each picture is rendered: the quickest counts.
const REPEATS: usize = 5;

fn main() -> Result<(), Failure> {
    let seen = SEEN.map(measure);
    let unseen = UNSEEN.map(measure);
    let rows: Vec<_> = seen.iter().flatten().map(|m| (m.counts, m.ns)).collect();
    let fitted = fit(&rows);
    println!("{:#?}", with_terms(fitted, copy_ns(), check_ns()?));
    print("seen", &SEEN, seen, fitted)?;
    print("not seen", &UNSEEN, unseen, fitted)
}

/// A table of what was measured and predicted.
fn print<const N: usize>(
    title: &str,
    scenes: &[(&str, u32, u32); N],
    measured: [Result<Measured, Failure>; N],
    fitted: [f64; TERMS],
) -> Result<(), Failure> {
    println!(
        "{title}: picture, measured ms; by this fit, error; by `sim --nodes 1 --profile pc`, error"
    );
    for (&(scene, side, samples), measured) in scenes.iter().zip(measured) {
        let Measured { counts, ns, simulated } = measured?;
        let fit: f64 = counts.iter().zip(fitted).map(|(n, each)| n * each).sum();
        let error = |predicted: f64| 100.0 * (predicted / ns - 1.0);
        println!(
            "{scene:<16} {side:>4}² × {samples:<3} {:9.3}; {:9.3} {:+6.1} %; {:9.3} {:+6.1} %",
            ns / 1e6,
            fit / 1e6,
            error(fit),
            simulated / 1e6,
            error(simulated)
        );
    }
    Ok(())
}

/// A picture by one simulated node and by one thread.
#[derive(Clone, Copy)]
struct Measured {
    /// Operations of the node.
    counts: [f64; TERMS],
    /// The time of the thread [ns].
    ns: f64,
    /// The virtual time of the node, with the present profile [ns].
    simulated: f64,
}

fn measure((scene, side, samples): (&str, u32, u32)) -> Result<Measured, Failure> {
    let model = builtin::build(scene)?;
    let options = compile::Options { block_bytes: 16 << 10 };
    let file = KiloFile::from_compiled(compile::compile(&model, &options, &mut ())?);
    let file = file.view();
    let topology = Topology::parse("line", 1)?;
    let mut options = Options::new(side, side, file.views()[0], topology);
    options.mesh.settings.samples = samples;
    options.mesh.memory = 4 << 20;
    let cancel = AtomicBool::new(false);
    let control = Control { cancel: &cancel, progress: &|_| {} };
    let report = simulate(&file, &options, &control)?.report;
    let counts = terms(&report.totals.work, file.lights().len());
    let plain = kiloray_render::Options {
        settings: options.mesh.settings,
        threads: 1,
        ..kiloray_render::Options::new(side, side, options.view)
    };
    let control = kiloray_render::Control { cancel: &cancel, progress: &|_, _| {} };
    let mut least = f64::INFINITY;
    for _ in 0..REPEATS {
        let begin = ProcessTime::now();
        black_box(kiloray_render::render(&file, &plain, &control)?);
        least = least.min(begin.elapsed().as_nanos() as f64);
    }
    Ok(Measured { counts, ns: least, simulated: report.virtual_ns as f64 })
}

fn terms(work: &Work, lights: usize) -> [f64; TERMS] {
    [
        work.nodes,
        work.leaves,
        work.blocks,
        work.rays,
        work.shadow_rays,
        work.bundle_rays,
        work.bundle_nodes,
        work.bundle_boxes,
        work.bundle_triangles,
        work.shadings,
        work.shadings * lights as u64,
        work.light_samples,
        work.clips,
    ]
    .map(|count| count as f64)
}

fn with_terms(t: [f64; TERMS], copy: f64, check: f64) -> Profile {
    let [
        node,
        leaf,
        block,
        ray,
        shadow_ray,
        bundle_ray,
        bundle_node,
        bundle_box,
        bundle_triangle,
        shading,
        light,
        light_sample,
        clip,
    ] = t;
    Profile {
        node,
        leaf,
        block,
        ray,
        shadow_ray,
        bundle_ray,
        bundle_node,
        bundle_box,
        bundle_triangle,
        shading,
        light,
        light_sample,
        clip,
        copy,
        check,
        ..Profile::PC
    }
}

/// The least squares of relative errors with no time below zero, by coordinate descent. Where the scenes do not tell
/// operations apart, the present profile does: a part of the sum holds to it.
fn fit(rows: &[([f64; TERMS], f64)]) -> [f64; TERMS] {
    const HOLD: f64 = 0.01;
    let pc = Profile::PC;
    let prior = [
        pc.node,
        pc.leaf,
        pc.block,
        pc.ray,
        pc.shadow_ray,
        pc.bundle_ray,
        pc.bundle_node,
        pc.bundle_box,
        pc.bundle_triangle,
        pc.shading,
        pc.light,
        pc.light_sample,
        pc.clip,
    ];
    let mut found = prior;
    for _ in 0..20_000 {
        for term in 0..TERMS {
            let (mut numerator, mut denominator) = (HOLD / prior[term], HOLD / prior[term].powi(2));
            for (counts, ns) in rows {
                let sum: f64 = counts.iter().zip(found).map(|(n, each)| n * each).sum();
                let rest = sum - counts[term] * found[term];
                numerator += counts[term] * (ns - rest) / (ns * ns);
                denominator += (counts[term] / ns).powi(2);
            }
            found[term] = (numerator / denominator).max(0.0);
        }
    }
    found
}

/// Copying a byte, in pieces as packets have them [ns].
fn copy_ns() -> f64 {
    let (from, mut to) = (vec![1_u8; 1 << 20], vec![0_u8; 1 << 20]);
    let begin = ThreadTime::now();
    for _ in 0..64 {
        for (to, from) in to.chunks_mut(1024).zip(from.chunks(1024)) {
            black_box(&mut *to).copy_from_slice(black_box(from));
        }
    }
    begin.elapsed().as_nanos() as f64 / (64 << 20) as f64
}

/// Checking a byte of a block, the mean over some scenes: spheres take longer than triangles [ns].
fn check_ns() -> Result<f64, Failure> {
    const SCENES: [&str; 4] = ["sphereflake", "colour-cube", "conference", "sinc"];
    let mut mean = 0.0;
    for scene in SCENES {
        let model = builtin::build(scene)?;
        let options = compile::Options { block_bytes: 4096 };
        let file = KiloFile::from_compiled(compile::compile(&model, &options, &mut ())?);
        let file = file.view();
        let begin = ThreadTime::now();
        let mut bytes = 0;
        while bytes < 64 << 20 {
            for block in 0..file.blocks() {
                black_box(file.check_block(block)?);
                bytes += 4096;
            }
        }
        let each = begin.elapsed().as_nanos() as f64 / f64::from(bytes);
        mean += each / SCENES.len() as f64;
    }
    Ok(mean)
}
