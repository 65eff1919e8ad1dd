use std::fmt::Write;

use kiloray_sim::Options;
use serde_json::{Value, json};

use super::point::{Point, heads};
use crate::{
    args,
    command::sim::{self, Done},
    console::{duration, line},
    failure::Outcome,
    scene::Scene,
};

/// What came of a point.
#[derive(Debug, Clone)]
pub(super) struct Row {
    /// A value of each axis.
    pub(super) values: Vec<String>,
    /// Why there is nothing else.
    pub(super) error: Option<String>,
    /// Nodes that were to crash, and have not.
    pub(super) spared: Option<String>,
    /// What decides about the picture.
    picture: String,
    /// All of it, as `kiloray sim --json` gives it, but for the wall clock.
    pub(super) json: Value,
}

/// Columns after the axes: their names, with units where they have one, and where they are in the JSON.
const MEASURED: [(&str, &str); 11] = [
    ("nodes", "/nodes"),
    ("topology", "/options/topology"),
    ("memory_bytes", "/memory/limit"),
    ("block_bytes", "/options/block"),
    ("profile", "/options/profile"),
    ("schedule", "/options/schedule"),
    ("placement", "/options/placement"),
    ("virtual_time_s", "/virtual_time_s"),
    ("virtual_time_one_node_s", "/virtual_time_one_node_s"),
    ("speed_up", "/speed_up"),
    ("efficiency", "/efficiency"),
];

/// What the time of the nodes went to, behind them: the same, and the head in the page.
pub(super) const LOST: [(&str, &str, &str); 13] = [
    ("lost_data", "/lost/data", "for blocks"),
    ("lost_answers", "/lost/answers", "for answers"),
    ("lost_credit", "/lost/credit", "for room"),
    ("lost_master", "/lost/master", "for the host"),
    ("lost_imbalance", "/lost/imbalance", "no work"),
    ("lost_messages", "/lost/messages", "messages"),
    ("lost_refused", "/lost/refused", "refused"),
    ("lost_checks", "/lost/checks", "checks"),
    ("lost_forwards", "/lost/forwards", "forwards"),
    ("lost_clip", "/lost/clip", "clipping"),
    ("lost_repeated", "/lost/repeated", "repeated"),
    ("lost_crashed", "/lost/crashed", "crashed"),
    ("lost_slow", "/lost/slow", "slow nodes"),
];

/// The columns behind those.
const COUNTED: [(&str, &str); 24] = [
    ("rays_primary", "/rays/primary"),
    ("rays_shadow", "/rays/shadow"),
    ("rays_specular", "/rays/specular"),
    ("messages", "/messages/count"),
    ("message_bytes", "/messages/bytes"),
    ("packets", "/links/packets"),
    ("link_bytes", "/links/bytes"),
    ("busiest_link", "/links/busiest/busy"),
    ("worst_cut_bound_s", "/links/worst_cut/bound_s"),
    ("blocks", "/blocks/count"),
    ("blocks_fetched", "/blocks/fetched"),
    ("rays_migrated", "/migrated"),
    ("cache_hits", "/cache/hits"),
    ("cache_misses", "/cache/misses"),
    ("cache_evictions", "/cache/evictions"),
    ("memory_peak_bytes", "/memory/peak"),
    ("points_peak", "/points/peak"),
    ("retries", "/retries"),
    ("refusals", "/refusals"),
    ("packets_lost", "/faults/lost"),
    ("fetch_p50_ns", "/latencies/fetch/p50"),
    ("fetch_p99_ns", "/latencies/fetch/p99"),
    ("image_hash", "/image_hash"),
    ("fingerprint", "/fingerprint"),
];

impl Row {
    /// Of a point that ended well.
    pub(super) fn done(point: &Point, scene: &Scene, options: &Options, done: &Done) -> Self {
        let run = sim::Run::new(&point.sim, scene, options, done, None);
        let mut json = run.as_json();
        // What differs from run to run has no place in a table that is the same to the byte.
        if let Some(all) = json.as_object_mut() {
            all.remove("time_s");
            all.remove("mesh_s");
        }
        let nodes = done.outcome.report.nodes.len() as f64;
        json["speed_up"] = json!(done.efficiency().map(|efficiency| efficiency * nodes));
        let picture = format!(
            "{} {} {:?} {:?}",
            options.mesh.width, options.mesh.height, options.view, options.mesh.settings
        );
        let spared = sim::spared(&done.outcome.report, options);
        Self { values: point.values.clone(), error: None, spared, picture, json }
    }

    /// Of a point that did not.
    pub(super) fn failed(point: &Point, error: &str) -> Self {
        Self {
            values: point.values.clone(),
            error: Some(error.to_owned()),
            spared: None,
            picture: String::new(),
            json: Value::Null,
        }
    }

    /// The same as a point of this axis alone, where one is varied at a time and it is this one.
    pub(super) fn of_axis(&self, option: &str) -> Option<Self> {
        let value = self.values.get(1).filter(|_| self.values[0] == option)?;
        Some(Self { values: vec![value.clone()], ..self.clone() })
    }

