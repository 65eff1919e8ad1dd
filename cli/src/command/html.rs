//! A page about a run: one file that shows itself everywhere, and its figures beside it.

use std::path::{Path, PathBuf};

use kiloray_core::shade::Settings;

use super::report::{Run, not_needed};
use crate::{
    args::{Common, Exposure},
    console::{bytes, count},
    failure::{Failure, Outcome},
    output::{Folder, Output},
    page::{Bar, Page},
    picture::{self, Picture},
    scene::Scene,
};

/// The files of a report, opened before the work.
pub(super) struct Files {
    page: Output,
    json: Output,
    picture: Output,
    /// Goes last: it is empty if none of them was written.
    _folder: Folder,
}

/// A picture for the page.
pub(super) struct Shown<'a> {
    pub(super) picture: &'a Picture,
    pub(super) png: Vec<u8>,
    pub(super) stops: f32,
}

impl<'a> Shown<'a> {
    /// For the page of `--report`, if there is to be one.
    pub(super) fn of_report(common: &Common, picture: &'a Picture) -> Outcome<Option<Self>> {
        common.report.as_ref().map(|_| Self::new(picture, common.exposure)).transpose()
    }

    /// For the eye, as bright as was asked for.
    pub(super) fn new(picture: &'a Picture, exposure: Exposure) -> Outcome<Self> {
        let stops = match exposure {
            Exposure::Auto => picture::auto_exposure(picture),
            Exposure::Stops(stops) => stops,
        };
        let rgb = picture::tone_mapped(picture, stops);
        let png = picture::png_bytes(picture.width, picture.height, &rgb).map_err(Failure::new)?;
        Ok(Self { picture, png, stops })
    }
}

impl Files {
    /// Makes the directory, and begins the files in it.
    pub(super) fn create(folder: &Path) -> Outcome<Self> {
        let made = Folder::create(folder)?;
        let file = |name: &str| Output::create(&folder.join(name));
        Ok(Self {
            page: file("index.html")?,
            json: file("report.json")?,
            picture: file("picture.png")?,
            _folder: made,
        })
    }

    /// The same, of a run whose picture is not all there: it has a name that says so.
    pub(super) fn incomplete(self) -> Self {
        Self { picture: self.picture.incomplete(), ..self }
    }

    /// Writes them, with the picture if there is one.
    pub(super) fn write(self, page: &str, json: &str, png: Option<&[u8]>) -> Outcome {
        self.page.write(page.as_bytes())?;
        self.json.write(json.as_bytes())?;
        png.map_or(Ok(()), |png| self.picture.write(png))
    }

    /// Writes them for a picture of this machine.
    pub(super) fn write_run(self, run: &Run<'_>, shown: &Shown<'_>) -> Outcome {
        self.write(&page(run, shown), &format!("{:#}\n", run.as_json()), Some(&shown.png))
    }
}

fn page(run: &Run<'_>, shown: &Shown<'_>) -> String {
    let mut page = Page::new(&run.scene.name);
    page.picture(shown.picture, &shown.png);
    page.heading("The run");
    page.pairs(&the_run(run, shown.stops));
    page.heading("Rays");
    let counts = &run.rendered.report.counts;
    let rays =
        [("primary", counts.primary), ("shadow", counts.shadow), ("specular", counts.specular)];
    page.bars(&rays.map(|(name, n)| Bar::new(name, n, n as f64)));
    skipped(&mut page, run.scene, &run.skipped());
    memory(&mut page, run);
    for note in &run.scene.notes {
        page.text(format_args!("Note: {note}"));
    }
    page.finish()
}

/// What was not done.
pub(super) fn skipped(page: &mut Page, scene: &Scene, all: &[(&str, u64)]) {
    page.heading("Skipped");
    let rows: Vec<_> = all
        .iter()
        .filter(|&&(_, n)| n > 0)
        .map(|&(name, n)| Bar::new(name.replace('_', " "), n, n as f64))
        .collect();
    if !rows.is_empty() {
        page.bars(&rows);
    }
    let not_needed = not_needed(scene);
    if !not_needed.is_empty() {
        page.text(format_args!("The scene does not need: {}.", not_needed.join(", ")));
    }
}

/// What the table of every run begins with.
pub(super) fn pairs(
    scene: &Scene,
    sources: &[PathBuf],
    (width, height): (u32, u32),
    settings: &Settings,
    stops: f32,
) -> Vec<(&'static str, String)> {
    let file = scene.file.view();
    let header = file.header();
    let sources: Vec<_> = sources.iter().map(|source| source.display().to_string()).collect();
    let blocks = format!(
        "{} of {}, {}",
        count(header.blocks.into()),
        bytes(header.block_bytes.into()),
        bytes(u64::from(header.blocks) * u64::from(header.block_bytes))
    );
    vec![
        ("scene", sources.join(", ")),
        ("surfaces", count(header.primitives.into())),
        ("blocks", blocks),
        ("picture", format!("{width} x {height}")),
        ("samples", settings.samples.to_string()),
        ("bounces", settings.bounces.to_string()),
        ("exposure", format!("{stops} stops")),
        ("seed", settings.seed.to_string()),
    ]
}

fn the_run(run: &Run<'_>, stops: f32) -> Vec<(&'static str, String)> {
    let (report, options) = (&run.rendered.report, run.options);
    let size = (options.width, options.height);
    let mut rows = pairs(run.scene, run.sources, size, &options.settings, stops);
    if let Some(undersampling) = options.undersampling {
        let kiloray_render::Undersampling { spacing, contrast } = undersampling;
        let text =
            format!("squares of {spacing}, traced where corners differ by more than {contrast}");
        rows.push(("pixels", text));
    }
    rows.push(("threads", report.threads.to_string()));
    if run.common.memory.is_some() {
        let cache = &report.cache;
        let text = format!(
            "{} hits, {} misses, {} evictions; {} blocks fetched",
            count(cache.hits),
            count(cache.misses),
            count(cache.evictions),
            count(cache.fetched)
        );
        rows.push(("cache", text));
    }
    let speed = (run.rays() as f64 / run.render_s.max(1e-9)) as u64;
    rows.extend([
        ("time", format!("{:.2} s, of it {:.2} s rendering", run.time_s, run.render_s)),
        ("speed", format!("{} rays per second", count(speed))),
        ("hash of the pixels", picture::hash(&run.rendered.picture)),
        ("version", env!("CARGO_PKG_VERSION").to_owned()),
    ]);
    rows
}

fn memory(page: &mut Page, run: &Run<'_>) {
    page.heading("Memory");
    match run.common.memory {
        Some(limit) => page.text(format_args!("Peak: {} of {limit} bytes.", run.peak())),
        None => page.text(format_args!(
            "Peak: {} bytes of work space in all threads; no limit was given.",
            run.peak()
        )),
    }
    let lines = run.rendered.report.budget.lines();
    let rows: Vec<_> = lines
        .iter()
        .filter(|line| line.bytes > 0)
        .map(|line| {
            let name = line.line.name().to_owned();
            let numbers = [line.capacity, line.peak, line.bytes, line.peak_bytes()];
            std::iter::once(name).chain(numbers.iter().map(ToString::to_string)).collect()
        })
        .collect();
    page.table(&["line", "items", "most in use", "bytes", "most in use"], &rows);
}
