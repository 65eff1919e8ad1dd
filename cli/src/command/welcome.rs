use clap::Parser;

use super::sim;
use crate::{
    args::{Arguments, Command},
    console::line,
    failure::{Failure, Outcome},
};

/// What `kiloray` alone does.
const DEFAULT: [&str; 11] = [
    "kiloray",
    "sim",
    "glass",
    "--topology=mesh:8x8",
    "--memory=256KiB",
    "--width=300",
    "--samples=4",
    "-o",
    "kiloray.png",
    "--report",
    "kiloray-report",
];

/// Renders the built-in scene, and says what to do next.
pub(super) fn run() -> Outcome {
    let Ok(Arguments { command: Some(Command::Sim(arguments)) }) =
        Arguments::try_parse_from(DEFAULT)
    else {
        return Err(Failure::new("the default command is not understood"));
    };
    line(format_args!("kiloray: {}", DEFAULT[1..].join(" ")))?;
    sim::run(&arguments)?;
    line(format_args!("Next: 'kiloray scenes' lists the scenes, 'kiloray --help' says more."))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_default_command_is_understood() {
        let arguments = Arguments::try_parse_from(DEFAULT).expect("it parses");
        let Some(Command::Sim(sim)) = arguments.command else { panic!("it is not sim") };
        assert!(sim.output.is_some() && sim.common.report.is_some());
        let scene = sim.scene.scenes[0].to_str().expect("a name");
        assert!(kiloray_scene::builtin::find(scene).is_ok());
        assert_eq!(sim.mesh.division.topology().map(|t| t.nodes()), Ok(64));
    }
}
