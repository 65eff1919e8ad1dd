use std::{
    path::{Path, PathBuf},
    time::Instant,
};

use kiloray_render::Undersampling;

use super::{engine, frames, html, report::Run};
use crate::{
    args,
    console::{bytes, count, line},
    failure::{self, Outcome},
    output::Output,
    picture::{self, Format, Saved},
    scene,
};

/// Renders and writes.
pub(super) fn run(arguments: &args::Render) -> Outcome {
    let common = &arguments.common;
    let quiet = common.quiet;
    let start = Instant::now();
    if let Some(path) = &arguments.output {
        Format::of(path)?;
    }

    let block = engine::default_block(common.memory);
    let mut scene =
        scene::load(&arguments.scene, common.block, block, quiet)?.with_view(common.view.as_ref());
    let args::Undersampling { pixel_spacing, pixel_contrast } = arguments.undersampling;
    let mut options = engine::options(common, scene.choose_view(common.view.as_ref())?)?;
    options.undersampling = Undersampling::new(pixel_spacing, pixel_contrast as f32);
    let path =
        arguments.output.clone().unwrap_or_else(|| PathBuf::from(format!("{}.png", scene.name)));
    // Whether all can be written shows before the work.
    kiloray_render::plan(&scene.file.view(), &options).map_err(engine::refused)?;
    let few_frames = frames::of_node(&scene.file.view(), &options);
    scene.notes.extend(few_frames);
    let output = Output::create(&path)?;
    let json_out = common.json.as_deref().map(Output::create).transpose()?;
    let page = common.report.as_deref().map(html::Files::create).transpose()?;
    scene.print_notes(quiet);

    let render_start = Instant::now();
    let rendered = engine::render(&scene, &options, quiet)?;
    let (time_s, render_s) = (start.elapsed().as_secs_f64(), render_start.elapsed().as_secs_f64());
    let saved = picture::save(&rendered.picture, Format::of(&path)?, common.exposure, output)?;
    let shown = html::Shown::of_report(common, &rendered.picture)?;
    let run = Run {
        scene: &scene,
        sources: &arguments.scene.scenes,
        common,
        undersampling: &arguments.undersampling,
        options: &options,
        rendered: &rendered,
        time_s,
        render_s,
        exposure: saved.exposure.or(shown.as_ref().map(|shown| shown.stops)),
    };
    failure::warn_of_overflows(rendered.report.overflows, quiet);
    if let Some(output) = json_out {
        output.write(format!("{:#}\n", run.as_json()).as_bytes())?;
    }
    if let Some((page, shown)) = page.zip(shown) {
        page.write_run(&run, &shown)?;
    }
    let to_standard =
        [Some(path.as_path()), common.json.as_deref()].contains(&Some(Path::new("-")));
    if quiet || to_standard { Ok(()) } else { print(&run, &path, &saved) }
}

fn print(run: &Run<'_>, path: &Path, saved: &Saved) -> Outcome {
    let report = &run.rendered.report;
    let pixels = f64::from(run.options.width) * f64::from(run.options.height);
    let interpolated = match report.interpolated {
        0 => String::new(),
        some => format!(", {:.1} % of the pixels interpolated", 100.0 * some as f64 / pixels),
    };
    line(format_args!(
        "{}: {} x {}, {} samples per pixel{interpolated}{}",
        path.display(),
        run.options.width,
        run.options.height,
        run.options.settings.samples,
        saved.said(),
    ))?;
    line(format_args!(
        "{} surfaces, {} rays in {:.2} s by {} ({} per second)",
        count(run.scene.file.view().header().primitives.into()),
        count(run.rays()),
        run.render_s,
        if report.threads == 1 {
            "one thread".into()
        } else {
            format!("{} threads", report.threads)
        },
        count((run.rays() as f64 / run.render_s.max(1e-9)) as u64),
    ))?;
    if let Some(limit) = run.common.memory {
        let cache = &report.cache;
        let asked = (cache.hits + cache.misses).max(1);
        line(format_args!(
            "memory {} of {}; {} blocks fetched, {:.2} % of accesses found in the cache",
            bytes(run.peak()),
            bytes(limit),
            count(cache.fetched),
            100.0 * cache.hits as f64 / asked as f64,
        ))?;
    }
    match &run.common.report {
        Some(folder) => line(format_args!("report: {}", folder.join("index.html").display())),
        None => Ok(()),
    }
}
