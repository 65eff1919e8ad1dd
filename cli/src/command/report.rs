use std::path::PathBuf;

use kiloray_core::{shade::Counts, store::Line};
use kiloray_render::{Options, Rendered};
use serde_json::{Value, json};

use super::compile::NEEDS;
use crate::{
    args::{Common, Undersampling},
    picture::{self, Picture},
    scene::Scene,
};

/// A finished run.
pub(super) struct Run<'a> {
    pub(super) scene: &'a Scene,
    pub(super) sources: &'a [PathBuf],
    pub(super) common: &'a Common,
    pub(super) undersampling: &'a Undersampling,
    pub(super) options: &'a Options,
    pub(super) rendered: &'a Rendered,
    /// Wall clock, from the first byte read to the last pixel (s).
    pub(super) time_s: f64,
    /// Of it, rendering.
    pub(super) render_s: f64,
    /// Stops of a PNG, the picture or that of the page.
    pub(super) exposure: Option<f32>,
}

/// Light, rays and data that were not needed, by name.
pub(super) fn skipped(scene: &Scene, c: &Counts) -> Vec<(&'static str, u64)> {
    let [materials, lights] = scene.left_out();
    vec![
        ("materials_without_effect", materials),
        ("lights_without_effect", lights),
        ("lights_below", c.lights_below),
        ("lights_facing_away", c.lights_facing_away),
        ("lights_out_of_reach", c.lights_out_of_reach),
        ("lights_by_chance", c.lights_by_chance),
        ("shadow_dark", c.shadow_dark),
        ("shadow_clear", c.shadow_clear),
        ("specular_by_chance", c.specular_by_chance),
        ("specular_too_deep", c.specular_too_deep),
    ]
}

/// The same, with what the scene has none of, for the JSON.
pub(super) fn skipped_json(scene: &Scene, all: &[(&str, u64)]) -> Value {
    let mut all: serde_json::Map<_, _> =
        all.iter().map(|&(name, n)| (name.to_owned(), json!(n))).collect();
    all.insert("not_needed".into(), json!(not_needed(scene)));
    all.into()
}

/// What the scene does not need, and so was left out.
pub(super) fn not_needed(scene: &Scene) -> Vec<&'static str> {
    let bits = scene.file.view().needs().bits;
    NEEDS.iter().filter(|(bit, ..)| bits & bit == 0).map(|&(_, name, _)| name).collect()
}

impl Run<'_> {
    /// Bytes of the node: all lines of all threads.
    pub(super) fn peak(&self) -> u64 {
        let report = &self.rendered.report;
        report.budget.peak_bytes() as u64 * report.threads as u64
    }

    /// Light, rays and data that were not needed, by name.
    pub(super) fn skipped(&self) -> Vec<(&'static str, u64)> {
        let report = &self.rendered.report;
        let mut all = skipped(self.scene, &report.counts);
        all.push(("pixels_interpolated", report.interpolated));
        all
    }

    /// Rays of all kinds.
    pub(super) fn rays(&self) -> u64 {
        let c = &self.rendered.report.counts;
        c.primary + c.shadow + c.specular
    }

    /// The fields that scripts rely on.
    pub(super) fn as_json(&self) -> Value {
        let Rendered { picture, report } = self.rendered;
        let size = (picture.width, picture.height);
        let mut options = options_json(self.common, self.sources, self.scene, size, self.exposure);
        options["threads"] = json!(report.threads);
        options["pixel_spacing"] = json!(self.undersampling.pixel_spacing);
        options["pixel_contrast"] = json!(self.undersampling.pixel_contrast);
        let lines: Vec<_> = report
            .budget
            .lines()
            .iter()
            .filter(|line| line.bytes > 0)
            .map(|line| {
                json!({
                    "line": line.line.name(),
                    "capacity": line.capacity,
                    "bytes": line.bytes,
                    "peak": line.peak,
                    "peak_bytes": line.peak_bytes(),
                })
            })
            .collect();
        let points = report.budget.line(Line::Points);
        let none = json!({});
        let head = Head {
            scene: self.scene,
            options,
            picture,
            image_hash: &picture::hash(picture),
            nodes: 1,
            time_s: self.time_s,
            fetched: report.cache.fetched,
            overflows: report.overflows,
        };
        let mut json = head.with(json!({
            "render_s": self.render_s,
            "virtual_time_s": null,
            "efficiency": null,
            "rays": {
                "primary": report.counts.primary,
                "shadow": report.counts.shadow,
                "specular": report.counts.specular,
                "ambient": 0,
            },
            "skipped": skipped_json(self.scene, &self.skipped()),
            "messages": { "count": 0, "bytes": 0 },
            "memory": {
                "limit": self.common.memory,
                "peak": self.peak(),
                "peak_node": 0,
                "lines": lines,
            },
            "points": { "capacity": points.capacity, "peak": points.peak },
            "cache": {
                "hits": report.cache.hits,
                "misses": report.cache.misses,
                "evictions": report.cache.evictions,
            },
            "retries": 0,
            "refusals": 0,
            "lost": none,
            "faults": none,
        }));
        json["blocks"]["expanded_bytes"] = json!(report.top_bytes);
        json
    }
}

/// What the report of every run has.
pub(super) struct Head<'a> {
    pub(super) scene: &'a Scene,
    pub(super) options: Value,
    pub(super) picture: &'a Picture,
    pub(super) image_hash: &'a str,
    pub(super) nodes: usize,
    pub(super) time_s: f64,
    /// Blocks that arrived in frames.
    pub(super) fetched: u64,
    pub(super) overflows: u64,
}

impl Head<'_> {
    /// The report: this, and the rest of it.
    pub(super) fn with(self, rest: Value) -> Value {
        let file = self.scene.file.view();
        let header = file.header();
        let mut all = json!({
            "version": env!("CARGO_PKG_VERSION"),
            "options": self.options,
            "image_hash": self.image_hash,
            "image_hash_kind": "blake3",
            "width": self.picture.width,
            "height": self.picture.height,
            "nodes": self.nodes,
            "time_s": self.time_s,
            "surfaces": header.primitives,
            "position_error": header.frame.position_error,
            "overflows": self.overflows,
            "notes": self.scene.notes,
            "blocks": {
                "count": header.blocks,
                "bytes": u64::from(header.blocks) * u64::from(header.block_bytes),
                "fetched": self.fetched,
            },
        });
        if let (Some(all), Value::Object(rest)) = (all.as_object_mut(), rest) {
            all.extend(rest);
        }
        all
    }
}

/// The options of a report: what was typed, and what was found where nothing was said.
pub(super) fn options_json(
    common: &Common,
    scenes: &[PathBuf],
    scene: &Scene,
    (width, height): (u32, u32),
    exposure: Option<f32>,
) -> Value {
    let mut options = json!(common);
    options["scenes"] = json!(scenes);
    options["width"] = json!(width);
    options["height"] = json!(height);
    options["block"] = json!(scene.file.view().header().block_bytes);
    // As it is printed: 0.7, not the nearest f32.
    let stops = exposure.and_then(|stops| stops.to_string().parse::<f64>().ok());
    options["exposure"] = json!(stops);
    options
}
