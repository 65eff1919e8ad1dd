use kiloray_scene::builtin::{self, Entry};
use serde_json::json;

use crate::{
    args,
    console::{count, line, lines},
    failure::Outcome,
};

/// Prints the built-in scenes.
pub(super) fn run(arguments: &args::Scenes) -> Outcome {
    if arguments.json {
        let all: Vec<_> = builtin::list().iter().map(as_json).collect();
        return lines(format_args!("{:#}", json!(all)));
    }
    line(format_args!(
        "{:<14} {:>14} {:>10} {:>10}  shows",
        "scene", "N", "default N", "surfaces"
    ))?;
    for entry in builtin::list() {
        let (range, default) = entry.size.map_or_else(
            || (String::new(), String::new()),
            |size| (format!("{}..{}", size.min, size.max), size.default.to_string()),
        );
        line(format_args!(
            "{:<14} {range:>14} {default:>10} {:>10}  {}",
            entry.usage(),
            count(entry.surfaces(entry.size.map_or(0, |s| s.default))),
            entry.about,
        ))?;
        if let Some(size) = entry.size {
            line(format_args!(
                "{:<51}  N: {}; N = {} has {}",
                "",
                size.counts,
                size.max,
                count(entry.surfaces(size.max))
            ))?;
        }
    }
    lines(format_args!("\nA name without ':N' takes the default N: 'kiloray render sinc'"))
}

fn as_json(entry: &Entry) -> serde_json::Value {
    let sizes = entry.size.map(|size| {
        json!({
            "counts": size.counts,
            "default": size.default,
            "min": size.min,
            "max": size.max,
            "surfaces_max": entry.surfaces(size.max),
        })
    });
    json!({
        "name": entry.name,
        "about": entry.about,
        "surfaces": entry.surfaces(entry.size.map_or(0, |s| s.default)),
        "size": sizes,
    })
}
