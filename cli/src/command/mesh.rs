//! What is told of a run on a mesh, whatever its nodes are: simulated ones, or processes.

use kiloray_core::node::Counts;
use kiloray_render::{Picture, ThreadScratch};
use kiloray_sim::{MessageReport, TASK_BYTES, TileReport};
use serde::Serialize;
use serde_json::{Value, json};

use super::{html, report};
use crate::{
    args::firmware,
    console::{bytes, count, percent},
    page::{Bar, Page},
    scene::Scene,
};

/// A part of the time of all nodes that did not go into the picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Loss {
    /// Its name in the JSON.
    pub(super) name: &'static str,
    /// In words.
    pub(super) words: &'static str,
    /// Of nodes × time.
    pub(super) part: f64,
}

/// Losses, by name. (None is -0, which a table of numbers would show.)
pub(super) fn losses_json(losses: &[Loss]) -> Value {
    losses.iter().map(|loss| (loss.name.to_owned(), json!(loss.part + 0.0))).collect()
}

/// Requests made again.
pub(super) fn again(counts: &Counts) -> u64 {
    total([counts.rays_again, counts.fetches_again, counts.tiles_again].into_iter())
}

/// Adds what nodes did to a report.
pub(super) fn add_counts(report: &mut Value, counts: &Counts) {
    let (rays, cache) = (&counts.shade, &counts.cache);
    let done = [
        (
            "rays",
            json!({
                "primary": rays.primary,
                "shadow": rays.shadow,
                "specular": rays.specular,
                "ambient": 0,
            }),
        ),
        (
            "cache",
            json!({ "hits": cache.hits, "misses": cache.misses, "evictions": cache.evictions }),
        ),
        ("migrated", counts.migrated.into()),
        ("retries", again(counts).into()),
        (
            "retries_by_cause",
            json!({
                "rays": counts.rays_again,
                "fetches": counts.fetches_again,
                "tiles": counts.tiles_again,
            }),
        ),
        ("refusals", counts.refused.into()),
        ("run_at_home", counts.run_at_home.into()),
        // What came and was of no use.
        (
            "dropped",
            json!({
                "packets_damaged": counts.damaged,
                "blocks_damaged": counts.blocks_refused,
                "unasked": counts.unasked,
            }),
        ),
    ];
    for (name, value) in done {
        report[name] = value;
    }
}

/// A line of a node's memory.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub(super) struct Line<'a> {
    /// What it is for.
    #[serde(rename = "line")]
    pub(super) name: &'a str,
    /// Items it can hold.
    pub(super) capacity: usize,
    /// Bytes it takes.
    pub(super) bytes: usize,
    /// Most items it ever held.
    pub(super) peak: usize,
    /// Their bytes.
    pub(super) peak_bytes: usize,
}

/// Of all nodes' lines one of each name, with the peak of the node that had the greatest; those that take nothing are left out.
pub(super) fn greatest<'a>(all: impl Iterator<Item = Line<'a>>) -> Vec<Line<'a>> {
    let mut lines: Vec<Line<'a>> = Vec::new();
    for line in all {
        match lines.iter_mut().find(|most| most.name == line.name) {
            Some(most) if line.peak_bytes > most.peak_bytes => *most = line,
            Some(_) => {}
            None => lines.push(line),
        }
    }
    lines.retain(|line| line.bytes > 0);
    lines
}

/// Why a block counts as lost: in a simulation dead nodes' routers tell of deaths, elsewhere nobody does.
#[derive(Debug, Clone, Copy)]
pub(super) enum Why {
    NoneLives,
    NoneAnswers,
}

impl Why {
    /// The words.
    pub(super) fn lost(self, block: u32) -> String {
        let why = match self {
            Self::NoneLives => "no living node holds a copy",
            Self::NoneAnswers => "of those that hold a copy none has answered",
        };
        format!("block {block} is lost: {why}")
    }
}

/// Says that the picture is not complete, and why.
pub(super) fn incomplete(page: &mut Page, why: &str) {
    page.warning(format!("The picture is incomplete: {why}."));
}

