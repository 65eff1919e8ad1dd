use kiloray_sim::NodeReport;

use super::super::Run;
use crate::{
    chart::{Layout, Map, map},
    console::{bytes, count, percent},
    page::Page,
};

/// What the nodes did, over the mesh.
pub(super) fn draw(page: &mut Page, run: &Run<'_>, layout: &Layout) {
    let report = &run.done.outcome.report;
    if report.nodes.len() < 2 {
        return;
    }
    page.heading("Over the mesh");
    let host = match report.mesh.attached.as_slice() {
        [] => String::new(),
        nodes => {
            let all: Vec<_> = nodes.iter().map(ToString::to_string).collect();
            format!(" The host is attached at {}.", all.join(", "))
        }
    };
    let crashed = report.nodes.iter().any(|node| node.crashed_ns.is_some());
    let crashed = if crashed { " Nodes that crashed are grey in the maps of time." } else { "" };
    page.soft(format_args!("{}{host}{crashed}", layout.legend));
    page.raw("<div class=\"maps\">\n");
    let all = report.virtual_ns.max(1) as f64;
    let time = |ns: u64| ns as f64 / all;
    let alive = |n: &NodeReport, ns: u64| n.crashed_ns.is_none().then(|| time(ns));
    let whole = Some(1.0);
    draw_one(page, run, layout, "at work", whole, &percent, &|n| alive(n, n.time.busy()));
    draw_one(page, run, layout, "idle", whole, &percent, &|n| alive(n, n.time.idle()));
    let mut own =
        |title: &str, text: &dyn Fn(f64) -> String, of: &dyn Fn(&NodeReport) -> Option<f64>| {
            draw_one(page, run, layout, title, None, text, of);
        };
    own("idle: waiting for blocks", &percent, &|n| alive(n, n.time.idle_data));
    own("idle: waiting for answers", &percent, &|n| alive(n, n.time.idle_answers));
    own("idle: waiting for room to send", &percent, &|n| alive(n, n.time.idle_credit));
    own("idle: waiting for the host", &percent, &|n| alive(n, n.time.idle_master));
    own("idle: without work", &percent, &|n| alive(n, n.time.idle_work));
    own("communicating", &percent, &|n| {
        alive(n, n.time.messages + n.time.copies + n.time.checks + n.time.forwards)
    });
    own("cache hits", &percent, &|n| {
        let cache = &n.counts.cache;
        let asked = cache.hits + cache.misses;
        (asked > 0).then(|| cache.hits as f64 / asked as f64)
    });
    let whole = |n: f64| count(n.round() as u64);
    own("blocks fetched", &whole, &|n| Some(n.counts.cache.fetched as f64));
    own("blocks sent, bytes", &|n| bytes(n.round() as u64), &|n| {
        Some(n.counts.sent.part.bytes as f64)
    });
    own("tiles rendered", &whole, &|n| Some(n.counts.tiles as f64));
    own("rays run for others", &whole, &|n| Some(n.counts.visitors as f64));
    own("rays refused to others", &whole, &|n| Some(n.counts.sent.refusal.count as f64));
    page.raw("</div>\n");

    page.raw("<details><summary>Memory over the mesh, by line</summary>\n<div class=\"maps\">\n");
    let limit = run.options.mesh.memory.max(1) as f64;
    let mut parts = |title: &str, of: &dyn Fn(&NodeReport) -> Option<f64>| {
        draw_one(page, run, layout, title, Some(1.0), &percent, of);
    };
    parts("all lines", &|n| Some(n.peak_bytes as f64 / limit));
    for line in super::super::lines(report) {
        parts(line.name, &|n| {
            let line = n.lines.iter().find(|l| l.name == line.name)?;
            Some(line.peak_bytes as f64 / line.bytes.max(1) as f64)
        });
    }
    page.raw("</div>\n</details>\n");
}

/// A map; one of zeros alone says nothing and is left out.
fn draw_one(
    page: &mut Page,
    run: &Run<'_>,
    layout: &Layout,
    title: &str,
    most: Option<f64>,
    text: &dyn Fn(f64) -> String,
    of: &dyn Fn(&NodeReport) -> Option<f64>,
) {
    let nodes = &run.done.outcome.report.nodes;
    let values: Vec<_> = nodes.iter().map(of).collect();
    let greatest = values.iter().flatten().fold(0.0, |a: f64, &b| a.max(b));
    if greatest <= 0.0 {
        return;
    }
    let range = [0.0, most.unwrap_or(greatest)];
    page.raw(&map(&Map { title, values: &values, range, text }, layout));
}
