//! Lanes by eights: those of x86-64 processors, found at run time, those of any machine, and nearly all unsafe code of the host side: the rest maps a
//! file, in `kiloray-scene`.
//!
//! [`Auto`] is the [`Tracer`](kiloray_core::trace::Tracer) of a host: it finds out once what the machine can do, and traces with it.
//! Its hits are those of [`Scalar`](kiloray_core::trace::Scalar) to the bit, and what it visits is the same on any machine.

mod auto;
mod portable;
#[cfg(target_arch = "x86_64")]
mod wide;

pub use auto::Auto;
pub use portable::{Portable, Quickest};
#[cfg(target_arch = "x86_64")]
pub use wide::{Avx2, Avx512};

#[cfg(test)]
use kiloray_core::{block, geometry, trace};
#[cfg(test)]
mod tests;
