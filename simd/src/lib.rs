//! The lanes of x86-64 processors, their run-time detection, and nearly all unsafe code of the host side: the rest maps a
//! file, in `kiloray-scene`.
//!
//! [`Auto`] is the [`Tracer`](kiloray_core::trace::Tracer) of a host: it finds out once what the machine can do, and traces with it.
//! Its hits are those of [`Scalar`](kiloray_core::trace::Scalar) to the bit.

mod auto;
#[cfg(target_arch = "x86_64")]
mod wide;

pub use auto::Auto;
#[cfg(target_arch = "x86_64")]
pub use wide::{Avx2, Avx512};

#[cfg(test)]
use kiloray_core::{block, geometry, trace};
#[cfg(test)]
mod tests;
