//! The reader of a `.kilo` file, over any bytes.
#![no_std]
#![no_main]

use core::hint::black_box;
use kiloray_core::block::KiloView;
use kiloray_no_panic::{any, any_bytes, entry, print};

entry!({
    match KiloView::parse(any_bytes()) {
        Ok(file) => {
            black_box((file.header(), file.materials(), file.lights(), file.views()));
            black_box((file.needs(), file.limits(), file.block_bytes(any())));
            black_box((file.check_block(any()), file.check_blocks(), file.trusted_block(any())));
        }
        Err(error) => {
            print(&error);
        }
    }
});
