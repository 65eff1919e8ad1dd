//! Times, rates and parts of a whole, as typed.

use std::fmt;

use serde::Serialize;

/// A number that may have a point, and its unit: `1.5ms`.
fn split(text: &str) -> (&str, &str) {
    let number = text.bytes().take_while(|b| b.is_ascii_digit() || *b == b'.').count();
    text.split_at(number)
}

/// `number` of a unit of `unit` steps, to the nearest step.
fn scaled(number: &str, unit: f64, what: &str) -> Result<u64, String> {
    let value = decimal(number).ok_or_else(|| what.to_owned())? * unit;
    if value < 9e18 { Ok(value.round() as u64) } else { Err(format!("{number} is too much")) }
}

/// A number in plain digits.
fn decimal(text: &str) -> Option<f64> {
    let is_plain = text.bytes().all(|b| b.is_ascii_digit() || b == b'.');
    text.parse().ok().filter(|_| is_plain && text.starts_with(|c: char| c.is_ascii_digit()))
}

/// A length of time in nanoseconds: `250ns`, `1us`, `1.5ms`, `2s`.
pub(crate) fn parse_time(text: &str) -> Result<u64, String> {
    let (number, unit) = split(text);
    let unit = match unit {
        "ns" => 1.0,
        "us" | "µs" => 1e3,
        "ms" => 1e6,
        "s" => 1e9,
        "" if text == "0" => 1.0,
        _ => {
            return Err(format!(
                "'{text}' is no time; write a number and ns, us, ms or s, as in 1us"
            ));
        }
    };
    scaled(number, unit, &format!("'{text}' is no time; write it as in 1us or 2.5ms"))
}

/// Longest that a link or a wait for it can take: virtual time ends after two years, and nodes wait many times as long for an answer.
const LINK_TIME_MAX: u64 = 10_000_000_000;

/// A time that a packet spends on a link, or waits for it.
pub(crate) fn parse_link_time(text: &str) -> Result<u64, String> {
    let time = parse_time(text)?;
    if time <= LINK_TIME_MAX { Ok(time) } else { Err("write a time from 0 to 10s".into()) }
}

/// Bytes per second: `1GB/s`, `125MB/s`, `20Mbit/s`.
pub(crate) fn parse_rate(text: &str) -> Result<u64, String> {
    let (number, unit) = split(text);
    let unit = match unit {
        "B/s" => 1.0,
        "kB/s" | "KB/s" => 1e3,
        "MB/s" => 1e6,
        "GB/s" => 1e9,
        "KiB/s" => 1024.0,
        "MiB/s" => 1_048_576.0,
        "GiB/s" => 1_073_741_824.0,
        "kbit/s" => 1e3 / 8.0,
        "Mbit/s" => 1e6 / 8.0,
        "Gbit/s" => 1e9 / 8.0,
        _ => {
            return Err(format!(
                "'{text}' is no bandwidth; write a number and kB/s, MB/s, GB/s or Mbit/s, as in 1GB/s"
            ));
        }
    };
    let wrong = format!("'{text}' is no bandwidth; write it as in 1GB/s");
    match scaled(number, unit, &wrong)? {
        0 => Err("a link has a bandwidth of at least 1B/s".into()),
        rate => Ok(rate),
    }
}

/// A part of a whole: a ratio of integers, so that chance is the same on every machine.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
#[serde(into = "f64")]
pub(crate) struct Part {
    pub(crate) numerator: u32,
    pub(crate) denominator: u32,
}

impl From<Part> for f64 {
    fn from(part: Part) -> Self {
        Self::from(part.numerator) / Self::from(part.denominator.max(1))
    }
}

impl fmt::Display for Part {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.numerator, self.denominator)
    }
}

/// Decimals of a part that is written with a point.
const DECIMALS: f64 = 1e9;

/// `1/1000`, `0.01`, `1%`.
pub(crate) fn parse_part(text: &str) -> Result<Part, String> {
    let wrong = || format!("'{text}' is no part; write it as in 1/1000, 0.001 or 0.1%");
    let part = if let Some((a, b)) = text.split_once('/') {
        let whole = |text: &str| {
            text.parse().ok().filter(|_| text.bytes().all(|b| b.is_ascii_digit())).ok_or_else(wrong)
        };
        Part { numerator: whole(a)?, denominator: whole(b)? }
    } else {
        let (number, unit) = match text.strip_suffix('%') {
            Some(number) => (number, 100.0),
            None => (text, 1.0),
        };
        let value = decimal(number).ok_or_else(wrong)? / unit;
        // More than 1 is refused below.
        let numerator = (value.min(2.0) * DECIMALS).round() as u32;
        Part { numerator, denominator: DECIMALS as u32 }
    };
    if part.denominator == 0 || part.numerator > part.denominator {
        return Err(format!("'{text}' is not between 0 and 1"));
    }
    Ok(part)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_have_units() {
        for (text, ns) in
            [("250ns", 250), ("1us", 1_000), ("1.5ms", 1_500_000), ("2s", 2_000_000_000), ("0", 0)]
        {
            assert_eq!(parse_time(text), Ok(ns), "{text}");
        }
        for text in [
            "",
            "1",
            "us",
            "-1us",
            "1 us",
            "1e3ns",
            "1.2.3s",
            "inf",
            "1min",
            ".5us",
            "99999999999s",
        ] {
            assert!(parse_time(text).is_err(), "{text}");
        }
    }

    #[test]
    fn links_take_seconds_at_most() {
        assert_eq!(parse_link_time("10s"), Ok(10_000_000_000));
        for text in ["10.1s", "1000000s", "-1s"] {
            assert!(parse_link_time(text).is_err(), "{text}");
        }
    }

    #[test]
    fn rates_have_units() {
        for (text, rate) in [
            ("1GB/s", 1_000_000_000),
            ("9.6kB/s", 9_600),
            ("20Mbit/s", 2_500_000),
            ("1MiB/s", 1_048_576),
            ("1B/s", 1),
        ] {
            assert_eq!(parse_rate(text), Ok(rate), "{text}");
        }
        for text in ["", "1GB", "0B/s", "fast", "-1GB/s", "1GBs", "1Gb/s", "999999999999GB/s"] {
            assert!(parse_rate(text).is_err(), "{text}");
        }
    }

    #[test]
    fn parts_are_written_in_three_ways() {
        for (text, part) in
            [("1/1000", 0.001), ("0.01", 0.01), ("1%", 0.01), ("0", 0.0), ("1", 1.0)]
        {
            assert_eq!(parse_part(text).map(f64::from), Ok(part), "{text}");
        }
        for text in ["", "2", "3/2", "1/0", "-1", "1/-2", "150%", "1/2/3", "NaN", "+1/2", "1 %"] {
            assert!(parse_part(text).is_err(), "{text}");
        }
    }
}
