//! Sizes in bytes, as typed.

/// A number and its unit: `65536`, `64KiB`, `1MB`.
pub(crate) fn parse_bytes(text: &str) -> Result<u64, String> {
    let digits = text.bytes().take_while(u8::is_ascii_digit).count();
    let (number, unit) = text.split_at(digits);
    let number: u64 = number.parse().map_err(|_| {
        format!("'{text}' is no size; write a whole number and a unit, as in 64KiB")
    })?;
    let unit: u64 = match unit {
        "" | "B" => 1,
        "KiB" => 1 << 10,
        "MiB" => 1 << 20,
        "GiB" => 1 << 30,
        "kB" | "KB" => 1_000,
        "MB" => 1_000_000,
        "GB" => 1_000_000_000,
        _ => {
            return Err(format!("'{unit}' is no unit of size; use B, KiB, MiB, GiB, kB, MB or GB"));
        }
    };
    number.checked_mul(unit).ok_or_else(|| format!("{text} is more than can be addressed"))
}

/// A size as it can be typed, to the byte: in the greatest unit of which it is a whole number.
pub(crate) fn typed(bytes: u64) -> String {
    let units = [(30, "GiB"), (20, "MiB"), (10, "KiB")];
    let fits = |&(bits, _): &(u32, &str)| bytes > 0 && bytes.trailing_zeros() >= bits;
    match units.into_iter().find(fits) {
        Some((bits, unit)) => format!("{}{unit}", bytes >> bits),
        None => format!("{bytes}B"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_written_as_they_are_typed() {
        for text in ["0B", "1023B", "1KiB", "1025B", "20KiB", "3MiB", "1025KiB", "1GiB"] {
            assert_eq!(parse_bytes(text).map(typed).as_deref(), Ok(text));
        }
    }

    #[test]
    fn sizes_are_strict() {
        for (text, bytes) in [
            ("0", 0),
            ("512", 512),
            ("64KiB", 65_536),
            ("64kB", 64_000),
            ("3MiB", 3_145_728),
            ("1GiB", 1_073_741_824),
        ] {
            assert_eq!(parse_bytes(text), Ok(bytes));
        }
        for text in [
            "",
            "banana",
            "KiB",
            "64 KiB",
            "64kib",
            "-1",
            "+1",
            "1.5MiB",
            "64KiBs",
            "1e3",
            "99999999999GiB",
        ] {
            assert!(parse_bytes(text).is_err(), "{text}");
        }
    }
}
