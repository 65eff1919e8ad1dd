//! The page about a run on a mesh.

mod links;
mod maps;
mod time;

use super::{Run, cut::link_name, lines, lost::lost, summary, why_incomplete};
use crate::{
    chart::Layout,
    command::{
        division,
        html::{self, Shown},
        latencies::latencies,
        mesh::{self, part},
    },
    console::{bytes, count, duration, percent, rate},
    page::{Bar, Page},
};

/// Draws it.
pub(super) fn page(run: &Run<'_>, shown: &Shown<'_>) -> String {
    let outcome = &run.done.outcome;
    let report = &outcome.report;
    let mut page = Page::new(&format!("{} on {}", run.scene.name, run.topology));
    page.soft(summary::mesh(run));
    if let Some(why) = why_incomplete(outcome.end, run.options) {
        mesh::incomplete(&mut page, &why);
    }
    page.cards(&cards(run));
    page.raw("<div class=\"beside\"><div>\n");
    page.picture(shown.picture, &shown.png);
    page.raw("</div><div class=\"rest\">\n");
    lost_time(&mut page, run);
    page.raw("</div></div>\n");
    lower_bounds(&mut page, run);
    let layout = Layout::new(&report.mesh);
    maps::draw(&mut page, run, &layout);
    time::lines(&mut page, run);
    links::draw(&mut page, run, &layout);
    latencies(&mut page, &report.latencies);
    messages(&mut page, run);
    memory(&mut page, run);
    mesh::rays(&mut page, run.scene, &report.totals.counts);
    faults(&mut page, run);
    the_run(&mut page, run, shown);
    machine(&mut page, run);
    for note in &run.scene.notes {
        page.text(format_args!("Note: {note}"));
    }
    page.finish()
}

fn cards(run: &Run<'_>) -> Vec<(&'static str, String)> {
    let report = &run.done.outcome.report;
    let counts = &report.totals.counts;
    let mut cards = vec![("virtual time", duration(report.virtual_ns))];
    if let Some(efficiency) = run.done.efficiency() {
        let speed_up = efficiency * report.nodes.len() as f64;
        cards.push(("parallel efficiency", format!("{efficiency:.3}")));
        cards.push(("times as fast as one node", format!("{speed_up:.1}")));
    }
    cards.extend([
        (
            "of a node's memory at most used",
            percent(part(report.totals.peak_bytes as u64, run.options.mesh.memory as u64)),
        ),
        ("blocks fetched", count(counts.cache.fetched)),
        ("of accesses hit the cache", mesh::cache_hits(counts)),
        ("rays migrated", count(counts.migrated)),
        ("messages", count(report.messages.iter().map(|m| m.sent).sum())),
    ]);
    cards
}

fn lost_time(page: &mut Page, run: &Run<'_>) {
    let report = &run.done.outcome.report;
    page.heading("Where the time of the nodes went");
    let useful = match run.done.efficiency() {
        Some(efficiency) => ("what one node needs for the picture".to_owned(), efficiency),
        None => {
            let time = &report.totals.time;
            let all = report.nodes.len() as u64 * report.virtual_ns;
            ("tracing and shading".to_owned(), part(time.trace + time.shade, all))
        }
    };
    let mut losses = lost(report, run.done.compared());
    losses.sort_by(|a, b| b.part.total_cmp(&a.part));
    let mut parts = vec![(useful.0, percent(useful.1), useful.1)];
    parts.extend(losses.iter().map(|loss| (loss.words.to_owned(), percent(loss.part), loss.part)));
    page.split(&parts);
    for loss in losses.iter().filter(|loss| loss.part <= -0.000_5) {
        page.soft(format_args!(
            "{}: {}. The mesh does less of it than one node.",
            loss.words,
            percent(loss.part)
        ));
    }
    page.soft("Of all nodes' time, from the first event to the last pixel.");
    if run.done.efficiency().is_some() {
        page.soft(
            "Efficiency is what one node of the same profile, with the whole scene in its memory, \
             needs for the same picture. As it divides that memory in its own way, what it needs \
             can be a few per cent more than the work of the mesh where pictures are small: then \
             efficiency can exceed 1.",
        );
    }
}

fn lower_bounds(page: &mut Page, run: &Run<'_>) {
    let report = &run.done.outcome.report;
    let mut rows: Vec<_> = run
        .bounds()
        .into_iter()
        .map(|bound| Bar::new(bound.text, duration(bound.ns), bound.ns as f64))
        .collect();
    rows.push(Bar::new("measured", duration(report.virtual_ns), report.virtual_ns as f64));
    page.heading("Lower bounds, and what was measured");
    page.bars(&rows);
    if run.done.compared().is_some() {
        page.soft(
            "The work of one node is that of another run, with other tiles: a bound but for a few per cent.",
        );
    }
}

