use std::{ffi::OsString, str::FromStr};

use clap::{ArgMatches, CommandFactory, parser::ValueSource};
use serde::Serialize;

use super::{Arguments, Command, Sim, parse::parse};
use crate::failure::{Failure, Outcome};

/// Most values of an axis.
const VALUES_MAX: usize = 1000;
/// What a point of a sweep has not: they belong to the whole.
const OF_THE_WHOLE: [&str; 7] = ["over", "each", "output", "json", "report", "trace", "quiet"];

/// An option that a sweep varies.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub(crate) struct Axis {
    /// The option's long name, without dashes.
    pub(crate) option: String,
    /// Its values, in their order.
    pub(crate) values: Vec<String>,
}

impl FromStr for Axis {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (option, list) = text
            .split_once('=')
            .ok_or("write an option and its values, as in memory=64KiB,128KiB or nodes=1..256")?;
        let option = option.trim_start_matches('-').to_owned();
        let names = axes();
        if !names.contains(&option) {
            return Err(format!(
                "'{option}' is no option to vary; there are: {}",
                names.join(", ")
            ));
        }
        let mut values: Vec<String> = Vec::new();
        for item in list.split(',') {
            match item.split_once("..") {
                _ if item.is_empty() => return Err(format!("an empty value in '{text}'")),
                Some((first, last)) => values.extend(doubling(first, last)?),
                None => values.push(item.to_owned()),
            }
        }
        if values.len() > VALUES_MAX {
            return Err(format!("an axis has at most {VALUES_MAX} values"));
        }
        if let Some(twice) = values.iter().enumerate().find(|(i, v)| values[..*i].contains(v)) {
            return Err(format!("'{}' twice on the axis '{option}'", twice.1));
        }
        Ok(Self { option, values })
    }
}

/// What is varied where nothing is said: speed-up, and what efficiency depends on. Blocks have one size with all of these memories.
pub(super) fn usual() -> Vec<Axis> {
    let axes = [
        "nodes=1..256",
        "memory=32KiB..256KiB",
        "prefetch=0,1,4,16,all",
        "link-bandwidth=10MB/s,30MB/s,100MB/s,300MB/s,1GB/s,3GB/s,10GB/s",
    ];
    axes.iter().filter_map(|axis| axis.parse().ok()).collect()
}

/// `1..256`, `16KiB..1MiB`, `100MB/s..2GB/s`: doubled until the last, which is one of them.
fn doubling(first: &str, last: &str) -> Result<Vec<String>, String> {
    let wrong = || {
        format!(
            "'{first}..{last}' is no range; write two whole numbers, as in 1..256 or 16KiB..256KiB"
        )
    };
    let split = |text: &str| {
        let digits = text.bytes().take_while(u8::is_ascii_digit).count();
        let (number, unit) = text.split_at(digits);
        number.parse::<u64>().ok().map(|n| (n, unit.to_owned())).ok_or_else(wrong)
    };
    let ((first_n, first_unit), (last_n, last_unit)) = (split(first)?, split(last)?);
    // 16..256KiB: the unit of both.
    let first_unit = if first_unit.is_empty() { last_unit.clone() } else { first_unit };
    let (start, end) = (first_n as f64 * scale(&first_unit)?, last_n as f64 * scale(&last_unit)?);
    if start <= 0.0 || start > end {
        return Err(format!("'{first}..{last}': a range doubles, from above 0 upwards"));
    }
    let steps = (end / start).log2().floor() as u32;
    let mut values: Vec<_> = (0..=steps.min(VALUES_MAX as u32))
        .map(|k| (start * f64::from(k).exp2(), format!("{}{first_unit}", first_n << k.min(40))))
        .collect();
    if values.last().is_some_and(|(value, _)| *value < end) {
        values.push((end, format!("{last_n}{last_unit}")));
    }
    Ok(values.into_iter().map(|(_, text)| text).collect())
}

/// How much a unit is of the first one of its kind.
pub(crate) fn scale(unit: &str) -> Result<f64, String> {
    let size = unit.strip_suffix("/s").unwrap_or(unit);
    Ok(match size {
        "" | "B" | "ns" => 1.0,
        "kbit" => 125.0,
        "Mbit" => 125e3,
        "Gbit" => 125e6,
        "KiB" => 1024.0,
        "MiB" => 1_048_576.0,
        "GiB" => 1_073_741_824.0,
        "kB" | "KB" | "us" | "µs" => 1e3,
        "MB" | "ms" => 1e6,
        "GB" | "s" => 1e9,
        _ => return Err(format!("'{unit}' is no unit")),
    })
}

