//! The command as a person meets it: the real binary, its exit codes, messages and files.

mod compare;
mod compile;
mod render;
mod support;
mod usage;
