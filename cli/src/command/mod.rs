//! What each command does.

mod board;
mod calibrate;
mod compare;
mod compile;
mod completions;
mod division;
mod engine;
mod files;
mod frames;
#[cfg(feature = "host")]
mod host;
mod html;
mod latencies;
mod least;
mod mesh;
#[cfg(feature = "host")]
mod node;
mod plan;
mod render;
mod report;
mod scenes;
mod sim;
mod sweep;
mod welcome;

use crate::{
    args::{Arguments, Command},
    failure::Outcome,
};

/// Does what was typed.
pub(crate) fn run(arguments: Arguments) -> Outcome {
    arguments.command.as_ref().map_or(Ok(()), files::check)?;
    match arguments.command {
        None => welcome::run(),
        Some(Command::Render(render)) => render::run(&render),
        Some(Command::Sim(sim)) => sim::run(&sim),
        #[cfg(feature = "host")]
        Some(Command::Host(host)) => host::run(&host),
        #[cfg(feature = "host")]
        Some(Command::Node(node)) => node::run(&node),
        Some(Command::Sweep(sweep)) => sweep::run(&sweep),
        Some(Command::Board(board)) => board::run(&board),
        Some(Command::LineNode(node)) => board::line_node(&node),
        Some(Command::Compile(compile)) => compile::run(&compile),
        Some(Command::Plan(plan)) => plan::run(&plan),
        Some(Command::Calibrate(calibrate)) => calibrate::run(&calibrate),
        Some(Command::Compare(compare)) => compare::run(&compare),
        Some(Command::Scenes(scenes)) => scenes::run(&scenes),
        Some(Command::Completions(completions)) => completions::run(&completions),
    }
}
