//! The scene: a `.kilo` file that the emulator has put into the upper part of the flash (`-device loader`), so that one build measures many.

use core::mem::offset_of;
use kiloray_core::block::format::FileHeader;

const AT: *const u8 = 0x0020_0000 as *const u8;
const BYTES: usize = 2 << 20;
const LEN: usize = offset_of!(FileHeader, file_bytes);

/// The file, as long as its header says, if that can be.
pub(crate) fn bytes() -> &'static [u8] {
    // SAFETY: this is flash of the mps2 boards (`../../../memory.x`), of which the firmware takes the first few hundred KiB.
    let flash = unsafe { core::slice::from_raw_parts(AT, BYTES) };
    let len = flash.get(LEN..LEN + size_of::<u64>()).and_then(|len| len.try_into().ok());
    len.and_then(|len| flash.get(..u64::from_le_bytes(len) as usize)).unwrap_or(flash)
}
