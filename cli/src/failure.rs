//! How a command fails: a line, and an exit code.

use std::{
    fmt::Display,
    io::{self, Write},
    path::Path,
    process::ExitCode,
};

use kiloray_scene::regular;

use crate::console::harmless;

/// Why a command ends early.
#[derive(Debug, PartialEq, Eq)]
pub(crate) enum Failure {
    /// What was typed makes no sense: exit code 2.
    Usage(String),
    /// It was understood and could not be done: exit code 1.
    Failed(String),
    /// The reader of our output went away: nobody is left to tell, and nothing is wrong.
    ClosedPipe,
    /// Help or the version, for the standard output.
    Printed,
}

/// What a command returns.
pub(crate) type Outcome<T = ()> = Result<T, Failure>;

impl Failure {
    /// Exit code 1.
    pub(crate) fn new(message: impl Display) -> Self {
        Self::Failed(message.to_string())
    }

    /// Exit code 2.
    pub(crate) fn usage(message: impl Display) -> Self {
        Self::Usage(message.to_string())
    }

    /// Something about a file.
    pub(crate) fn file(path: &Path, cause: impl Display) -> Self {
        Self::Failed(format!("{}: {cause}", path.display()))
    }

    /// The same, of one among others.
    #[cfg(feature = "host")]
    pub(crate) fn of(self, name: impl Display) -> Self {
        match self {
            Self::Usage(message) => Self::Usage(format!("{name}: {message}")),
            Self::Failed(message) => Self::Failed(format!("{name}: {message}")),
            Self::ClosedPipe | Self::Printed => self,
        }
    }

    /// Something the system says about a file, in words that say what to do.
    pub(crate) fn io(path: &Path, error: &io::Error) -> Self {
        match error.kind() {
            io::ErrorKind::BrokenPipe => Self::ClosedPipe,
            _ => Self::file(path, regular::words(error)),
        }
    }

    /// The same, and what else is to be known of it.
    pub(crate) fn and(self, more: &str) -> Self {
        match self {
            Self::Usage(message) => Self::Usage(format!("{message}; {more}")),
            Self::Failed(message) => Self::Failed(format!("{message}; {more}")),
            Self::ClosedPipe | Self::Printed => self,
        }
    }

    /// The line.
    pub(crate) fn message(&self) -> &str {
        match self {
            Self::Usage(message) | Self::Failed(message) => message,
            Self::ClosedPipe | Self::Printed => "",
        }
    }

    /// Prints the line; gives the exit code.
    pub(crate) fn report(&self) -> ExitCode {
        let (message, code) = match self {
            Self::ClosedPipe | Self::Printed => return ExitCode::SUCCESS,
            Self::Usage(message) => (message, 2),
            Self::Failed(message) => (message, 1),
        };
        print(message);
        ExitCode::from(code)
    }
}

/// Prints `error: ..` as one line.
pub(crate) fn print(message: &str) {
    say("error", message);
}

/// Prints `note: ..` as one line.
pub(crate) fn warn(message: &str) {
    say("note", message);
}

/// The same, where there is something to say.
pub(crate) fn note(message: Option<&str>, quiet: bool) {
    if let Some(message) = message.filter(|_| !quiet) {
        warn(message);
    }
}

/// Says of a picture that some of its light could not be counted.
pub(crate) fn warn_of_overflows(pixels: u64, quiet: bool) {
    if pixels > 0 && !quiet {
        warn(&format!(
            "{pixels} pixels are too bright to be counted and show the brightest that can be"
        ));
    }
}

/// One line on the standard error, and never mind if nobody listens.
fn say(what: &str, message: &str) {
    let _ = writeln!(io::stderr().lock(), "{what}: {}", harmless(message).trim_end());
}

/// A panic is our mistake: it says so in one line.
pub(crate) fn report_panics_in_one_line() {
    std::panic::set_hook(Box::new(|info| {
        let cause = info
            .payload()
            .downcast_ref::<&str>()
            .map(|&s| s.to_owned())
            .or_else(|| info.payload().downcast_ref::<String>().cloned())
            .unwrap_or_default();
        let place = info.location().map(|l| format!("{}:{}", l.file(), l.line()));
        print(&format!(
            "internal: {cause} ({}); this is a mistake in kiloray, please report it",
            place.unwrap_or_default()
        ));
    }));
}
