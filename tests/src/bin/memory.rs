//! `memory [SCENE] [--size N] [--out FOLDER]`: the same picture in arenas from the least one to one that holds
//! the whole scene, against all of it mapped: `memory.csv` and `memory.svg`. Ends with exit code 1 if a bit differs.
//!
//! The default scene has a million triangles. Times are CPU seconds of one thread.

use std::error::Error;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::atomic::AtomicBool;

use clap::Parser;
use kiloray_core::block::KiloView;
use kiloray_core::shade::Settings;
use kiloray_core::store::Line;
use kiloray_render::{Control, Options, Rendered, plan, render};
use kiloray_scene::{builtin, compile};
use plotters::prelude::*;

/// Block sizes that are compared \[bytes\].
const BLOCKS: [usize; 3] = [1 << 10, 4 << 10, 16 << 10];

/// The same picture in arenas from the least one to one that holds the whole scene, against all of it mapped.
#[derive(Parser)]
struct Arguments {
    /// A built-in scene; the default has a million triangles.
    #[arg(default_value = "sinc:708")]
    scene: String,
    /// Pixels along the picture.
    #[arg(long, default_value_t = 256)]
    size: u32,
    /// Where `memory.csv` and `memory.svg` are written.
    #[arg(long, value_name = "FOLDER", default_value = "target/memory")]
    out: PathBuf,
}

/// A measured arena.
struct Row {
    block_bytes: usize,
    memory: usize,
    seconds: f64,
    /// Against the mapped file of the same block size.
    ratio: f64,
}

fn main() -> ExitCode {
    match run(&Arguments::parse()) {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => {
            eprintln!("memory: the pictures differ");
            ExitCode::FAILURE
        }
        Err(error) => {
            eprintln!("memory: {error}");
            ExitCode::FAILURE
        }
    }
}

/// Whether all pictures are the same.
fn run(arguments: &Arguments) -> Result<bool, Box<dyn Error>> {
    let model = builtin::build(&arguments.scene)?;
    let mut csv = String::from(
        "block_bytes,memory_bytes,peak_bytes,frames,batch,cpu_s,ratio,hits,misses,evictions,hash\n",
    );
    let mut rows = Vec::new();
    let mut first = None;
    let mut same = true;
    for block_bytes in BLOCKS {
        let compiled =
            compile::compile(&model, &compile::Options::blocks_of(block_bytes), &mut ())?;
        let file = KiloView::parse(compiled.bytes())?;
        let view = *file.views().first().ok_or("the scene has no view")?;
        let settings = Settings { samples: 4, ..Settings::default() };
        let size = arguments.size;
        let base = Options { settings, threads: 1, ..Options::new(size, size, view) };
        let (mapped, whole) = timed(&file, &base)?;
        let scene = file.blocks() as usize * block_bytes;
        for memory in memories(&file, &base, scene) {
            let options = Options { memory, ..base };
            let (rendered, seconds) = match memory {
                None => (mapped.clone(), whole),
                Some(_) => timed(&file, &options)?,
            };
            let found = hash(&rendered);
            same &= found == *first.get_or_insert(found);
            let report = &rendered.report;
            let ratio = seconds / whole;
            let bytes = memory.unwrap_or(scene + report.budget.bytes());
            let plan = plan(&file, &options)?;
            writeln!(
                csv,
                "{block_bytes},{bytes},{},{},{},{seconds:.3},{ratio:.3},{},{},{},{found:016x}",
                report.budget.peak_bytes(),
                report.budget.line(Line::Frames).capacity,
                plan.batch,
                report.cache.hits,
                report.cache.misses,
                report.cache.evictions,
            )?;
            println!(
                "{:>2} KiB blocks, {bytes:>9} bytes{}: {seconds:>7.3} s, {ratio:>6.2} × the mapped file, \
                 {} fetches, hash {found:016x}",
                block_bytes >> 10,
                if memory.is_none() { " (mapped)" } else { "" },
                report.cache.fetched,
            );
            if memory.is_some() {
                rows.push(Row { block_bytes, memory: bytes, seconds, ratio });
            }
        }
    }
    fs::create_dir_all(&arguments.out)?;
    fs::write(arguments.out.join("memory.csv"), csv)?;
    let picture = arguments.out.join("memory.svg");
    plot(&picture, &arguments.scene, &rows)?;
    println!("{} and {}", arguments.out.join("memory.csv").display(), picture.display());
    let small = rows.iter().filter(|row| row.memory == 64 << 10);
    for row in small {
        println!(
            "64 KiB, {} KiB blocks: {:.2} s, {:.2} × the mapped file",
            row.block_bytes >> 10,
            row.seconds,
            row.ratio
        );
    }
    Ok(same)
}

