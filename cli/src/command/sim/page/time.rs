use kiloray_sim::Sample;

use super::super::Run;
use crate::{
    chart::{Line, Lines, Mark, SERIES, Scale, css},
    page::Page,
};

/// How the run went on.
pub(super) fn lines(page: &mut Page, run: &Run<'_>) {
    let report = &run.done.outcome.report;
    let samples = &report.timeline.samples;
    if samples.len() < 2 {
        return;
    }
    page.heading("Over time");
    let (unit, name) = match report.virtual_ns {
        0..2_000_000 => (1e3, "virtual time, µs"),
        2_000_000..2_000_000_000 => (1e6, "virtual time, ms"),
        _ => (1e9, "virtual time, s"),
    };
    let step = report.timeline.step_ns as f64 / unit;
    let at_steps = |values: &[f64]| -> Vec<_> {
        values.iter().enumerate().map(|(i, &y)| ((i as f64 + 0.5) * step, y)).collect()
    };
    let line = |name: &str, mark, colour, of: &dyn Fn(&Sample) -> f64| Line {
        name: name.into(),
        mark,
        colour,
        points: at_steps(&samples.iter().map(of).collect::<Vec<_>>()),
    };
    let draw = |title: &str, y_name: &str, y_max, lines| {
        Lines {
            title,
            x: Scale::Even,
            x_name: name,
            y_name,
            y: Scale::Even,
            y_max,
            lines,
            size: [520, 250],
            alone: false,
        }
        .svg()
    };
    let nodes = report.nodes.len() as f64;
    page.raw("<div class=\"beside\">\n");
    // Each area hides the lower part of the one before it.
    page.raw(&draw(
        "What the nodes do",
        "nodes",
        Some(nodes),
        vec![
            line("", Mark::Area, 4, &|s| s.busy + s.waiting + s.idle),
            line("", Mark::Area, 1, &|s| s.busy + s.waiting),
            line("", Mark::Area, 2, &|s| s.busy),
            line("", Mark::Area, 0, &|s| s.useful),
        ],
    ));
    page.raw(&draw(
        "Efficiency: nodes' time spent tracing and shading",
        "%",
        Some(100.0),
        vec![line("", Mark::Line, 0, &|s| 100.0 * s.useful / nodes)],
    ));
    page.raw(&draw(
        "Rays held for later, in all nodes",
        "rays",
        None,
        vec![line("", Mark::Line, 0, &|s| s.stored as f64)],
    ));
    // All links in both directions; the last step may be a short one.
    let step_ns = report.timeline.step_ns;
    let rate = report.links.len().max(1) as f64 * run.options.link.bandwidth as f64 / 1e9;
    let load = |(i, sample): (u64, &Sample)| {
        let ns = report.virtual_ns.saturating_sub(i * step_ns).clamp(1, step_ns.max(1));
        100.0 * sample.link_bytes as f64 / (rate * ns as f64).max(1.0)
    };
    let loads: Vec<f64> = (0..).zip(samples).map(load).collect();
    page.raw(&draw(
        "Load of the links",
        "% of their bandwidth",
        None,
        vec![Line { points: at_steps(&loads), ..line("", Mark::Line, 7, &|_| 0.0) }],
    ));
    let pixels = (f64::from(run.options.mesh.width) * f64::from(run.options.mesh.height)).max(1.0);
    page.raw(&draw(
        "Pixels done",
        "%",
        Some(100.0),
        vec![line("", Mark::Line, 3, &|s| 100.0 * s.pixels as f64 / pixels)],
    ));
    page.raw("</div>\n<p class=\"soft\">What the nodes do: ");
    for (colour, what) in [
        (0, "tracing and shading"),
        (2, "at other work"),
        (1, "waiting for blocks, answers or room"),
        (4, "without work"),
    ] {
        page.raw(&format!(
            "<i class=\"key\" style=\"background:{}\"></i>{what} &ensp;",
            css(SERIES[colour])
        ));
    }
    page.raw("\n");
}
