//! How deep the stack ran: it is painted before the run and read after it.
use core::ptr::{addr_of, addr_of_mut};

const PAINT: u32 = 0x5a17_c0de;
/// Kept free below the stack pointer while painting: the frame of `paint` itself.
const MARGIN_BYTES: usize = 256;

unsafe extern "C" {
    // Of cortex-m-rt's linker script: the stack grows from `_stack_start` down to `__sheap`.
    static mut __sheap: u32;
    static _stack_start: u32;
}

/// Paints what the stack does not use yet.
#[inline(never)]
pub(crate) fn paint() {
    let end = (cortex_m::register::msp::read() as usize).saturating_sub(MARGIN_BYTES);
    let mut at = addr_of_mut!(__sheap);
    while (at as usize) < end {
        // SAFETY: these words lie above all statics and below the stack in use, so nobody owns them.
        unsafe {
            at.write_volatile(PAINT);
            at = at.add(1);
        }
    }
}

/// Bytes of stack that were in use at the deepest, from the first word that lost its paint.
#[inline(never)]
pub(crate) fn used_bytes() -> usize {
    let top = addr_of!(_stack_start) as usize;
    let mut at = addr_of!(__sheap);
    while (at as usize) < top {
        // SAFETY: readable memory between the statics and the top of the stack.
        if unsafe { at.read_volatile() } != PAINT {
            break;
        }
        at = at.wrapping_add(1);
    }
    top.saturating_sub(at as usize)
}
