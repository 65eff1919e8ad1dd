//! The command that a person types.
//!
//! [`args`] is what can be typed, [`command`] what is done then. Every way to fail ends in one
//! line on the standard error and an exit code ([`failure`]): 0 done, 1 failed, 2 usage.

mod args;
mod chart;
mod command;
mod compare;
mod console;
mod cores;
mod failure;
mod input;
mod interrupt;
mod memory;
mod output;
mod page;
mod picture;
mod progress;
mod scene;

use std::process::ExitCode;

fn main() -> ExitCode {
    failure::report_panics_in_one_line();
    // A panic was reported by the hook.
    let done = std::panic::catch_unwind(|| {
        interrupt::install();
        let arguments = args::parse(std::env::args_os())?;
        command::run(arguments)
    });
    match done {
        Ok(Ok(())) => ExitCode::SUCCESS,
        Ok(Err(failure)) => failure.report(),
        Err(_) => ExitCode::FAILURE,
    }
}
