//! A page about a run: one file that shows itself everywhere, and its figures beside it.

use std::{fmt::Write, fs, path::Path};

use base64::{Engine, prelude::BASE64_STANDARD};

use super::report::Run;
use crate::{
    args::Exposure,
    console::{bytes, count},
    failure::{Failure, Outcome},
    output::Output,
    picture,
};

/// The files of a report, opened before the work.
pub(super) struct Page {
    page: Output,
    json: Output,
    picture: Output,
}

impl Page {
    /// Makes the directory, and begins the files in it.
    pub(super) fn create(folder: &Path) -> Outcome<Self> {
        fs::create_dir_all(folder).map_err(|error| Failure::io(folder, &error))?;
        let file = |name: &str| Output::create(&folder.join(name));
        Ok(Self {
            page: file("index.html")?,
            json: file("report.json")?,
            picture: file("picture.png")?,
        })
    }

    /// Writes them.
    pub(super) fn write(self, run: &Run<'_>) -> Outcome {
        let picture = &run.rendered.picture;
        let stops = run.exposure.unwrap_or_else(|| match run.common.exposure {
            Exposure::Auto => picture::auto_exposure(picture),
            Exposure::Stops(stops) => stops,
        });
        let rgb = picture::tone_mapped(picture, stops);
        let png = picture::png_bytes(picture.width, picture.height, &rgb).map_err(Failure::new)?;
        let json = format!("{:#}\n", run.as_json());
        self.page.write(page(run, &png, stops).as_bytes())?;
        self.json.write(json.as_bytes())?;
        self.picture.write(&png)
    }
}

const STYLE: &str = "\
body{font:15px/1.5 system-ui,sans-serif;max-width:64rem;margin:2rem auto;padding:0 1rem;color:#222;background:#fdfdfc}\
h1{font-size:1.5rem}h2{font-size:1.1rem;margin-top:2rem}img{max-width:100%;background:#000}\
table{border-collapse:collapse}td,th{padding:.15rem .9rem .15rem 0;text-align:left;font-weight:normal}\
td.n{text-align:right;font-variant-numeric:tabular-nums}th{color:#777}\
.bar{display:inline-block;height:.7rem;background:#3b6ea5;vertical-align:middle}\
@media(prefers-color-scheme:dark){body{color:#ddd;background:#161618}}";

fn page(run: &Run<'_>, png: &[u8], stops: f32) -> String {
    let mut html = String::new();
    let name = escaped(&run.scene.name);
    let picture = &run.rendered.picture;
    // Writing to a string does not fail.
    let _ = write!(
        html,
        "<!doctype html>\n<html lang=\"en\"><meta charset=\"utf-8\">\
         <meta name=\"viewport\" content=\"width=device-width\">\
         <title>{name} - Kiloray</title>\n<style>{STYLE}</style>\n<h1>{name}</h1>\n\
         <img alt=\"The picture\" width=\"{}\" height=\"{}\" src=\"data:image/png;base64,{}\">\n",
        picture.width,
        picture.height,
        BASE64_STANDARD.encode(png),
    );
    section(&mut html, "The run", &the_run(run, stops));
    let total = run.rays();
    let counts = &run.rendered.report.counts;
    let rays =
        [("primary", counts.primary), ("shadow", counts.shadow), ("specular", counts.specular)];
    bars(&mut html, "Rays", &rays, total);
    let skipped: Vec<_> = run.skipped().into_iter().filter(|&(_, n)| n > 0).collect();
    let most = skipped.iter().map(|&(_, n)| n).max().unwrap_or(0);
    bars(&mut html, "Skipped", &skipped, most);
    let not_needed = run.not_needed();
    if !not_needed.is_empty() {
        let _ = writeln!(html, "<p>The scene does not need: {}.", not_needed.join(", "));
    }
    memory(&mut html, run);
    for note in &run.scene.notes {
        let _ = writeln!(html, "<p>Note: {}", escaped(note));
    }
    html
}

fn the_run(run: &Run<'_>, stops: f32) -> Vec<(&'static str, String)> {
    let report = &run.rendered.report;
    let file = run.scene.file.view();
    let header = file.header();
    let sources: Vec<_> = run.sources.iter().map(|s| s.display().to_string()).collect();
    let mut rows = vec![
        ("scene", sources.join(", ")),
        ("surfaces", count(header.primitives.into())),
        (
            "blocks",
            format!("{} of {}", count(header.blocks.into()), bytes(header.block_bytes.into())),
        ),
        ("picture", format!("{} x {}", run.options.width, run.options.height)),
        ("samples", run.options.settings.samples.to_string()),
        ("bounces", run.options.settings.bounces.to_string()),
        ("seed", run.options.settings.seed.to_string()),
        ("exposure", format!("{stops} stops")),
        ("threads", report.threads.to_string()),
        ("time", format!("{:.2} s, of it {:.2} s rendering", run.time_s, run.render_s)),
        (
            "speed",
            format!(
                "{} rays per second",
                count((run.rays() as f64 / run.render_s.max(1e-9)) as u64)
            ),
        ),
        ("hash of the pixels", picture::hash(&run.rendered.picture)),
        ("version", env!("CARGO_PKG_VERSION").to_owned()),
    ];
    if run.common.memory.is_some() {
        let cache = &report.cache;
        let text = format!(
            "{} hits, {} misses, {} evictions; {} blocks fetched",
            count(cache.hits),
            count(cache.misses),
            count(cache.evictions),
            count(cache.fetched)
        );
        rows.insert(9, ("cache", text));
    }
    rows
}

fn section(html: &mut String, title: &str, rows: &[(&str, String)]) {
    let _ = writeln!(html, "<h2>{title}</h2>\n<table>");
    for (name, value) in rows {
        let _ = writeln!(html, "<tr><th>{name}<td>{}", escaped(value));
    }
    html.push_str("</table>\n");
}

fn bars(html: &mut String, title: &str, rows: &[(&str, u64)], full: u64) {
    if rows.is_empty() {
        return;
    }
    let _ = writeln!(html, "<h2>{title}</h2>\n<table>");
    for &(name, n) in rows {
        let name = name.replace('_', " ");
        let width = 20.0 * n as f64 / full.max(1) as f64;
        let _ = writeln!(
            html,
            "<tr><th>{name}<td class=\"n\">{n}<td><span class=\"bar\" style=\"width:{width:.2}rem\"></span>"
        );
    }
    html.push_str("</table>\n");
}

fn memory(html: &mut String, run: &Run<'_>) {
    let of = match run.common.memory {
        Some(limit) => format!("{} of {limit} bytes", run.peak()),
        None => format!("{} bytes of work space in all threads; no limit was given", run.peak()),
    };
    let _ = writeln!(
        html,
        "<h2>Memory</h2>\n<p>Peak: {of}.\n<table>\
         <tr><th>line<th>items<th>most in use<th>bytes<th>most in use"
    );
    for line in run.rendered.report.budget.lines().iter().filter(|line| line.bytes > 0) {
        let width = 20.0 * line.peak_bytes() as f64 / line.bytes as f64;
        let _ = writeln!(
            html,
            "<tr><th>{}<td class=\"n\">{}<td class=\"n\">{}<td class=\"n\">{}<td class=\"n\">{}\
             <td><span class=\"bar\" style=\"width:{width:.2}rem\"></span>",
            line.line.name(),
            line.capacity,
            line.peak,
            line.bytes,
            line.peak_bytes(),
        );
    }
    html.push_str("</table>\n");
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
