//! What tests of pictures share.

use kiloray_core::block::KiloView;
use kiloray_render::{Control, Error, Options, Rendered, render};
use kiloray_scene::builtin;
use kiloray_scene::compile::{Compiled, compile};
use std::sync::atomic::AtomicBool;

/// A built-in scene in blocks of this size.
pub(crate) fn compiled(scene: &str, block_bytes: usize) -> Compiled {
    let model = builtin::build(scene).unwrap();
    compile(&model, &kiloray_scene::compile::Options::blocks_of(block_bytes), &mut ()).unwrap()
}

/// A picture that nobody follows or stops.
pub(crate) fn run(file: &KiloView<'_>, options: &Options) -> Result<Rendered, Error> {
    let control = Control { cancel: &AtomicBool::new(false), progress: &|_, _| {} };
    render(file, options, &control)
}

pub(crate) fn bits(rendered: &Rendered) -> Vec<[u32; 3]> {
    rendered.picture.pixels.iter().map(|p| p.map(f32::to_bits)).collect()
}
