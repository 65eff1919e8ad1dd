//! `render_time FILE.kilo WIDTH HEIGHT [--samples N] [--shadow-samples N] [--lights-per-point N] [--pixel-spacing N] [--pixel-contrast PART] [--out FILE]`:
//! the CPU seconds of a picture on one thread, after a first picture in the same process.
//!
//! So it is what each picture takes, and not what a process pays once, as for memory that it touches for the first time. FILE gets the pixels, row by row
//! from the top, each as three f32.

use std::error::Error;
use std::fs;
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::atomic::AtomicBool;

use clap::Parser;
use cpu_time::ProcessTime;
use kiloray_core::shade::Settings;
use kiloray_render::{Control, Options, Undersampling, framing, render};
use kiloray_scene::kilo::KiloFile;

/// The CPU seconds of a picture on one thread, after a first picture in the same process.
#[derive(Parser)]
struct Arguments {
    /// A compiled scene.
    scene: PathBuf,
    /// Pixels across.
    width: u32,
    /// Pixels down.
    height: u32,
    /// As those of `kiloray render`.
    #[arg(long, default_value_t = Settings::default().samples)]
    samples: u32,
    /// Likewise.
    #[arg(long, default_value_t = Settings::default().shadow_samples)]
    shadow_samples: u16,
    /// Likewise.
    #[arg(long, default_value_t = Settings::default().lights)]
    lights_per_point: u16,
    /// Likewise.
    #[arg(long, default_value_t = 1)]
    pixel_spacing: u32,
    /// Likewise.
    #[arg(long, default_value_t = 0.0)]
    pixel_contrast: f32,
    /// Gets the pixels, row by row from the top, each as three f32.
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

fn main() -> ExitCode {
    match run(&Arguments::parse()) {
        Ok(seconds) => {
            println!("{seconds}");
            ExitCode::SUCCESS
        }
        Err(error) => {
            eprintln!("render_time: {error}");
            ExitCode::FAILURE
        }
    }
}

fn run(arguments: &Arguments) -> Result<f64, Box<dyn Error>> {
    let scene = KiloFile::open(&arguments.scene)?;
    let file = scene.view();
    let view = *file.views().first().ok_or("the scene has no view")?;
    let &Arguments { width, height, .. } = arguments;
    let view = framing::fitted(view, width, height);
    let settings = Settings {
        samples: arguments.samples,
        shadow_samples: arguments.shadow_samples,
        lights: arguments.lights_per_point,
        ..Settings::default()
    };
    let undersampling = Undersampling::new(arguments.pixel_spacing, arguments.pixel_contrast);
    let options =
        Options { settings, threads: 1, undersampling, ..Options::new(width, height, view) };
    let cancel = AtomicBool::new(false);
    let control = Control { cancel: &cancel, progress: &|_, _| {} };
    let first = render(&file, &options, &control)?;
    let begin = ProcessTime::now();
    render(&file, &options, &control)?;
    let seconds = begin.elapsed().as_secs_f64();
    if let Some(out) = &arguments.out {
        let numbers = first.picture.pixels.iter().flatten();
        fs::write(out, numbers.flat_map(|x| x.to_le_bytes()).collect::<Vec<_>>())?;
    }
    Ok(seconds)
}
