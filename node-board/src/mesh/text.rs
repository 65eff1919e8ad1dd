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
    use core::ffi::CStr;

    use semihosting::sys::arm_compat::sys_write0;

    let mut line = [0; 16];
    let len = what.len().min(line.len() - 2);
    line[..len].copy_from_slice(&what.as_bytes()[..len]);
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
