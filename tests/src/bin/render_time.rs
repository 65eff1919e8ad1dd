//! `render_time FILE.kilo WIDTH HEIGHT [--samples N] [--shadow-samples N] [--lights-per-point N] [--pixel-spacing N] [--pixel-contrast PART] [--out FILE]`:
//! the CPU seconds of a picture on one thread, after a first picture in the same process.
//!
//! So it is what each picture takes, and not what a process pays once, as for memory that it touches for the first time. FILE gets the pixels, row by row
//! from the top, each as three f32.

use std::error::Error;
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::atomic::AtomicBool;
use std::{env, fs};

use cpu_time::ProcessTime;
use kiloray_core::shade::Settings;
use kiloray_render::{Control, Options, Undersampling, framing, render};
use kiloray_scene::kilo::KiloFile;

struct Arguments {
    scene: PathBuf,
    size: [u32; 2],
    settings: Settings,
    undersampling: Option<Undersampling>,
    out: Option<PathBuf>,
}

fn main() -> ExitCode {
    let done = arguments().map_err(Into::into).and_then(|arguments| run(&arguments));
    match done {
        Ok(seconds) => {
            println!("{seconds}");
            ExitCode::SUCCESS
        }
        Err(error) => {
            eprintln!(
                "render_time: {error}\nusage: render_time FILE.kilo WIDTH HEIGHT [--samples N] [--shadow-samples N] \
                 [--lights-per-point N] [--pixel-spacing N] [--pixel-contrast PART] [--out FILE]"
            );
            ExitCode::FAILURE
        }
    }
}

fn arguments() -> Result<Arguments, String> {
    let mut words = env::args().skip(1);
    let mut named = Vec::new();
    let (mut settings, mut out) = (Settings::default(), None);
    let (mut spacing, mut contrast) = (1, 0.0);
    while let Some(word) = words.next() {
        if !word.starts_with("--") {
            named.push(word);
            continue;
        }
        let value = words.next().ok_or(format!("{word} needs a value"))?;
        match word.as_str() {
            "--samples" => settings.samples = number(&value)?,
            "--shadow-samples" => settings.shadow_samples = number(&value)?,
            "--lights-per-point" => settings.lights = number(&value)?,
            "--pixel-spacing" => spacing = number(&value)?,
            "--pixel-contrast" => contrast = number(&value)?,
            "--out" => out = Some(value.into()),
            _ => return Err(format!("{word} is unknown")),
        }
    }
    let [scene, width, height] = named.as_slice() else { return Err("what to render?".into()) };
    let size = [number(width)?, number(height)?];
    let undersampling = Undersampling::new(spacing, contrast);
    Ok(Arguments { scene: scene.into(), size, settings, undersampling, out })
}

fn number<T: std::str::FromStr>(word: &str) -> Result<T, String> {
    word.parse().map_err(|_| format!("{word:?} is no such number"))
}

fn run(arguments: &Arguments) -> Result<f64, Box<dyn Error>> {
    let scene = KiloFile::open(&arguments.scene)?;
    let file = scene.view();
    let view = *file.views().first().ok_or("the scene has no view")?;
    let [width, height] = arguments.size;
    let view = framing::fitted(view, width, height);
    let &Arguments { settings, undersampling, .. } = arguments;
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
