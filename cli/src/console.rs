//! The standard output, and numbers for people.

use std::{
    fmt::Arguments,
    io::{self, Write},
};

use crate::failure::{Failure, Outcome};

/// Prints a line to the standard output.
pub(crate) fn line(text: Arguments<'_>) -> Outcome {
    lines(format_args!("{}", harmless(&text.to_string())))
}

/// Text in which no control character reaches a terminal: names are what others wrote.
pub(crate) fn harmless(text: &str) -> String {
    text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect()
}

/// Prints lines that are our own.
pub(crate) fn lines(text: Arguments<'_>) -> Outcome {
    let mut out = io::stdout().lock();
    writeln!(out, "{text}")
        .and_then(|()| out.flush())
        .map_err(|error| Failure::io("standard output".as_ref(), &error))
}

/// How many of something: its word for one, and for more.
pub(crate) fn counted(n: u64, [one, more]: [&str; 2]) -> String {
    format!("{} {}", count(n), if n == 1 { one } else { more })
}

/// A count in at most five figures: 950, 12.3 k, 4.56 M.
pub(crate) fn count(n: u64) -> String {
    match n {
        0..10_000 => n.to_string(),
        10_000..1_000_000 => format!("{:.1} k", n as f64 / 1e3),
        1_000_000..1_000_000_000 => format!("{:.2} M", n as f64 / 1e6),
        _ => format!("{:.2} G", n as f64 / 1e9),
    }
}

/// Bytes in binary units, in three figures or more.
pub(crate) fn bytes(n: u64) -> String {
    if n < 1 << 10 {
        return format!("{n} B");
    }
    let of = |bits: u32| n as f64 / (1_u64 << bits) as f64;
    // What would be written as 1024.0 of a unit is 1 of the next.
    let (bits, unit) = [(10, "KiB"), (20, "MiB")]
        .into_iter()
        .find(|&(bits, _)| of(bits) < 1023.95)
        .unwrap_or((30, "GiB"));
    let value = of(bits);
    let decimals = if value < 9.995 { 2 } else { 1 };
    format!("{value:.decimals$} {unit}")
}

/// Bytes per second in decimal units, as links are sold by.
pub(crate) fn rate(n: u64) -> String {
    let (value, unit) = match n {
        0..1_000 => return format!("{n} B/s"),
        1_000..1_000_000 => (n as f64 / 1e3, "kB/s"),
        1_000_000..1_000_000_000 => (n as f64 / 1e6, "MB/s"),
        _ => (n as f64 / 1e9, "GB/s"),
    };
    // No more figures than it has: 1 GB/s, 12.5 MB/s.
    format!("{} {unit}", (value * 100.0).round() / 100.0)
}

/// A length of time in nanoseconds, in three figures.
pub(crate) fn duration(ns: u64) -> String {
    let (value, unit) = match ns {
        0..1_000 => return format!("{ns} ns"),
        1_000..1_000_000 => (ns as f64 / 1e3, "µs"),
        1_000_000..1_000_000_000 => (ns as f64 / 1e6, "ms"),
        _ => (ns as f64 / 1e9, "s"),
    };
    let decimals = usize::from(value < 100.0) + usize::from(value < 10.0);
    format!("{value:.decimals$} {unit}")
}

/// A part of a whole, as a percentage.
pub(crate) fn percent(part: f64) -> String {
    format!("{:.1} %", 100.0 * part)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_is_not_many() {
        let boards = [0, 1, 2].map(|n| counted(n, ["board", "boards"]));
        assert_eq!(boards, ["0 boards", "1 board", "2 boards"]);
    }

    #[test]
    fn numbers_are_short() {
        let rates = [999, 1_000, 2_500_000, 125_000_000, 1_000_000_000, 10_125_000_000].map(rate);
        assert_eq!(rates, ["999 B/s", "1 kB/s", "2.5 MB/s", "125 MB/s", "1 GB/s", "10.13 GB/s"]);
        let all = [0, 9_999, 12_345, 1_000_000, 2_345_678_901].map(count);
        assert_eq!(all, ["0", "9999", "12.3 k", "1.00 M", "2.35 G"]);
        assert_eq!(
            [999, 1_500, 12_345_678, 123_456_789, 61_000_000_000].map(duration),
            ["999 ns", "1.50 µs", "12.3 ms", "123 ms", "61.0 s"]
        );
        assert_eq!([1, 65_536, 20_971_520].map(bytes), ["1 B", "64.0 KiB", "20.0 MiB"]);
    }

    #[test]
    fn no_size_is_1024_of_a_unit() {
        for (n, text) in [
            (1_023, "1023 B"),
            (1 << 10, "1.00 KiB"),
            (1_500, "1.46 KiB"),
            (10_234, "9.99 KiB"),
            (10_235, "10.0 KiB"),
            (1_048_524, "1023.9 KiB"),
            (1_048_525, "1.00 MiB"),
            (1 << 20, "1.00 MiB"),
            ((1 << 30) - 1, "1.00 GiB"),
            (1 << 30, "1.00 GiB"),
            (48 << 30, "48.0 GiB"),
        ] {
            assert_eq!(bytes(n), text, "{n}");
        }
    }
}
