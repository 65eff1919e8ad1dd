//! The command as a person meets it: the real binary, its exit codes, messages and files.

mod board;
mod calibrate;
#[cfg(feature = "host")]
mod cluster;
mod compare;
mod compile;
mod frames;
#[cfg(feature = "host")]
mod host;
mod hosts;
mod least;
mod page;
mod plan;
mod render;
#[cfg(unix)]
mod serial;
mod sim;
mod support;
mod sweep;
mod usage;
