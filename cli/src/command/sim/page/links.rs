use std::fmt::Write;

use kiloray_sim::LinkReport;

use super::super::{Run, cut::link_name};
use crate::{
    chart::{Layout, Line, Lines, Mark, Scale, heat, scale_bar},
    console::{bytes, count, duration, percent},
    page::Page,
};

/// Most links that are drawn one by one.
const LINKS_MAX: usize = 6000;
/// Rows of the table.
const BUSIEST: usize = 6;

/// How the links were used.
pub(super) fn draw(page: &mut Page, run: &Run<'_>, layout: &Layout) {
    let report = &run.done.outcome.report;
    let busy = |link: &LinkReport| link.busy_ns as f64 / report.virtual_ns.max(1) as f64;
    let mut links: Vec<_> = report.links.iter().collect();
    if links.is_empty() {
        return;
    }
    links.sort_by(|a, b| busy(b).total_cmp(&busy(a)));
    page.heading("Links");
    page.raw("<div class=\"beside\">\n");
    page.raw(&network(run, layout, busy(links[0]), &busy));
    let all = links.len() as f64;
    let points = links.iter().enumerate();
    // As many points as can be told apart.
    let every = links.len().div_ceil(300);
    let points = points
        .filter(|(i, _)| i % every == 0 || i + 1 == links.len())
        .map(|(i, link)| (100.0 * i as f64 / (all - 1.0).max(1.0), 100.0 * busy(link)))
        .collect();
    let chart = Lines {
        title: "From the busiest link to the idlest",
        x: Scale::Even,
        x_name: "% of all links, each way",
        y_name: "% of the time in use",
        y: Scale::Even,
        y_max: None,
        lines: vec![Line { name: String::new(), mark: Mark::Line, colour: 0, points }],
        size: [520, 270],
        alone: false,
    };
    page.raw(&chart.svg());
    page.raw("\n</div>\n");
    let rows: Vec<_> = links
        .iter()
        .take(BUSIEST)
        .map(|link| {
            vec![
                link_name(link),
                percent(busy(link)),
                bytes(link.bytes),
                count(link.packets),
                count(link.control_packets),
                format!("{} of {}", link.buffers_peak, link.buffers),
            ]
        })
        .collect();
    let heads =
        ["busiest links", "in use", "bytes", "packets", "for credit only", "buffers, most in use"];
    page.table(&heads, &rows);
    if let Some(cut) = &run.cut {
        page.text(format_args!(
            "The worst cut is {}: {} over {} {} take {} at least, {} of the time measured.",
            cut.name,
            bytes(cut.bytes),
            cut.links,
            if cut.links == 1 { "link" } else { "links" },
            duration(cut.bound_ns),
            percent(cut.bound_ns as f64 / report.virtual_ns.max(1) as f64)
        ));
    }
}

/// Each direction of each link as a stroke from its node towards the next; empty where there are too many.
fn network(run: &Run<'_>, layout: &Layout, most: f64, busy: &dyn Fn(&LinkReport) -> f64) -> String {
    let report = &run.done.outcome.report;
    let is_plane = report.mesh.shape == "grid" && report.mesh.sizes.len() <= 2;
    if !is_plane || report.links.len() > LINKS_MAX || report.nodes.len() < 2 {
        return String::new();
    }
    let [w, h] = layout.size;
    let scale = (360.0 / (w + 1.0).max(h + 1.0)).min(44.0);
    let mut svg = format!(
        "<figure class=\"map\"><figcaption>part of the time that each link was in use</figcaption><svg width=\"{0:.0}\" height=\"{1:.0}\" viewBox=\"{2:.1} {2:.1} {0:.1} {1:.1}\" role=\"img\" aria-label=\"use of the links\">",
        (w + 1.0) * scale,
        (h + 1.0) * scale,
        -scale / 2.0,
    );
    let _ =
        write!(svg, "<g stroke-width=\"{:.1}\" stroke-linecap=\"round\">", (scale * 0.13).max(1.0));
    for link in &report.links {
        let (Some(from), Some(to)) = (link.from, link.to) else { continue };
        let ends = [from, to].map(|node| layout.middle(usize::from(node)));
        let [Some(a), Some(b)] = ends else { continue };
        let delta = [b[0] - a[0], b[1] - a[1]];
        let length = delta[0].hypot(delta[1]);
        if length <= 0.0 {
            continue;
        }
        // A link that closes a ring leaves on the other side.
        let is_far = length > 1.5
            && layout.size.iter().any(|&size| size > 2.0 && length > size - 1.5)
            && layout.is_of_boxes();
        let sign = if is_far { -1.0 } else { 1.0 };
        let along = delta.map(|d| sign * d / length);
        let reach = if is_far { 0.72 } else { (length - 0.28).min(0.72) };
        // Beside the link that comes the other way.
        let side = [-along[1] * 0.12, along[0] * 0.12];
        let at = |t: f64| [0, 1].map(|i| (a[i] + along[i] * t + side[i]) * scale);
        let ([x1, y1], [x2, y2]) = (at(0.28), at(reach));
        let value = busy(link);
        let _ = write!(
            svg,
            "<path stroke=\"{}\" d=\"M{x1:.1},{y1:.1}L{x2:.1},{y2:.1}\"><title>{}: {}</title></path>",
            heat(if most > 0.0 { value / most } else { 0.0 }).1,
            link_name(link),
            percent(value)
        );
    }
    svg.push_str("</g><g fill=\"none\" stroke=\"currentColor\" stroke-opacity=\".5\">");
    for node in 0..report.nodes.len() {
        if let Some([x, y]) = layout.middle(node) {
            let is_host = report.mesh.attached.iter().any(|&n| usize::from(n) == node);
            let fill = if is_host { " fill=\"currentColor\"" } else { "" };
            let _ = write!(
                svg,
                "<circle cx=\"{:.1}\" cy=\"{:.1}\" r=\"{:.1}\"{fill}/>",
                x * scale,
                y * scale,
                scale * 0.2
            );
        }
    }
    let scale = scale_bar("0 %", &percent(most));
    let _ = writeln!(
        svg,
        "</g></svg>{scale}<p class=\"mean\">filled: the host is attached there</p></figure>"
    );
    svg
}
