//! The reference tests of `core::geometry` against the oracle in f64.

mod cases;
mod closed;
mod failures;
mod judge;
mod sphere;
mod triangle;