fn messages(page: &mut Page, run: &Run<'_>) {
    let report = &run.done.outcome.report;
    mesh::messages(page, &report.messages);
    page.soft(format_args!(
        "On the links: {} packets, one for each hop, and {} that bring credit only; {} with headers.",
        count(report.totals.packets),
        count(report.totals.control_packets),
        bytes(report.totals.link_bytes)
    ));
    let c = &report.totals.counts;
    mesh::retries(page, c, &report.tiles, &[]);
    page.soft(format_args!(
        "{} times a step went to other work for want of a frame, a slot or room to send.",
        count(c.stalls)
    ));
}

fn memory(page: &mut Page, run: &Run<'_>) {
    let report = &run.done.outcome.report;
    page.heading("Memory of a node, by line");
    page.text(format_args!(
        "At most {} of {} bytes were in use, at node {}; {} in the mean over nodes. Blocks that a node owns, {} at most, lie {}.",
        report.totals.peak_bytes,
        run.options.mesh.memory,
        report.totals.peak_node,
        bytes(report.nodes.iter().map(|n| n.peak_bytes as u64).sum::<u64>() / report.nodes.len().max(1) as u64),
        report.nodes.iter().map(|n| n.owned_blocks).max().unwrap_or(0),
        if run.options.mesh.owned_in_arena { "in it too" } else { "apart from it, read-only" },
    ));
    mesh::memory(page, &lines(report));
    page.soft(mesh::beside());
}

fn faults(page: &mut Page, run: &Run<'_>) {
    let report = &run.done.outcome.report;
    let Some(words) = summary::faults(run) else { return };
    page.heading("Faults");
    page.text(words);
    for crash in &report.faults.crashes {
        page.text(format_args!("Node {} crashed at {}.", crash.node, duration(crash.at_ns)));
    }
    for slow in &run.options.faults.slow {
        page.text(format_args!("Node {} is slower by a factor of {}.", slow.node.0, slow.factor));
    }
}

fn the_run(page: &mut Page, run: &Run<'_>, shown: &Shown<'_>) {
    let report = &run.done.outcome.report;
    let (o, scenes) = (run.options, &run.sim.scene.scenes);
    let size = (o.mesh.width, o.mesh.height);
    let mut rows = html::pairs(run.scene, scenes, size, &o.mesh.settings, shown.stops);
    rows.extend([
        ("mesh", summary::mesh(run)),
        (
            "links",
            format!(
                "{} each way, {}, packets of {}, {}",
                rate(o.link.bandwidth),
                duration(o.link.latency),
                bytes(run.done.outcome.division.packet.into()),
                match o.link.switching {
                    kiloray_sim::Switching::StoreAndForward => "store and forward",
                    kiloray_sim::Switching::CutThrough => "cut through",
                }
            ),
        ),
        ("host at nodes", format!("{:?}", report.mesh.attached).replace(['[', ']'], "")),
        ("shadow rays", format!("{:?}", o.mesh.shadow).to_lowercase()),
        ("points live with", format!("{:?}", o.mesh.points).to_lowercase()),
        ("prefetch", division::prefetch(o.mesh.prefetch)),
        ("copies of a block", o.mesh.replicas.to_string()),
        ("seed of faults", o.seed.to_string()),
        ("simulated in", format!("{:.2} s, {} events", run.done.all_s, count(report.events))),
        ("hash of the pixels", run.done.image_hash.clone()),
        ("hash of the events", report.fingerprint.clone()),
        ("version", env!("CARGO_PKG_VERSION").to_owned()),
    ]);
    page.heading("The run");
    page.pairs(&rows);
    if let Some(link) = run.busiest_link() {
        page.soft(format_args!("The busiest link is {}.", link_name(link)));
    }
}

/// What the virtual time is made of.
fn machine(page: &mut Page, run: &Run<'_>) {
    let p = &run.options.profile;
    page.heading("What operations take");
    page.text(format_args!("Profile {}, {}.", p.name, p.source));
    let each = |(name, ns): (&str, f64)| {
        vec![name.to_owned(), if ns < 1.0 { format!("{ns:.3} ns") } else { format!("{ns:.1} ns") }]
    };
    page.table(&["operation", "time"], &p.operations().map(each));
}
