use super::{
    plots::Plot,
    point::heads,
    table::{LOST, Row},
};
use crate::{
    args,
    console::{bytes, count, duration, percent},
    page::{Page, escaped},
};

/// All points on one page.
pub(super) fn page(sweep: &args::Sweep, rows: &[Row], plots: &[(String, Vec<Plot>)]) -> String {
    let scenes: Vec<_> = sweep.scene.scenes.iter().map(|s| s.display().to_string()).collect();
    let axes: Vec<_> = sweep.over.iter().map(|axis| axis.option.as_str()).collect();
    let mut page = Page::new(&format!("{} over {}", scenes.join(", "), axes.join(" and ")));
    page.raw(&format!("<p class=\"soft\"><code>{}</code>\n", escaped(&command(sweep))));
    let failed = rows.iter().filter(|row| row.error.is_some()).count();
    page.text(format_args!(
        "{} points{}",
        rows.len(),
        if failed > 0 { format!(", of which {failed} failed") } else { String::new() }
    ));
    for (over, plots) in plots {
        if !over.is_empty() {
            page.heading(&format!("Over {over}"));
        }
        page.raw("<div class=\"beside\">\n");
        for plot in plots {
            page.raw(&plot.svg(false));
            page.raw("\n");
        }
        page.raw("</div>\n");
    }
    page.heading("All points");
    let mut heads = heads(sweep);
    heads.extend([
        "virtual time",
        "speed-up",
        "efficiency",
        "fetched",
        "migrated",
        "messages",
        "memory",
    ]);
    heads.extend(LOST.map(|(_, _, head)| head));
    let cells: Vec<_> = rows.iter().filter(|row| row.error.is_none()).map(cells).collect();
    page.table(&heads, &cells);
    page.soft(
        "Efficiency = T1 / (nodes x TN), with T1 the virtual time of one node that has the whole \
         scene in its memory. The last columns are what the rest of the nodes' time went to: \
         waiting for blocks, for answers to rays, for room to send and for the host; no work left; \
         handling messages, and those of refused rays; checking blocks, passing on packets of \
         others, clipping bundles; tracing that one node does not do; nodes after their crash, and \
         slow ones. All figures are in sweep.csv.",
    );
    if failed > 0 {
        page.heading("Points that failed");
        let errors = rows.iter().filter_map(|row| Some((row, row.error.as_ref()?)));
        let errors: Vec<_> = errors
            .map(|(row, error)| row.values.iter().cloned().chain([error.clone()]).collect())
            .collect();
        let heads: Vec<_> = super::point::heads(sweep).into_iter().chain(["error"]).collect();
        page.table(&heads, &errors);
    }
    page.finish()
}

fn cells(row: &Row) -> Vec<String> {
    let number = |at: &str| row.number(at);
    let figure =
        |at: &str, text: &dyn Fn(f64) -> String| number(at).map_or_else(|| "-".into(), text);
    let whole = |x: f64| count(x as u64);
    let mut cells = row.values.clone();
    cells.extend([
        figure("/virtual_time_s", &|s| duration((s * 1e9).round() as u64)),
        figure("/speed_up", &|x| format!("{x:.2}")),
        figure("/efficiency", &|x| format!("{x:.3}")),
        figure("/blocks/fetched", &whole),
        figure("/migrated", &whole),
        figure("/messages/bytes", &|x| bytes(x as u64)),
        figure("/memory/peak", &|x| bytes(x as u64)),
    ]);
    cells.extend(LOST.map(|(_, at, _)| figure(at, &percent)));
    cells
}

/// The command as it was typed, nearly.
fn command(sweep: &args::Sweep) -> String {
    let axes =
        sweep.over.iter().map(|axis| format!("--over {}={}", axis.option, axis.values.join(",")));
    let scenes = sweep.scene.scenes.iter().map(|s| s.display().to_string());
    let options = sweep.typed.iter().take_while(|word| *word != "--");
    let options = options.map(|word| word.to_string_lossy().into_owned());
    let each = sweep.each.then(|| "--each".to_owned());
    let words: Vec<_> = scenes.chain(each).chain(axes).chain(options).collect();
    format!("kiloray sweep {}", words.join(" "))
}
