//! The firmware.
use cortex_m_rt::entry;
use kiloray_core::block::KiloView;
use kiloray_core::trace::Cursor;
use semihosting::{println, process};

use crate::{rays, scene, stack};

#[entry]
fn main() -> ! {
    stack::paint();
    let file = match KiloView::parse(scene::bytes()) {
        Ok(file) => file,
        Err(error) => fail("the scene", &error),
    };
    if let Err(error) = file.check_blocks() {
        fail("the scene", &error);
    }
    match rays::trace(&file, &mut Cursor::new()) {
        Ok(hits) => println!("{} rays, {} hits, hash {:08x}", hits.rays, hits.hits, hits.hash),
        Err(error) => fail("rays", &format_args!("{error:?}")),
    }
    println!("stack {} bytes", stack::used_bytes());
    process::exit(0);
}

fn fail(what: &str, why: &dyn core::fmt::Display) -> ! {
    println!("{}: {}", what, why);
    process::exit(1);
}
