use std::{ffi::OsString, fmt, str::FromStr};

use clap::{ArgMatches, CommandFactory, parser::ValueSource};
use serde::Serialize;

use super::{Arguments, Command, Sim, parse::parse};
use crate::failure::{Failure, Outcome};

/// Most values of an axis.
const VALUES_MAX: usize = 1000;
/// What a point of a sweep has not: they belong to the whole.
const OF_THE_WHOLE: [&str; 7] = ["over", "each", "output", "json", "report", "trace", "quiet"];

/// What all points of a sweep can be given, and would not differ by: they share the threads, and write no picture.
const THE_SAME: [&str; 2] = ["threads", "exposure"];

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

/// `1..256`, `16KiB..1MiB`, `0.5MB/s..2GB/s`: doubled until the last, which is one of them.
fn doubling(first: &str, last: &str) -> Result<Vec<String>, String> {
    let wrong = || {
        format!(
            "'{first}..{last}' is no range; write two numbers, as in 1..256, 16KiB..256KiB or 0.5..8ms"
        )
    };
    let (start, end) =
        (Amount::new(first).ok_or_else(wrong)?, Amount::new(last).ok_or_else(wrong)?);
    // 16..256KiB: the unit of both.
    let start = if start.unit.is_empty() { Amount { unit: end.unit, ..start } } else { start };
    let (first_steps, last_steps) = (start.steps()?, end.steps()?);
    if first_steps == 0 || first_steps > last_steps {
        return Err(format!("'{first}..{last}': a range doubles, from above 0 upwards"));
    }
    let doublings = (last_steps / first_steps).ilog2();
    let mut values: Vec<_> = (0..=doublings)
        .map(|k| Amount { billionths: start.billionths << k, ..start }.to_string())
        .collect();
    if first_steps << doublings < last_steps {
        values.push(end.to_string());
    }
    Ok(values)
}

/// A number and its unit, exactly.
#[derive(Clone, Copy)]
struct Amount<'a> {
    /// As great as 64 bits and nine decimals make it, so that no product with a unit overflows.
    billionths: u128,
    unit: &'a str,
}

impl<'a> Amount<'a> {
    const DECIMALS: usize = 9;

    fn new(text: &'a str) -> Option<Self> {
        let end = text.bytes().take_while(|b| b.is_ascii_digit() || *b == b'.').count();
        let (number, unit) = text.split_at(end);
        let (whole, part) = number.split_once('.').unwrap_or((number, "0"));
        if part.is_empty() || part.len() > Self::DECIMALS {
            return None;
        }
        let part: u128 = format!("{part:0<width$}", width = Self::DECIMALS).parse().ok()?;
        let whole = u128::from(whole.parse::<u64>().ok()?);
        Some(Self { billionths: whole * 10_u128.pow(Self::DECIMALS as u32) + part, unit })
    }

    /// In billionths of the first unit of its kind.
    fn steps(self) -> Result<u128, String> {
        Ok(self.billionths * scale(self.unit)? as u128)
    }
}

impl fmt::Display for Amount<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let one = 10_u128.pow(Self::DECIMALS as u32);
        let (whole, part) = (self.billionths / one, self.billionths % one);
        let decimals = format!(".{part:0width$}", width = Self::DECIMALS);
        write!(f, "{whole}{}{}", decimals.trim_end_matches('0').trim_end_matches('.'), self.unit)
    }
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
        .filter(|arg| !OF_THE_WHOLE.iter().chain(&THE_SAME).any(|id| arg.get_id() == id))
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

/// The `sim` command of a point: what was typed of other options, and a value for each axis.
pub(crate) fn point(typed: &[OsString], values: &[(&str, &str)]) -> Outcome<Sim> {
    let command = ["kiloray", "sim"].map(OsString::from);
    let axes = values.iter().map(|(option, value)| OsString::from(format!("--{option}={value}")));
    let varied: Vec<_> = values.iter().map(|(option, _)| format!("--{option}=")).collect();
    // Of most options the last one given wins, some gather all.
    let is_varied = |word: &OsString| {
        varied.iter().any(|begin| word.as_encoded_bytes().starts_with(begin.as_bytes()))
    };
    let end = typed.iter().position(|word| word == "--").unwrap_or(typed.len());
    let (options, scenes) = typed.split_at(end);
    let words = command
        .into_iter()
        .chain(options.iter().filter(|word| !is_varied(word)).cloned())
        .chain(axes);
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
        assert_eq!(of("link-bandwidth=0.5MB/s..2MB/s"), "0.5MB/s 1MB/s 2MB/s");
        assert_eq!(of("link-latency=1.25us..4us"), "1.25us 2.5us 4us");
        assert_eq!(of("loss=0.001..0.006"), "0.001 0.002 0.004 0.006");
        assert_eq!(of("schedule=hybrid,demand,data"), "hybrid demand data");
    }

    #[test]
    fn ranges_reach_as_far_as_numbers_do() {
        let most = format!("seed=1..{}", u64::MAX);
        let seeds = values(&most).unwrap();
        assert_eq!(seeds.len(), 65);
        assert_eq!(seeds[63..], [(1_u64 << 63).to_string(), u64::MAX.to_string()]);
        let odd = (1_u64 << 63) - 1;
        assert_eq!(values(&format!("seed=1..{odd}")).unwrap().last(), Some(&odd.to_string()));
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
            "link-bandwidth=.5MB/s..2MB/s",
            "link-bandwidth=0.5.1MB/s..2MB/s",
            "link-bandwidth=1.MB/s..2MB/s",
            "seed=1..18446744073709551616",
            "threads=1,2",
            "exposure=0,1",
            "quiet=1",
        ] {
            assert!(values(text).is_err(), "{text}");
        }
    }
}
