use std::ffi::OsString;

use clap::{CommandFactory, FromArgMatches, error::ErrorKind};

use super::{Arguments, Command, axis, mesh};
use crate::{
    console,
    failure::{Failure, Outcome},
};

/// The grammar, for completions.
pub(crate) fn command() -> clap::Command {
    Arguments::command()
}

/// Reads the command line.
pub(crate) fn parse(arguments: impl Iterator<Item = OsString>) -> Outcome<Arguments> {
    let arguments: Vec<_> = arguments.collect();
    read(&arguments).map_err(|error| match error.kind() {
        ErrorKind::DisplayHelp | ErrorKind::DisplayVersion => {
            let text = error.render();
            let text = text.to_string();
            console::lines(format_args!("{}", text.trim_end())).err().unwrap_or(Failure::Printed)
        }
        _ => Failure::Usage(one_line(&error.render().to_string(), arguments.get(1))),
    })
}

fn read(arguments: &[OsString]) -> Result<Arguments, clap::Error> {
    let matches = command().try_get_matches_from(arguments)?;
    let mut read = Arguments::from_arg_matches(&matches)?;
    match (&mut read.command, matches.subcommand()) {
        (Some(Command::Sweep(sweep)), Some((_, matches))) => {
            sweep.typed = axis::typed(matches);
            if sweep.over.is_empty() {
                (sweep.over, sweep.each) = (axis::usual(), true);
            }
        }
        (Some(Command::Plan(plan)), Some((_, matches))) => {
            plan.is_mesh = mesh::is_typed(matches);
        }
        _ => {}
    }
    Ok(read)
}

/// The cause and its hints, without the usage, in one line.
fn one_line(text: &str, command: Option<&OsString>) -> String {
    let text = text.strip_prefix("error: ").unwrap_or(text);
    let words: Vec<_> = text
        .lines()
        .map(str::trim)
        .take_while(|line| !line.starts_with("Usage:") && !line.starts_with("For more"))
        // An option that there is not is no value either.
        .filter(|line| !line.is_empty() && !line.starts_with("tip: to pass '-"))
        .collect();
    // What follows a colon belongs to it.
    let words = words.join("; ").replace(":; ", ": ");
    let known = |name: &&str| command_exists(name);
    let of = command.and_then(|c| c.to_str()).filter(known).map(|c| format!(" {c}"));
    format!("{} (see 'kiloray{} --help')", words, of.unwrap_or_default())
}

fn command_exists(name: &str) -> bool {
    command().find_subcommand(name).is_some()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parsed(line: &str) -> Outcome<Arguments> {
        parse(line.split(' ').map(OsString::from))
    }

    #[test]
    fn the_grammar_is_sound() {
        command().debug_assert();
    }

    #[test]
    fn the_last_one_given_wins() {
        let line = "kiloray render cornell --samples 4 --width 9 --quiet -o a.png --samples 5 --quiet --memory 1MiB --memory 64KiB -o b.png";
        let Some(super::super::Command::Render(render)) = parsed(line).unwrap().command else {
            panic!("not read as render");
        };
        assert_eq!((render.common.samples, render.common.width), (5, Some(9)));
        assert_eq!(render.common.memory, Some(65_536));
        assert_eq!(render.output.unwrap().to_str(), Some("b.png"));
        assert_eq!(render.scene.scenes.len(), 1);
    }

    #[test]
    fn scenes_are_collected_not_replaced() {
        let Some(super::super::Command::Render(render)) =
            parsed("kiloray render a.rad b.rad --seed 1 c.vf").unwrap().command
        else {
            panic!("not read as render");
        };
        assert_eq!(render.scene.scenes.len(), 3);
    }

    #[test]
    fn errors_are_one_line_that_says_what_to_do() {
        for (line, part) in [
            ("kiloray render", "SCENE"),
            ("kiloray render cornell --samples -1", "from 1 to"),
            ("kiloray render cornell --width 0", "from 1 to 65536"),
            ("kiloray render cornell --memory banana", "64KiB"),
            ("kiloray render cornell --sample 3", "--samples"),
            ("kiloray rendr cornell", "render"),
            ("kiloray render cornell --foo", "'--foo' found (see"),
            ("kiloray board cornell --serial a --baud 0", "from 300 to 4000000"),
            ("kiloray sim cornell --bundle 20s", "write a time from 0 to 10s"),
        ] {
            let Err(Failure::Usage(message)) = parsed(line) else { panic!("{line} is accepted") };
            assert!(!message.contains('\n') && message.contains(part), "{line}: {message}");
            assert!(message.contains("--help") && !message.contains(":;"), "{line}: {message}");
        }
    }
}
