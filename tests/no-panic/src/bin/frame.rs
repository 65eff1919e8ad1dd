//! Frames of a serial line: any packet into any room, any bytes out of it.
#![no_std]
#![no_main]

use core::hint::black_box;
use kiloray_link::frame::{Decoder, encode};
use kiloray_no_panic::{any, any_bytes, any_room, entry};

entry!({
    let mut room = [0; 64];
    black_box(encode(any_bytes(), any_room(&mut room)));
    let mut decoder = Decoder::new();
    for _ in 0..any::<u32>() {
        black_box(decoder.push(any(), any_room(&mut room)));
    }
});
