use std::path::Path;

use clap::{Command, ValueHint, builder::PossibleValuesParser};

use crate::{args, failure::Outcome, output::Output};

/// What can be written for options that take more than a list of words: those words.
const WORDS: [(&str, &[&str]); 2] = [
    ("topology", &["line", "ring", "mesh", "torus", "hypercube", "tree", "full"]),
    ("profile", &["pc", "t800", "rp2350", "stm32f4"]),
];

/// Prints the script.
pub(super) fn run(arguments: &args::Completions) -> Outcome {
    let mut script = Vec::new();
    clap_complete::generate(arguments.shell, &mut command(), "kiloray", &mut script);
    Output::create(Path::new("-"))?.write(&script)
}

/// The grammar as it is to be offered: without hidden commands and options, with words where there are some, and with files for nothing but files.
fn command() -> Command {
    let all = args::command();
    let shown = |command: &Command| !command.is_hide_set();
    let commands: Vec<_> =
        all.get_subcommands().filter(|command| shown(command)).map(offered).collect();
    // A subcommand cannot be taken away.
    Command::new("kiloray").version(env!("CARGO_PKG_VERSION")).subcommands(commands)
}

fn offered(command: &Command) -> Command {
    // Scripts for bash offer hidden options too, and an option cannot be taken away.
    let shown = command.get_arguments().filter(|arg| !arg.is_hide_set()).cloned();
    let offered = Command::new(command.get_name().to_owned()).args(shown);
    let about = command.get_about().cloned().unwrap_or_default();
    offered.about(about).mut_args(|arg| {
        let words = WORDS.iter().find(|(name, _)| arg.get_id() == name);
        if let Some((_, words)) = words {
            // In bash both words and files would be neither.
            let arg = arg.value_hint(ValueHint::Unknown);
            return arg.value_parser(PossibleValuesParser::new(*words));
        }
        let is_open = arg.get_action().takes_values() && arg.get_possible_values().is_empty();
        if is_open && arg.get_value_hint() == ValueHint::Unknown {
            return arg.value_hint(ValueHint::Other);
        }
        arg
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use kiloray_core::network::Topology;
    use kiloray_sim::Profile;

    #[test]
    fn the_words_are_those_that_can_be_typed() {
        let [(_, topologies), (_, profiles)] = WORDS;
        assert!(topologies.iter().all(|name| Topology::parse(name, 16).is_ok()));
        assert_eq!(profiles, Profile::ALL.map(|profile| profile.name));
    }
}
