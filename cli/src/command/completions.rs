use std::path::Path;

use crate::{args, failure::Outcome, output::Output};

/// Prints the script.
pub(super) fn run(arguments: &args::Completions) -> Outcome {
    let mut script = Vec::new();
    clap_complete::generate(arguments.shell, &mut args::command(), "kiloray", &mut script);
    Output::create(Path::new("-"))?.write(&script)
}
