//! The picture that all others must equal: by one thread, over the file.

use std::sync::atomic::AtomicBool;

use kiloray_core::scene::View;
use kiloray_core::shade::Settings;
use kiloray_render::{Control, Options, Picture, render};
use kiloray_scene::kilo::KiloFile;

/// It.
///
/// # Errors
/// What the renderer says.
pub fn one_thread(
    file: &KiloFile,
    width: u32,
    height: u32,
    view: View,
    settings: Settings,
) -> Result<Picture, String> {
    let options = Options { settings, threads: 1, ..Options::new(width, height, view) };
    let control = Control { cancel: &AtomicBool::new(false), progress: &|_, _| {} };
    let rendered = render(&file.view(), &options, &control);
    rendered.map(|rendered| rendered.picture).map_err(|e| e.to_string())
}

/// The pixels, bit by bit.
#[must_use]
pub fn bits(picture: &Picture) -> Vec<[u32; 3]> {
    picture.pixels.iter().map(|pixel| pixel.map(f32::to_bits)).collect()
}
