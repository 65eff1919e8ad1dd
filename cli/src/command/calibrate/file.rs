//! A profile as a file: JSON, an operation and its nanoseconds on each line.

use std::{fs, path::Path};

use kiloray_sim::Profile;

use crate::{
    failure::{Failure, Outcome},
    output::Output,
};

/// What the profile in a file is called.
pub(super) fn name(path: &Path) -> String {
    path.file_stem().map_or_else(|| "machine".into(), |stem| stem.to_string_lossy().into_owned())
}

/// Writes a profile.
pub(super) fn write(profile: &Profile, output: Output) -> Outcome {
    let json = serde_json::to_string_pretty(profile).map_err(Failure::new)?;
    output.write(format!("{json}\n").as_bytes())
}

/// Reads a profile.
pub(in crate::command) fn read(path: &Path) -> Outcome<Profile> {
    let text = fs::read(path).map_err(|error| Failure::io(path, &error))?;
    serde_json::from_slice(&text).map_err(|error| {
        let cause = format!("{error}; it is no profile: write one with 'kiloray calibrate'");
        Failure::file(path, cause)
    })
}
