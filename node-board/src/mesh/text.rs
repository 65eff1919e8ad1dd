//! What the board says: over semihosting, to whoever debugs or emulates it.

use core::fmt::Display;

use semihosting::process;

/// A line.
#[cfg(feature = "text")]
pub(crate) fn say(what: &str, text: &dyn Display) {
    semihosting::println!("{}: {}", what, text);
}

/// The first word of a line: all that is left where code for text is left out.
#[cfg(not(feature = "text"))]
#[inline(always)]
pub(crate) fn say(what: &str, _: &dyn Display) {
    write(&[what.as_bytes()]);
}

/// A number, without what text takes of stack and flash.
#[cfg(feature = "stack")]
pub(crate) fn say_number(what: &str, number: usize) {
    let digits = [10_000, 1000, 100, 10, 1].map(|unit| b'0' + (number / unit % 10) as u8);
    write(&[what.as_bytes(), b" ", &digits]);
}

/// A short line, as it is.
#[cfg(any(feature = "stack", not(feature = "text")))]
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
pub(crate) fn fail(what: &str, why: &dyn Display) -> ! {
    say(what, why);
    process::exit(1);
}

/// As the handler of `semihosting` ends.
#[cfg(not(feature = "text"))]
#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    process::exit(101);
}