/// The least memory, powers of two from 32 KiB, all of the scene, and the mapped file.
fn memories(file: &KiloView<'_>, base: &Options, scene: usize) -> Vec<Option<usize>> {
    let mut all = Vec::new();
    if let Err(kiloray_render::Error::Budget(error)) =
        plan(file, &Options { memory: Some(0), ..*base })
    {
        all.push(error.need());
    }
    let mut memory = 32 << 10;
    while memory < 2 * scene {
        if all.first().is_some_and(|&least| memory > least) {
            all.push(memory);
        }
        memory *= 2;
    }
    all.push(memory);
    all.into_iter().map(Some).chain([None]).collect()
}

/// A picture, and its CPU seconds.
fn timed(file: &KiloView<'_>, options: &Options) -> Result<(Rendered, f64), Box<dyn Error>> {
    let cancel = AtomicBool::new(false);
    let control = Control { cancel: &cancel, progress: &|_, _| {} };
    let before = cpu_seconds()?;
    let rendered = render(file, options, &control)?;
    Ok((rendered, cpu_seconds()? - before))
}

/// CPU seconds of this process and all its threads, in steps of 10 ms.
fn cpu_seconds() -> Result<f64, Box<dyn Error>> {
    let stat = fs::read_to_string("/proc/self/stat")?;
    let fields: Vec<_> = stat.rsplit(')').next().unwrap_or_default().split_whitespace().collect();
    let [user, system] = [11, 12].map(|i| fields.get(i).and_then(|f| f.parse::<f64>().ok()));
    // Linux counts in hundredths, whatever its own clock does.
    Ok((user.ok_or("no user time")? + system.ok_or("no system time")?) / 100.0)
}

/// FNV-1a of the bits.
fn hash(rendered: &Rendered) -> u64 {
    let bytes = rendered.picture.pixels.iter().flatten().flat_map(|x| x.to_le_bytes());
    bytes.fold(0xcbf2_9ce4_8422_2325, |hash, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x100_0000_01b3)
    })
}

fn plot(path: &Path, scene: &str, rows: &[Row]) -> Result<(), Box<dyn Error>> {
    let root = SVGBackend::new(path, (800, 500)).into_drawing_area();
    root.fill(&WHITE)?;
    let memories = || rows.iter().map(|row| row.memory as f64 / 1024.0);
    let (least, most) = (memories().fold(f64::MAX, f64::min), memories().fold(1.0, f64::max));
    let slowest = rows.iter().map(|row| row.ratio).fold(2.0, f64::max);
    let mut chart = ChartBuilder::on(&root)
        .caption(format!("{scene}: time against arena"), ("sans-serif", 22))
        .margin(12)
        .x_label_area_size(44)
        .y_label_area_size(56)
        .build_cartesian_2d((least..most).log_scale(), (0.8..slowest * 1.2).log_scale())?;
    chart
        .configure_mesh()
        .x_desc("arena [KiB]")
        .y_desc("time / time with the file mapped")
        .x_label_formatter(&|x| format!("{x:.0}"))
        .y_label_formatter(&|y| format!("{y}"))
        .draw()?;
    for (block_bytes, colour) in BLOCKS.into_iter().zip([RED, BLUE, BLACK]) {
        let points: Vec<_> = rows
            .iter()
            .filter(|row| row.block_bytes == block_bytes)
            .map(|row| (row.memory as f64 / 1024.0, row.ratio))
            .collect();
        chart
            .draw_series(LineSeries::new(points.clone(), colour.stroke_width(2)).point_size(3))?
            .label(format!("blocks of {} KiB", block_bytes >> 10))
            .legend(move |(x, y)| PathElement::new([(x, y), (x + 18, y)], colour));
    }
    chart
        .configure_series_labels()
        .background_style(WHITE.mix(0.8))
        .border_style(BLACK)
        .position(SeriesLabelPosition::UpperRight)
        .draw()?;
    root.present()?;
    Ok(())
}
