//! Kiloray's core on a Cortex-M: renders the scene in flash in a fixed arena, and prints the
//! picture's hash over semihosting. On a PC the same program reads the scene from a file, so that
//! what they print can be compared: `node-board/check` does.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod board;
#[cfg_attr(feature = "node", path = "node.rs")]
#[cfg_attr(not(feature = "node"), path = "renderer.rs")]
mod engine;
#[cfg(feature = "node")]
mod host;
mod picture;
mod rays;
#[cfg(target_os = "none")]
mod scene;
#[cfg(target_os = "none")]
mod stack;

#[cfg(not(target_os = "none"))]
fn main() {
    let path = std::env::args_os().nth(1).expect("usage: kiloray-board FILE.kilo");
    let bytes = std::fs::read(&path).expect("a file that can be read");
    let mut aligned = vec![[0_u64; 512]; bytes.len().div_ceil(4096)];
    bytemuck::cast_slice_mut(&mut aligned)[..bytes.len()].copy_from_slice(&bytes);
    let bytes = &bytemuck::cast_slice(&aligned)[..bytes.len()];
    let file = kiloray_core::block::KiloView::parse(bytes).expect("a sound file");
    file.check_blocks().expect("sound blocks");
    let hits = rays::trace(&file, &mut kiloray_core::trace::Cursor::new()).expect("rays");
    println!("rays {}, hits {}, hash {:08x}", hits.rays, hits.hits, hits.hash);
    let mut memory = vec![kiloray_core::store::Chunk::ZERO; 1088];
    let mut pixels = picture::BLACK;
    let picture::Done { counts, budget } =
        engine::render(&file, &mut memory, &mut pixels).expect("a picture");
    println!("image_hash {}", picture::hash(&pixels));
    println!("rays {} primary, {} shadow", counts.primary, counts.shadow);
    println!("arena {} of {} bytes used", budget.peak_bytes(), budget.memory());
}
