//! The page about a run of processes.

use kiloray_sim::TileReport;

use super::{Run, total};
use crate::{
    command::{html::Shown, report, sim::words},
    console::{bytes, count, duration, percent},
    page::{Bar, Page},
};

/// Draws it.
pub(super) fn page(run: &Run<'_>, shown: &Shown<'_>) -> String {
    let outcome = run.outcome;
    let mesh = run.mesh();
    let mut page = Page::new(&format!("{} on {mesh}", run.scene.name));
    if !outcome.complete {
        page.warning(match outcome.lost {
            Some(block) => format!(
                "The picture is incomplete: block {block} is lost, no living node holds a copy."
            ),
            None => "The picture is incomplete: the run was stopped.".into(),
        });
    }
    page.cards(&cards(run));
    page.raw("<div class=\"beside\"><div>\n");
    page.picture(shown.picture, &shown.png);
    page.raw("</div><div class=\"rest\">\n");
    time(&mut page, run);
    page.raw("</div></div>\n");
    nodes(&mut page, run);
    messages(&mut page, run);
    memory(&mut page, run);
    rays(&mut page, run);
    faults(&mut page, run);
    the_run(&mut page, run, &mesh, shown.stops);
    for note in &run.scene.notes {
        page.text(format_args!("Note: {note}"));
    }
    page.finish()
}

fn cards(run: &Run<'_>) -> Vec<(&'static str, String)> {
    let counts = &run.counts;
    let asked = counts.cache.hits.saturating_add(counts.cache.misses);
    let sent = counts.sent.named();
    let mut cards = vec![
        ("from the first to the last pixel", duration(run.outcome.render.as_nanos() as u64)),
        ("until all nodes were there", duration(run.outcome.start.as_nanos() as u64)),
    ];
    if let Some(fullest) = run.fullest() {
        let used = part(fullest.peak_bytes as u64, run.options.memory as u64);
        cards.push(("of a node's memory at most used", percent(used)));
    }
    cards.extend([
        ("blocks fetched", count(counts.cache.fetched)),
        (
            "of accesses hit the cache",
            if asked > 0 { percent(part(counts.cache.hits, asked)) } else { "-".into() },
        ),
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
        "Of all nodes' time, from the first to the last pixel, by the clock. A machine that runs more nodes than it has \
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
            let idle = [time.idle_data_ns, time.idle_answers_ns, time.idle_credit_ns];
            vec![
                node.node.to_string(),
                duration(time.busy_ns),
                duration(time.network_ns),
                duration(total(idle.into_iter())),
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
    page.heading("Messages");
    let (sent, received) = (run.counts.sent.named(), run.counts.received.named());
    let all = total(sent.iter().map(|(_, kind)| kind.bytes));
    let rows: Vec<_> = sent
        .iter()
        .zip(&received)
        .map(|((kind, sent), (_, received))| {
            let mean = sent.bytes as f64 / sent.count.max(1) as f64;
            vec![
                words(kind).to_owned(),
                count(sent.count),
                bytes(sent.bytes),
                format!("{mean:.0} B"),
                percent(part(sent.bytes, all)),
                count(received.count),
            ]
        })
        .collect();
    page.table(&["kind", "sent", "bytes", "mean", "of all bytes", "handled"], &rows);
    let c = &run.counts;
    let tiles = TileReport::from(run.outcome.ledger);
    let nodes = || run.outcome.nodes.iter();
    let rows: Vec<_> = [
        ("rays that a full node refused", c.refused),
        ("rays run at home after too many refusals", c.run_at_home),
        ("rays sent again after their time limit", c.rays_again),
        ("blocks asked for again after their time limit", c.fetches_again),
        ("tiles sent again to the host", c.tiles_again),
        ("tiles out for long, given to another node too", tiles.given_again),
        ("asks for tiles that came again", tiles.asked_again),
        ("pixels that the host had already", tiles.pixels_again),
        ("messages that made no sense to the host", tiles.refused),
        ("answers that nobody waited for: late, doubled", c.unasked),
        ("packets that could not be read", c.damaged),
        ("blocks that arrived damaged", c.blocks_refused),
        ("packets for neighbours that were not there", total(nodes().map(|n| n.time.dropped))),
        ("packets of no process of this mesh", total(nodes().map(|n| n.foreign))),
    ]
    .into_iter()
    .filter(|&(_, n)| n > 0)
    .map(|(name, n)| Bar::new(name, count(n), n as f64))
    .collect();
    page.heading("Refusals and retries");
    if rows.is_empty() {
        page.text("None.");
    } else {
        page.bars(&rows);
    }
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
    let rows: Vec<_> = run
        .lines()
        .iter()
        .map(|line| {
            vec![
                line.name.clone(),
                line.capacity.to_string(),
                line.peak.to_string(),
                line.bytes.to_string(),
                line.peak_bytes.to_string(),
                percent(part(line.peak_bytes as u64, line.bytes as u64)),
            ]
        })
        .collect();
    let heads =
        ["line", "items planned", "most in use", "bytes planned", "most in use", "of the plan"];
    page.table(&heads, &rows);
    page.soft("'Most in use' is of the node that had the most in this line.");
}

fn rays(page: &mut Page, run: &Run<'_>) {
    let c = &run.counts;
    page.heading("Rays");
    let rows = [
        ("primary", c.shade.primary),
        ("shadow", c.shade.shadow),
        ("specular", c.shade.specular),
        ("sent to another node", c.migrated),
        ("run for another node", c.visitors),
    ];
    page.bars(&rows.map(|(name, n)| Bar::new(name, count(n), n as f64)));
    crate::command::html::skipped(page, run.scene, &report::skipped(run.scene, &c.shade));
}

fn faults(page: &mut Page, run: &Run<'_>) {
    let replaced = &run.outcome.replacements;
    if replaced.is_empty() {
        return;
    }
    page.heading("Faults");
    page.text(super::UNCOUNTED);
    for replacement in replaced {
        page.text(format_args!("Node {} was replaced: {}.", replacement.node, replacement.cause));
    }
}

fn the_run(page: &mut Page, run: &Run<'_>, mesh: &str, stops: f32) {
    let file = run.scene.file.view();
    let header = file.header();
    let settings = &run.options.settings;
    let sources: Vec<_> = run.scenes.iter().map(|scene| scene.display().to_string()).collect();
    page.heading("The run");
    page.pairs(&[
        ("scene", sources.join(", ")),
        ("surfaces", count(header.primitives.into())),
        (
            "blocks",
            format!(
                "{} of {}, {}",
                count(header.blocks.into()),
                bytes(header.block_bytes.into()),
                bytes(u64::from(header.blocks) * u64::from(header.block_bytes))
            ),
        ),
        ("picture", format!("{} x {}", run.options.width, run.options.height)),
        ("samples", settings.samples.to_string()),
        ("bounces", settings.bounces.to_string()),
        ("exposure", format!("{stops} stops")),
        ("seed", settings.seed.to_string()),
        ("mesh", mesh.to_owned()),
        ("time of all", format!("{:.2} s", run.time_s)),
        ("hash of the pixels", run.image_hash.clone()),
        ("version", env!("CARGO_PKG_VERSION").to_owned()),
    ]);
}

fn part(of: u64, all: u64) -> f64 {
    of as f64 / all.max(1) as f64
}
