//! The page about a run of processes.

use std::time::Duration;

use kiloray_sim::{MessageReport, TileReport};

use super::{Run, has_pixels, why_incomplete};
use crate::{
    command::{
        html::{self, Shown},
        latencies::latencies,
        mesh::{self, part, total},
    },
    console::{bytes, count, counted, duration, percent},
    page::Page,
};

/// Draws it.
pub(super) fn page(run: &Run<'_>, shown: &Shown<'_>) -> String {
    let outcome = run.outcome;
    let named = run.mesh();
    let mut page = Page::new(&format!("{} on {named}", run.scene.name));
    if let Some(why) = why_incomplete(outcome) {
        mesh::incomplete(&mut page, &why);
    }
    page.cards(&cards(run));
    page.raw("<div class=\"beside\"><div>\n");
    if has_pixels(outcome) {
        page.picture(shown.picture, &shown.png);
    }
    page.raw("</div><div class=\"rest\">\n");
    time(&mut page, run);
    page.raw("</div></div>\n");
    nodes(&mut page, run);
    latencies(&mut page, &outcome.latencies);
    messages(&mut page, run);
    memory(&mut page, run);
    mesh::rays(&mut page, run.scene, &run.counts);
    faults(&mut page, run);
    the_run(&mut page, run, &named, shown.stops);
    for note in &run.scene.notes {
        page.text(format_args!("Note: {note}"));
    }
    page.finish()
}

fn cards(run: &Run<'_>) -> Vec<(&'static str, String)> {
    let counts = &run.counts;
    let sent = counts.sent.named();
    let mut cards = Vec::new();
    if let Some(start) = run.outcome.start {
        let ns = |time: Duration| duration(time.as_nanos() as u64);
        cards.push(("from the first to the last pixel", ns(run.outcome.render)));
        cards.push(("until all nodes were there", ns(start)));
    }
    if let Some(fullest) = run.fullest() {
        let used = part(fullest.peak_bytes as u64, run.options.memory as u64);
        cards.push(("of a node's memory at most used", percent(used)));
    }
    cards.extend([
        ("blocks fetched", count(counts.cache.fetched)),
        ("of accesses hit the cache", mesh::cache_hits(counts)),
        ("rays migrated", count(counts.migrated)),
        ("messages", count(total(sent.iter().map(|(_, kind)| kind.count)))),
    ]);
    cards
}

fn time(page: &mut Page, run: &Run<'_>) {
    page.heading("Where the time of the nodes went");
    let mut lost = run.lost();
    lost.sort_by(|a, b| b.part.total_cmp(&a.part));
    let mut parts = vec![("at work".to_owned(), percent(run.busy()), run.busy())];
    parts.extend(lost.iter().map(|lost| (lost.words.to_owned(), percent(lost.part), lost.part)));
    page.split(&parts);
    page.soft(
        "Of all nodes' time, from before the first to after the last pixel, by the clock. A machine that runs more nodes than it has \
         processors lets nodes that are at work wait for each other: that counts as work here.",
    );
}

fn nodes(page: &mut Page, run: &Run<'_>) {
    page.heading("Nodes");
    let rows: Vec<_> = run
        .outcome
        .nodes
        .iter()
        .map(|node| {
            let time = &node.time;
            let waits = [time.idle_data_ns, time.idle_answers_ns, time.idle_credit_ns];
            let idle = waits.into_iter().chain([time.idle_master_ns]);
            vec![
                node.node.to_string(),
                duration(time.busy_ns),
                duration(time.network_ns),
                duration(total(idle)),
                duration(time.idle_work_ns),
                duration(time.process_cpu_ns),
                count(node.counts.tiles),
                count(node.counts.cache.fetched),
                bytes(node.peak_bytes as u64),
                node.process.peak_bytes.map_or_else(|| "-".into(), bytes),
            ]
        })
        .collect();
    let heads = [
        "node",
        "at work",
        "network",
        "waiting",
        "without work",
        "of processors",
        "tiles",
        "blocks fetched",
        "of its memory in use",
        "its process",
    ];
    page.table(&heads, &rows);
}

fn messages(page: &mut Page, run: &Run<'_>) {
    mesh::messages(page, &MessageReport::of(&run.counts));
    let nodes = || run.outcome.nodes.iter();
    let more = [
        ("packets for neighbours that were not there", total(nodes().map(|n| n.time.dropped))),
        ("packets of no process of this mesh", total(nodes().map(|n| n.foreign))),
    ];
    mesh::retries(page, &run.counts, &TileReport::from(run.outcome.ledger), &more);
}

fn memory(page: &mut Page, run: &Run<'_>) {
    page.heading("Memory of a node, by line");
    if let Some(fullest) = run.fullest() {
        page.text(format_args!(
            "At most {} of {} bytes were in use, at node {}.",
            fullest.peak_bytes, run.options.memory, fullest.node
        ));
    }
    if let Some((process, peak)) = run.greatest() {
        page.text(format_args!(
            "The greatest process held {} of {}, program and network included{}.",
            bytes(peak),
            bytes(process.budget_bytes),
            if process.limit_bytes.is_some() { "; the system enforces it" } else { "" },
        ));
    }
    mesh::memory(page, &run.lines());
}

fn faults(page: &mut Page, run: &Run<'_>) {
    let replaced = &run.outcome.replacements;
    if replaced.is_empty() {
        return;
    }
    page.heading("Faults");
    let nodes = counted(replaced.len() as u64, ["node was", "nodes were"]);
    page.text(format_args!("{nodes} replaced; {}.", super::UNCOUNTED));
    for replacement in replaced {
        page.text(format_args!("Node {} was replaced: {}.", replacement.node, replacement.cause));
    }
}

fn the_run(page: &mut Page, run: &Run<'_>, mesh: &str, stops: f32) {
    let size = (run.options.width, run.options.height);
    let mut rows = html::pairs(run.scene, run.scenes, size, &run.options.settings, stops);
    rows.extend([
        ("mesh", mesh.to_owned()),
        ("time of all", format!("{:.2} s", run.time_s)),
        ("hash of the pixels", run.image_hash.clone()),
        ("version", env!("CARGO_PKG_VERSION").to_owned()),
    ]);
    page.heading("The run");
    page.pairs(&rows);
}
