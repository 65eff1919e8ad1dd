//! The scene: a `.kilo` file that the emulator has put into the upper part of the flash (`-device loader`), so that one build measures many.

const AT: *const u8 = 0x0020_0000 as *const u8;
const BYTES: usize = 2 << 20;

/// The place of the file, and what lies behind it.
pub(crate) fn bytes() -> &'static [u8] {
    // SAFETY: this is flash of the mps2 boards (`../../../memory.x`), of which the firmware takes the first few hundred KiB.
    unsafe { core::slice::from_raw_parts(AT, BYTES) }
}
