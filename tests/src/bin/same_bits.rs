//! `same_bits [SCENE..] [--sample N] [--seed S] [--only CASE]`: one picture from every mesh, against the picture of one machine.
//!
//! All of 4 scenes, 3 sizes of blocks, 1 to 256 nodes, 4 topologies, 3 memories, 3 schedules and 3 faults: 6,048 runs, each of
//! which must give the same bits. What goes wrong is printed with the commands that run it alone; the exit code is then 1.

use std::ops::ControlFlow;
use std::process::ExitCode;
use std::sync::atomic::{AtomicU64, Ordering};

use clap::Parser;
use indicatif::{ProgressBar, ProgressStyle};
use kiloray_tests::pool;
use kiloray_tests::same_bits::{Matrix, SCENES};

/// One picture from every mesh, against the picture of one machine.
#[derive(Parser)]
struct Arguments {
    /// Built-in scenes, or files, as of a scanned mesh.
    #[arg(default_values_t = SCENES.map(String::from))]
    scenes: Vec<String>,
    /// So many cases of two or three runs each, drawn by the seed; without it all are run.
    #[arg(long)]
    sample: Option<usize>,
    /// Of the order of the cases.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Only the cases whose names have this in them.
    #[arg(long, value_name = "PART OF NAME")]
    only: Option<String>,
    /// As many runs at a time as there are cores, without it.
    #[arg(long)]
    threads: Option<usize>,
}

fn main() -> ExitCode {
    match check(&Arguments::parse()) {
        Ok(0) => ExitCode::SUCCESS,
        Ok(failures) => {
            eprintln!("{failures} cases failed");
            ExitCode::FAILURE
        }
        Err(message) => {
            eprintln!("error: {message}");
            ExitCode::from(2)
        }
    }
}

fn check(arguments: &Arguments) -> Result<u64, String> {
    let matrix = Matrix::new(&arguments.scenes, arguments.seed)?;
    let mut cases: Vec<_> = matrix.cases().iter().collect();
    if let Some(only) = &arguments.only {
        cases.retain(|case| matrix.name(case).contains(only));
    }
    cases.truncate(arguments.sample.unwrap_or(usize::MAX));
    let style = ProgressStyle::with_template(
        "{bar:40} {human_pos} of {human_len} cases, {elapsed} gone, {eta} left {msg}",
    );
    let bar = ProgressBar::new(cases.len() as u64)
        .with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
    let cores = || std::thread::available_parallelism().map_or(1, usize::from);
    let (runs, failures) = (AtomicU64::new(0), AtomicU64::new(0));
    pool::each(0..cases.len() as u64, arguments.threads.unwrap_or_else(cores), &|number| {
        match matrix.run(cases[number as usize]) {
            Ok(count) => {
                runs.fetch_add(count, Ordering::Relaxed);
            }
            Err(failure) => {
                let count = failures.fetch_add(1, Ordering::Relaxed) + 1;
                bar.set_message(format!("({count} failed)"));
                bar.suspend(|| eprintln!("{failure}"));
            }
        }
        bar.inc(1);
        // Where no bar is drawn, a line now and then tells how far it is.
        if bar.is_hidden() && bar.position().is_multiple_of(100) {
            let (done, all) = (bar.position(), bar.length().unwrap_or_default());
            eprintln!("{done} of {all} cases, {} s gone", bar.elapsed().as_secs());
        }
        ControlFlow::Continue(())
    });
    bar.finish_and_clear();
    let runs = runs.into_inner();
    println!("{runs} runs with the bits of one machine, in {} s", bar.elapsed().as_secs());
    Ok(failures.into_inner())
}
