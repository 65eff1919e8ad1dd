//! `kills [--runs N] [--seed S] [--run R]`: meshes of processes whose nodes are killed or frozen at random, against the picture of one machine.
//!
//! The first run that fails is printed with the command that runs it alone; the exit code is then 1.

use std::process::ExitCode;

use clap::Parser;
use indicatif::ProgressBar;
use kiloray_tests::kills::{all, node};

/// Meshes of processes whose nodes are killed or frozen at random, against the picture of one machine.
#[derive(Parser)]
struct Arguments {
    /// Runs in all.
    #[arg(long, default_value_t = 200)]
    runs: u64,
    /// Makes them again.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Only this one.
    #[arg(long)]
    run: Option<u64>,
}

fn main() -> ExitCode {
    let typed: Vec<_> = std::env::args().skip(1).collect();
    let done = node(&typed).unwrap_or_else(|| check(&Arguments::parse()));
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("error: {message}");
            ExitCode::FAILURE
        }
    }
}

fn check(arguments: &Arguments) -> Result<(), String> {
    let &Arguments { runs, seed, run: only } = arguments;
    let program = std::env::current_exe().map_err(|error| error.to_string())?;
    let numbers = only.map_or(0..runs, |number| number..number + 1);
    let bar = ProgressBar::new(numbers.end - numbers.start);
    let ended = all(&program, seed, numbers, &|| bar.inc(1));
    bar.finish_and_clear();
    let sums = ended?;
    println!(
        "{} runs, seed {seed}: {} nodes killed, {} frozen, {} replaced; all pictures have the bits of one machine, no process was left",
        sums.runs, sums.kills, sums.freezes, sums.replaced
    );
    Ok(())
}
