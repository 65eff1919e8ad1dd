//! The node's share of the scene: a part of the flash that the memory map keeps for it.

use core::ptr::addr_of;
use core::slice;

#[repr(C, align(64))]
struct Aligned<T: ?Sized>(T);

/// The file that `KILORAY_SHARE` named when the firmware was built; without it nothing, and whoever loads the firmware puts the file there.
#[used]
#[unsafe(link_section = ".share")]
static LINKED: Aligned<[u8; include_bytes!(concat!(env!("OUT_DIR"), "/share.bin")).len()]> =
    Aligned(*include_bytes!(concat!(env!("OUT_DIR"), "/share.bin")));

unsafe extern "C" {
    // Of `memory/share.x`.
    static __share_start: u8;
    static __share_end: u8;
}

/// What lies there.
pub(crate) fn bytes() -> &'static [u8] {
    let (start, end) = (addr_of!(__share_start), addr_of!(__share_end));
    // SAFETY: flash that nothing else lies in (the linker script sees to it) and nothing writes to.
    unsafe { slice::from_raw_parts(start, end as usize - start as usize) }
}
