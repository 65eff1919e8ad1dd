//! A profile as a file: JSON, an operation and its nanoseconds on each line.

use std::path::Path;

use kiloray_sim::Profile;

use crate::{
    failure::{Failure, Outcome},
    input,
    output::Output,
};

/// Greatest file: profiles have about one KiB.
const BYTES_MAX: u64 = 1 << 20;

/// What the profile in a file is called; the name has the ending by which `--profile` knows a file.
pub(super) fn name(path: &Path) -> Outcome<String> {
    if path.as_os_str() == "-" {
        return Ok("machine".into());
    }
    let stem = path.file_stem().filter(|_| path.extension().is_some_and(|e| e == "json"));
    stem.map(|stem| stem.to_string_lossy().into_owned()).ok_or_else(|| {
        Failure::usage(format_args!("-o {}: a profile is a .json file", path.display()))
    })
}

/// Writes a profile.
pub(super) fn write(profile: &Profile, output: Output) -> Outcome {
    let json = serde_json::to_string_pretty(profile).map_err(Failure::new)?;
    output.write(format!("{json}\n").as_bytes())
}

/// Reads a profile.
pub(in crate::command) fn read(path: &Path) -> Outcome<Profile> {
    let text = input::read(path, BYTES_MAX)?;
    serde_json::from_slice(&text).map_err(|error| {
        let cause = format!("{error}; it is no profile: write one with 'kiloray calibrate'");
        Failure::file(path, cause)
    })
}
