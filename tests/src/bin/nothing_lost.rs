//! `nothing_lost [--runs N] [--seed S] [--run R]`: random small runs on a simulated mesh, against the picture of one machine.
//!
//! Each run is drawn from the seed and its number: scene, topology, memory, schedule, placement, links and faults. The first that fails is
//! printed with the command that runs it alone; the exit code is then 1.

use std::process::ExitCode;

use clap::Parser;
use indicatif::{ProgressBar, ProgressStyle};
use kiloray_tests::nothing_lost::{Scenes, all};

/// Random small runs on a simulated mesh, against the picture of one machine.
#[derive(Parser)]
struct Arguments {
    /// Runs in all.
    #[arg(long, default_value_t = 10_000)]
    runs: u64,
    /// Makes them again.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Only this one.
    #[arg(long)]
    run: Option<u64>,
}

fn main() -> ExitCode {
    match check(&Arguments::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("error: {message}");
            ExitCode::FAILURE
        }
    }
}

fn check(arguments: &Arguments) -> Result<(), String> {
    let &Arguments { runs, seed, run: only } = arguments;
    let scenes = Scenes::new()?;
    let numbers = only.map_or(0..runs, |number| number..number + 1);
    let style =
        ProgressStyle::with_template("{bar:40} {human_pos} of {human_len} runs, {eta} left");
    let bar = ProgressBar::new(numbers.end - numbers.start)
        .with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let ended = all(&scenes, seed, numbers, threads, &|| bar.inc(1));
    bar.finish_and_clear();
    let lost = ended.map_err(|failure| failure.to_string())?;
    let count = bar.position();
    println!(
        "{count} runs, seed {seed}: {} with the bits of one machine, {lost} with the name of a block that all its holders took with them",
        count - lost
    );
    Ok(())
}
