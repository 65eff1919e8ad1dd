//! Signals to other processes.

use std::io;
use std::process::Command;

/// Sends a signal, as `-STOP`, to a process.
///
/// # Errors
/// There is no shell, or no such process.
pub fn send(signal: &str, process: u32) -> io::Result<()> {
    let command = format!("kill {signal} {process}");
    let sent = Command::new("sh").args(["-c", &command]).status()?;
    if sent.success() { Ok(()) } else { Err(io::Error::other(format!("{command}: {sent}"))) }
}
