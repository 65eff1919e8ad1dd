//! The scene: a `.kilo` file in flash, read in place.

#[repr(C, align(4096))]
struct Aligned<T: ?Sized>(T);

static SCENE: &Aligned<[u8]> = &Aligned(*include_bytes!(concat!(env!("OUT_DIR"), "/scene.kilo")));

/// The file's bytes; they begin at a multiple of every block size up to 4 KiB.
pub(crate) fn bytes() -> &'static [u8] {
    &SCENE.0
}
