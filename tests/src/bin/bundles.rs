//! `bundles [--block BYTES] [--size PIXELS] [--tile PIXELS] SCENE..`: how little of a built-in scene a bundle of rays references.
//!
//! For each tile of the picture, and for the shadow rays of each tile's middle pixel towards each light, the pyramid is clipped
//! against the scene. Printed: blocks, subtrees and primitives per bundle, boxes tested, the share of
//! shadow bundles whose list is empty (their rays need not be traced), and microseconds per bundle.

use std::process::ExitCode;
use std::time::Instant;

use clap::Parser;
use glam::Vec3;
use kiloray_core::block::KiloView;
use kiloray_core::geometry::{Pyramid, Ray};
use kiloray_core::scene::LightKind;
use kiloray_core::trace::{Clip, ClipEntry, Cursor, Scalar, Tracer};
use kiloray_core::view::Camera;
use kiloray_scene::compile::{Options, compile};

/// How little of a built-in scene a bundle of rays references.
#[derive(Parser)]
struct Arguments {
    /// Size of a block.
    #[arg(long, value_name = "BYTES", default_value_t = 4096)]
    block: usize,
    /// Pixels along the picture.
    #[arg(long, value_name = "PIXELS", default_value_t = 256, value_parser = clap::value_parser!(u32).range(1..))]
    size: u32,
    /// Pixels along a tile.
    #[arg(long, value_name = "PIXELS", default_value_t = 8, value_parser = clap::value_parser!(u32).range(1..))]
    tile: u32,
    /// Built-in scenes.
    #[arg(required = true)]
    scenes: Vec<String>,
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    println!(
        "{:18} {:>8} {:>7} | {:>7} {:>8} {:>7} {:>7} {:>6} {:>6} | {:>7} {:>6}",
        "scene",
        "objects",
        "blocks",
        "bundles",
        "objects",
        "part",
        "subtr.",
        "blocks",
        "boxes",
        "empty",
        "us"
    );
    for scene in &arguments.scenes {
        if let Err(error) = measure(scene, &arguments) {
            eprintln!("bundles: {scene}: {error}");
            return ExitCode::FAILURE;
        }
    }
    ExitCode::SUCCESS
}

/// Sums over the bundles of a kind.
#[derive(Default)]
struct Sums {
    bundles: u64,
    objects: u64,
    subtrees: u64,
    blocks: u64,
    boxes: u64,
    empty: u64,
    seconds: f64,
}

impl Sums {
    fn clip(&mut self, file: &mut KiloView<'_>, nesting: u16, make: impl FnOnce() -> Pyramid) {
        let mut window = [ClipEntry::EMPTY; 64];
        let mut blocks = Vec::new();
        let start = Instant::now();
        let Some(mut clip) = Clip::new(make(), nesting, &mut window) else { return };
        while !clip.is_done() {
            if clip.round(file).is_err() {
                return;
            }
            while let Some(entry) = clip.pop() {
                self.subtrees += 1;
                blocks.push(entry.block);
            }
        }
        self.seconds += start.elapsed().as_secs_f64();
        self.bundles += 1;
        self.objects += u64::from(clip.counts().primitives);
        self.boxes += u64::from(clip.counts().boxes);
        self.empty += u64::from(blocks.is_empty());
        blocks.sort_unstable();
        blocks.dedup();
        self.blocks += blocks.len() as u64;
    }

    fn print(&self, name: &str, objects: u32, blocks: u32) {
        let per = |n: u64| n as f64 / self.bundles.max(1) as f64;
        println!(
            "{name:18} {objects:>8} {blocks:>7} | {:>7} {:>8.1} {:>6.3}% {:>7.1} {:>6.1} {:>6.0} | {:>6.1}% {:>6.1}",
            self.bundles,
            per(self.objects),
            100.0 * per(self.objects) / f64::from(objects.max(1)),
            per(self.subtrees),
            per(self.blocks),
            per(self.boxes),
            100.0 * per(self.empty),
            1e6 * self.seconds / self.bundles.max(1) as f64,
        );
    }
}

fn measure(scene: &str, arguments: &Arguments) -> Result<(), Box<dyn std::error::Error>> {
    let model = kiloray_scene::builtin::build(scene)?;
    let compiled = compile(&model, &Options::blocks_of(arguments.block), &mut ())?;
    let mut file = KiloView::parse(compiled.bytes())?;
    file.check_blocks()?;
    let header = *file.header();
    let view = file.views().first().ok_or("no view")?;
    let (size, tile) = (arguments.size, arguments.tile);
    let camera = Camera::new(view, size, size, 1).ok_or("the view shows nothing")?;
    let nesting = file.trusted_block(0).ok_or("no surfaces")?.header().nesting;
    let lights = file.lights().to_vec();
    let (mut tiles, mut shadows) = (Sums::default(), Sums::default());
    let mut cursor = Cursor::new();
    for y in (0..size).step_by(tile as usize) {
        for x in (0..size).step_by(tile as usize) {
            let at = |dx: u32, dy: u32| {
                let part = |p: u32| p.min(size) as f32 / size as f32;
                camera.ray_at(part(x + dx), part(y + dy))
            };
            let corners = [at(0, 0), at(tile, 0), at(tile, tile), at(0, tile)];
            tiles.clip(&mut file, nesting, || Pyramid::of_tile(&corners));
            let ray: Ray = at(tile / 2, tile / 2);
            let Some(hit) = Scalar.closest(&mut cursor, &mut file, &ray)? else { continue };
            let point = hit.surface(&ray);
            for light in &lights {
                let kind = LightKind::from_u32(light.kind);
                let facing = (Vec3::from(light.position) - point.position).dot(point.normal);
                if kind != Some(LightKind::Distant)
                    && facing * ray.direction.dot(point.normal) > 0.0
                {
                    continue;
                }
                shadows.clip(&mut file, nesting, || point.pyramid_to(light, -ray.direction));
            }
        }
    }
    tiles.print(&format!("{scene} tile"), header.primitives, header.blocks);
    shadows.print(&format!("{scene} shadow"), header.primitives, header.blocks);
    Ok(())
}
