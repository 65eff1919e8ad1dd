//! What the board says: over semihosting, to whoever debugs or emulates it.

use core::fmt::Display;

use semihosting::{println, process};

/// A line.
pub(crate) fn say(what: &str, text: &dyn Display) {
    println!("{}: {}", what, text);
}

/// A line, and the end.
pub(crate) fn fail(what: &str, why: &dyn Display) -> ! {
    say(what, why);
    process::exit(1);
}