    /// A figure of it, by its place in the JSON.
    pub(super) fn number(&self, at: &str) -> Option<f64> {
        if at == "/virtual_time_ms" {
            return self.number("/virtual_time_s").map(|s| s * 1e3);
        }
        self.json.pointer(at)?.as_f64()
    }

    /// The point, and its JSON or its error.
    pub(super) fn as_json(&self) -> Value {
        json!({ "point": self.values, "error": self.error, "run": self.json })
    }

    /// With figures made by hand.
    #[cfg(test)]
    pub(super) fn of_json(values: &[&str], json: Value) -> Self {
        let values = values.iter().map(|v| (*v).to_owned()).collect();
        Self { values, error: None, spared: None, picture: String::new(), json }
    }

    fn name(&self) -> String {
        self.values.join(" ")
    }
}

/// All rows as comma-separated values (RFC 4180), with the axes first and errors last.
pub(super) fn csv(sweep: &args::Sweep, rows: &[Row]) -> String {
    let axes = heads(sweep);
    // An axis stands in its own column, with the values as typed.
    let lost = LOST.map(|(name, at, _)| (name, at));
    let columns = MEASURED.into_iter().chain(lost).chain(COUNTED);
    let columns: Vec<_> = columns.filter(|(name, _)| !axes.contains(name)).collect();
    let mut csv = String::new();
    let heads = axes.iter().copied().chain(columns.iter().map(|c| c.0)).chain(["error"]);
    put(&mut csv, heads);
    for row in rows {
        let figures = columns.iter().map(|(_, at)| match row.json.pointer(at) {
            None | Some(Value::Null) => String::new(),
            Some(Value::String(text)) => text.clone(),
            Some(other) => other.to_string(),
        });
        let figures: Vec<_> = figures.collect();
        let error = row.error.as_deref().unwrap_or_default();
        let all = row.values.iter().chain(&figures).map(String::as_str).chain([error]);
        put(&mut csv, all);
    }
    csv
}

fn put<'a>(csv: &mut String, fields: impl Iterator<Item = &'a str>) {
    for (i, field) in fields.enumerate() {
        if i > 0 {
            csv.push(',');
        }
        if field.contains([',', '"', '\n', '\r']) {
            // Writing to a string does not fail.
            let _ = write!(csv, "\"{}\"", field.replace('"', "\"\""));
        } else {
            csv.push_str(field);
        }
    }
    csv.push('\n');
}

/// Two points whose pictures should be the same, and are not.
pub(super) fn differing(rows: &[Row]) -> Option<(String, String)> {
    let done: Vec<_> = rows.iter().filter(|row| row.error.is_none()).collect();
    done.iter().find_map(|a| {
        let b = done
            .iter()
            .find(|b| a.picture == b.picture && a.json["image_hash"] != b.json["image_hash"])?;
        Some((a.name(), b.name()))
    })
}

/// A short table on the terminal.
pub(super) fn print(rows: &[Row]) -> Outcome {
    let width = rows.iter().map(|row| row.name().chars().count()).max().unwrap_or(0).max(5);
    line(format_args!(
        "{:<width$} {:>12} {:>9} {:>10} {:>9}",
        "point", "virtual time", "speed-up", "efficiency", "fetched"
    ))?;
    for row in rows {
        let name = row.name();
        if let Some(error) = &row.error {
            line(format_args!("{name:<width$} {error}"))?;
            continue;
        }
        let time = row.number("/virtual_time_s").unwrap_or(0.0) * 1e9;
        let figure = |at: &str, decimals: usize| {
            row.number(at).map_or_else(|| "-".into(), |x| format!("{x:.decimals$}"))
        };
        line(format_args!(
            "{name:<width$} {:>12} {:>9} {:>10} {:>9}",
            duration(time.round() as u64),
            figure("/speed_up", 2),
            figure("/efficiency", 3),
            figure("/blocks/fetched", 0)
        ))?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(values: &[&str], error: Option<&str>, hash: &str) -> Row {
        Row {
            values: values.iter().map(|v| (*v).to_owned()).collect(),
            error: error.map(str::to_owned),
            spared: None,
            picture: "the same".into(),
            json: if error.is_some() {
                Value::Null
            } else {
                json!({ "image_hash": hash, "efficiency": 0.5 })
            },
        }
    }

    #[test]
    fn pictures_that_should_be_the_same_are_compared() {
        let same = [row(&["1"], None, "a"), row(&["2"], None, "a"), row(&["3"], Some("no"), "")];
        assert_eq!(differing(&same), None);
        let other = [row(&["1"], None, "a"), row(&["2"], None, "b")];
        assert_eq!(differing(&other), Some(("1".into(), "2".into())));
    }

    #[test]
    fn fields_are_quoted_where_they_must_be() {
        let mut csv = String::new();
        put(&mut csv, ["a", "b,c", "d \"e\"", ""].into_iter());
        assert_eq!(csv, "a,\"b,c\",\"d \"\"e\"\"\",\n");
    }
}
