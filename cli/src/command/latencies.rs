//! How long nodes waited, on a page.

use kiloray_sim::{Histogram, Latencies};

use crate::{
    chart::{Line, Lines, Mark, Scale},
    console::{count, duration},
    page::Page,
};

/// How long things took.
pub(super) fn latencies(page: &mut Page, l: &Latencies) {
    let kinds = [
        ("a block, from request to arrival", &l.fetch),
        ("a ray, from departure to answer", &l.ray),
        ("a tile, from grant to last pixel", &l.tile),
    ];
    if kinds.iter().all(|(_, h)| h.count == 0) {
        return;
    }
    page.heading("How long things took");
    let row = |(name, h): &(&str, &Histogram)| {
        let mut row = vec![(*name).to_owned(), count(h.count)];
        let times = [h.min, h.mean.round() as u64, h.p50, h.p90, h.p99, h.p999, h.max];
        row.extend(times.map(duration));
        row
    };
    let rows: Vec<_> = kinds.iter().filter(|(_, h)| h.count > 0).map(row).collect();
    let heads = ["", "count", "least", "mean", "50 %", "90 %", "99 %", "99.9 %", "most"];
    page.table(&heads, &rows);
    let lines: Vec<_> = kinds
        .iter()
        .enumerate()
        .filter(|(_, (_, h))| h.count > 0)
        .map(|(colour, (name, h))| Line {
            name: name.split(',').next().unwrap_or_default().into(),
            mark: Mark::Dots,
            colour,
            points: h
                .buckets
                .iter()
                .map(|b| (b.up_to as f64 / 1e3, 100.0 * b.count as f64 / h.count as f64))
                .collect(),
        })
        .collect();
    page.raw(
        &Lines {
            title: "",
            x: Scale::Doubling,
            x_name: "µs, by powers of two",
            y_name: "%",
            y: Scale::Even,
            y_max: None,
            lines,
            size: [760, 260],
            alone: false,
        }
        .svg(),
    );
    page.raw("\n");
}