/// What a node takes beside the memory that it divides.
pub(super) fn beside() -> String {
    format!(
        "Beside it a node takes {TASK_BYTES} bytes of this machine's memory for its task (`size_of`), and a stack: {} bytes where it was measured, on {}. All nodes of a thread trace their rays in {} bytes that it lends (on a board rays go one by one, and theirs lie on the stack).",
        firmware::PAINTED,
        firmware::PAINTED_ON,
        ThreadScratch::BYTES
    )
}

/// The same, for scripts.
pub(super) fn beside_json() -> Value {
    let (stack, on) = (firmware::PAINTED, firmware::PAINTED_ON);
    let lent = ThreadScratch::BYTES;
    json!({ "task": TASK_BYTES, "stack_measured": stack, "stack_measured_on": on, "lent_by_thread": lent })
}

/// The part of the accesses that hit the cache.
pub(super) fn cache_hits(counts: &Counts) -> String {
    let cache = &counts.cache;
    match cache.hits.saturating_add(cache.misses) {
        0 => "-".into(),
        asked => percent(part(cache.hits, asked)),
    }
}

/// A table of messages by kind.
pub(super) fn messages(page: &mut Page, messages: &[MessageReport]) {
    page.heading("Messages");
    let all = total(messages.iter().map(|m| m.sent_bytes));
    let rows: Vec<_> = messages
        .iter()
        .map(|m| {
            let mean = m.sent_bytes as f64 / m.sent.max(1) as f64;
            vec![
                words(m.kind).to_owned(),
                count(m.sent),
                bytes(m.sent_bytes),
                format!("{mean:.0} B"),
                percent(part(m.sent_bytes, all)),
                count(m.received),
            ]
        })
        .collect();
    page.table(&["kind", "sent", "bytes", "mean", "of all bytes", "handled"], &rows);
}

fn words(kind: &str) -> &str {
    match kind {
        "fetch" => "requests for blocks",
        "part" => "pieces of blocks",
        "tile" => "tiles: asked for, given, pixels",
        "ray" => "rays",
        "answer" => "answers to rays",
        "refusal" => "refusals",
        other => other,
    }
}

/// What the summary says of a picture that is not complete; nothing of one that is.
pub(super) fn so_far(picture: &Picture, complete: bool, tiles: &TileReport) -> String {
    if complete {
        return String::new();
    }
    let all = u64::from(picture.width) * u64::from(picture.height);
    format!("; INCOMPLETE: {} of {all} pixels", tiles.pixels)
}

/// What was refused, or done again; `more` is what only one kind of mesh knows.
pub(super) fn retries(page: &mut Page, c: &Counts, tiles: &TileReport, more: &[(&str, u64)]) {
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
    ]
    .iter()
    .chain(more)
    .filter(|&&(_, n)| n > 0)
    .map(|&(name, n)| Bar::new(name, n, n as f64))
    .collect();
    page.heading("Refusals and retries");
    if rows.is_empty() {
        page.text("None.");
    } else {
        page.bars(&rows);
    }
}

/// A table of the lines of a node's memory.
pub(super) fn memory(page: &mut Page, lines: &[Line<'_>]) {
    let rows: Vec<_> = lines
        .iter()
        .map(|line| {
            vec![
                line.name.to_owned(),
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
    page.soft("Each line, what is planned and what was in use, is of the node that had the most of it in use: not all are of one node.");
}

/// Rays by kind, and what was skipped.
pub(super) fn rays(page: &mut Page, scene: &Scene, c: &Counts) {
    page.heading("Rays");
    let rows = [
        ("primary", c.shade.primary),
        ("shadow", c.shade.shadow),
        ("specular", c.shade.specular),
        ("sent to another node", c.migrated),
        ("run for another node", c.visitors),
    ];
    page.bars(&rows.map(|(name, n)| Bar::new(name, count(n), n as f64)));
    html::skipped(page, scene, &report::skipped(scene, &c.shade));
}

/// A share; of nothing, 0.
pub(super) fn part(of: u64, all: u64) -> f64 {
    of as f64 / all.max(1) as f64
}

/// The sum of what nodes say, which may be anything.
pub(super) fn total(counts: impl Iterator<Item = u64>) -> u64 {
    counts.fold(0, u64::saturating_add)
}
