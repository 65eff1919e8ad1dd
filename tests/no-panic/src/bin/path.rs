//! Names of paths and the random numbers made of them.
#![no_std]
#![no_main]

use core::hint::black_box;
use kiloray_core::path::PathKey;
use kiloray_no_panic::{any, entry};

entry!({
    let key = PathKey::camera(any(), any(), any()).child(any());
    black_box(key.scramble(any()));
});
