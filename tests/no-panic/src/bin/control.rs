//! Panics: the proof is worth something only as long as this one does not link.
#![no_std]
#![no_main]

use core::hint::black_box;
use kiloray_no_panic::{any, any_bytes, entry};

entry!({
    let index: usize = any();
    black_box(any_bytes()[index]);
});
