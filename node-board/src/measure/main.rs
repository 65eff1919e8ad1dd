//! Counts what the operations of a node take: renders a scene as `kiloray-board` does, and prints for each step of the actor
//! what it did and how many ticks of the processor's clock it took. Under QEMU with `-icount shift=0` a tick is a fixed number of
//! instructions; on a board it is a cycle. `node-board/instructions` runs it and works out the rest.
#![no_std]
#![no_main]

#[path = "../node.rs"]
mod engine;
#[path = "../host.rs"]
mod host;
#[allow(dead_code, reason = "what becomes of the picture is asked elsewhere")]
#[path = "../picture.rs"]
mod picture;
mod pieces;
mod scene;
mod ticks;

use cortex_m_rt::entry;
use kiloray_core::block::KiloView;
use kiloray_core::node::Time;
use kiloray_core::store::Chunk;
use semihosting::{println, process};

const CHUNKS: usize = (engine::BESIDE_BYTES + (64 << 10)) / size_of::<Chunk>();

#[entry]
fn main() -> ! {
    ticks::start();
    match measure() {
        Ok(()) => process::exit(0),
        Err(error) => {
            println!("{error}");
            process::exit(1)
        }
    }
}

fn measure() -> Result<(), picture::PictureError> {
    let unsound = |_| picture::PictureError::Render("the scene is not sound");
    let file = KiloView::parse(scene::bytes()).map_err(unsound)?;
    let (Some(arena), Some(pixels)) = (
        cortex_m::singleton!(: [Chunk; CHUNKS] = [Chunk::ZERO; CHUNKS]),
        cortex_m::singleton!(: picture::Pixels = picture::BLACK),
    ) else {
        return Err(picture::PictureError::Render("begun twice"));
    };
    pieces::print(&file);
    println!("lights {}", file.lights().len());
    // Its columns: what a step did, then the ticks that it took.
    println!(
        "step nodes leaves blocks rays shadow_rays shadings light_samples clips messages copied ticks"
    );
    let done = engine::render_by(&file, arena, pixels, |node| {
        let begin = ticks::now();
        let progress = node.poll(Time(0));
        let ticks = ticks::now() - begin;
        let w = &progress.work;
        println!(
            "step {} {} {} {} {} {} {} {} {} {} {}",
            w.nodes,
            w.leaves,
            w.blocks,
            w.rays,
            w.shadow_rays,
            w.shadings,
            w.light_samples,
            w.clips,
            w.messages,
            w.copied,
            ticks
        );
        progress
    })?;
    println!("rays {} primary, {} shadow", done.counts.primary, done.counts.shadow);
    Ok(())
}