/// Options of `sim` that an axis can be.
pub(crate) fn axes() -> Vec<String> {
    let command = Arguments::command();
    let Some(sim) = command.find_subcommand("sim") else { return Vec::new() };
    sim.get_arguments()
        .filter(|arg| !OF_THE_WHOLE.contains(&arg.get_id().as_str()))
        .filter(|arg| arg.get_action().takes_values())
        .filter_map(|arg| arg.get_long().map(str::to_owned))
        .collect()
}

/// What was typed of the options that each point of a sweep has, as words.
pub(super) fn typed(matches: &ArgMatches) -> Vec<OsString> {
    let command = Arguments::command();
    let Some(sim) = command.find_subcommand("sim") else { return Vec::new() };
    let mut words = Vec::new();
    for arg in sim.get_arguments() {
        let id = arg.get_id().as_str();
        let Some(long) = arg.get_long().filter(|_| !OF_THE_WHOLE.contains(&id)) else { continue };
        if matches.value_source(id) != Some(ValueSource::CommandLine) {
            continue;
        }
        if !arg.get_action().takes_values() {
            words.push(format!("--{long}").into());
            continue;
        }
        for value in matches.get_raw(id).into_iter().flatten() {
            // One word: a value may begin with a dash.
            let mut word = OsString::from(format!("--{long}="));
            word.push(value);
            words.push(word);
        }
    }
    words.push("--".into());
    words.extend(matches.get_raw("scenes").into_iter().flatten().map(OsString::from));
    words
}

/// The `sim` command of a point: what was typed, and a value for each axis.
pub(crate) fn point(typed: &[OsString], values: &[(&str, &str)]) -> Outcome<Sim> {
    let command = ["kiloray", "sim"].map(OsString::from);
    let axes = values.iter().map(|(option, value)| OsString::from(format!("--{option}={value}")));
    // The axes first would lose against what is typed: the last one given wins.
    let end = typed.iter().position(|word| word == "--").unwrap_or(typed.len());
    let (options, scenes) = typed.split_at(end);
    let words = command.into_iter().chain(options.iter().cloned()).chain(axes);
    match parse(words.chain(scenes.iter().cloned()))?.command {
        Some(Command::Sim(sim)) => Ok(*sim),
        _ => Err(Failure::new("a point is no simulation")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn values(text: &str) -> Result<Vec<String>, String> {
        text.parse::<Axis>().map(|axis| axis.values)
    }

    #[test]
    fn axes_are_lists_and_doubling_ranges() {
        let of = |text| values(text).unwrap().join(" ");
        assert_eq!(of("memory=64KiB,128KiB"), "64KiB 128KiB");
        assert_eq!(of("nodes=1..16"), "1 2 4 8 16");
        assert_eq!(of("nodes=1..12"), "1 2 4 8 12");
        assert_eq!(of("--nodes=3,8..32,5"), "3 8 16 32 5");
        assert_eq!(of("memory=16..64KiB"), "16KiB 32KiB 64KiB");
        assert_eq!(of("memory=512KiB..2MiB"), "512KiB 1024KiB 2048KiB");
        assert_eq!(of("link-bandwidth=500MB/s..2GB/s"), "500MB/s 1000MB/s 2000MB/s");
        assert_eq!(of("link-bandwidth=1Mbit/s..1MB/s"), "1Mbit/s 2Mbit/s 4Mbit/s 8Mbit/s");
        assert_eq!(of("link-latency=1µs..4µs"), "1µs 2µs 4µs");
        assert_eq!(of("schedule=hybrid,demand,data"), "hybrid demand data");
    }

    #[test]
    fn the_usual_axes_are_axes() {
        let axes: Vec<_> = usual().iter().map(|a| (a.option.clone(), a.values.len())).collect();
        let expected = [("nodes", 9), ("memory", 4), ("prefetch", 5), ("link-bandwidth", 7)];
        assert_eq!(axes, expected.map(|(option, values)| (option.to_owned(), values)));
    }

    #[test]
    fn senseless_axes_are_refused() {
        for text in [
            "nodes",
            "nodes=",
            "nodes=1,,2",
            "nodes=0..4",
            "nodes=8..4",
            "nodes=a..b",
            "over=1",
            "output=a",
            "banana=1",
            "nodes=1,1",
            "memory=1KiB..1parsec",
            "quiet=1",
        ] {
            assert!(values(text).is_err(), "{text}");
        }
    }
}
