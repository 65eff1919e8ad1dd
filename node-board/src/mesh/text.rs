//! What the board says, over semihosting, to whoever debugs or emulates it: in words (feature `text`), as what `defmt-print` makes words of (`defmt`),
//! or only what it is about.

use semihosting::process;

#[cfg(feature = "defmt")]
use defmt_semihosting as _;

/// What can be said.
#[cfg(not(feature = "defmt"))]
pub(crate) use core::fmt::Display as Shown;
/// What can be said.
#[cfg(feature = "defmt")]
pub(crate) use defmt::Format as Shown;

/// A line.
#[cfg(feature = "text")]
pub(crate) fn say(what: &str, text: &dyn Shown) {
    semihosting::println!("{}: {}", what, text);
}

/// A line.
#[cfg(feature = "defmt")]
pub(crate) fn say(what: &str, text: &impl Shown) {
    defmt::println!("{=str}: {}", what, text);
}

/// The first word of a line: all that is left where code for text is left out.
#[cfg(not(any(feature = "text", feature = "defmt")))]
#[inline(always)]
pub(crate) fn say(what: &str, _: &dyn Shown) {
    write(&[what.as_bytes()]);
}

/// A number, without what text takes of stack and flash.
#[cfg(feature = "stack")]
pub(crate) fn say_number(what: &str, number: usize) {
    let digits = [10_000, 1000, 100, 10, 1].map(|unit| b'0' + (number / unit % 10) as u8);
    write(&[what.as_bytes(), b" ", &digits]);
}

/// A short line, as it is.
#[cfg(any(feature = "stack", not(any(feature = "text", feature = "defmt"))))]
fn write(parts: &[&[u8]]) {
    use core::ffi::CStr;

    use semihosting::sys::arm_compat::sys_write0;

    let mut line = [0; 24];
    let (end, room) = (line.len() - 2, parts.iter().copied().flatten());
    let len = line[..end].iter_mut().zip(room).map(|(place, &byte)| *place = byte).count();
    line[len] = b'\n';
    if let Ok(line) = CStr::from_bytes_until_nul(&line) {
        sys_write0(line);
    }
}

/// A line, and the end.
#[inline(always)]
pub(crate) fn fail(what: &str, why: &impl Shown) -> ! {
    say(what, why);
    process::exit(1);
}

/// As the handler of `semihosting` ends.
#[cfg(not(feature = "text"))]
#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    process::exit(101);
}

/// A part of a whole, as of nodes.
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub(crate) struct Of(pub(crate) usize, pub(crate) usize);

impl core::fmt::Display for Of {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "{} of {}", self.0, self.1)
    }
}
