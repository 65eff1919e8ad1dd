//! The firmware.
use core::cell::RefCell;

use cortex_m::interrupt::{self, Mutex};
use cortex_m_rt::entry;
use kiloray_core::block::KiloView;
use kiloray_core::store::Chunk;
use kiloray_core::trace::Cursor;
use semihosting::{println, process};

use crate::engine::{BESIDE_BYTES, render};
use crate::picture::{self, Done, Pixels};
use crate::{rays, scene, stack};

/// All memory that rendering uses.
#[cfg(feature = "mps2")]
const ARENA_BYTES: usize = 64 << 10;
#[cfg(not(feature = "mps2"))]
const ARENA_BYTES: usize = 16 << 10;

const CHUNKS: usize = (BESIDE_BYTES + ARENA_BYTES) / size_of::<Chunk>();

static ARENA: Mutex<RefCell<[Chunk; CHUNKS]>> = Mutex::new(RefCell::new([Chunk::ZERO; CHUNKS]));
/// The picture is no part of the arena: a node sends its tiles to a host.
static PIXELS: Mutex<RefCell<Pixels>> = Mutex::new(RefCell::new(picture::BLACK));

#[entry]
fn main() -> ! {
    let file = match KiloView::parse(scene::bytes()) {
        Ok(file) => file,
        Err(error) => fail("the scene", &error),
    };
    if let Err(error) = file.check_blocks() {
        fail("the scene", &error);
    }
    println!("scene {} bytes, {} blocks", scene::bytes().len(), file.blocks());
    stack::paint();
    trace(&file);
    println!("rays: stack {} bytes", stack::used_bytes());
    stack::paint();
    interrupt::free(|cs| {
        draw(&file, &mut *ARENA.borrow(cs).borrow_mut(), &mut PIXELS.borrow(cs).borrow_mut());
    });
    println!("picture: stack {} bytes", stack::used_bytes());
    process::exit(0);
}

#[inline(never)]
fn trace(file: &KiloView<'_>) {
    match rays::trace(file, &mut Cursor::new()) {
        Ok(hits) => println!("rays {}, hits {}, hash {:08x}", hits.rays, hits.hits, hits.hash),
        Err(error) => fail("rays", &format_args!("{error:?}")),
    }
}

#[inline(never)]
fn draw(file: &KiloView<'_>, memory: &mut [Chunk], pixels: &mut Pixels) {
    let Done { counts, budget } = match render(file, memory, pixels) {
        Ok(done) => done,
        Err(error) => fail("picture", &error),
    };
    println!("image_hash {}", picture::hash(pixels));
    println!("rays {} primary, {} shadow", counts.primary, counts.shadow);
    println!("arena {} of {} bytes used", budget.peak_bytes(), budget.memory());
}

fn fail(what: &str, why: &dyn core::fmt::Display) -> ! {
    println!("{}: {}", what, why);
    process::exit(1);
}
