//! The picture must not depend on the machine: not on memory, blocks, batches, threads or lanes.

mod support;

use kiloray_core::block::KiloView;
use kiloray_core::geometry::{Hit, Ray};
use kiloray_core::material::{OpticalDepth, crossing};
use kiloray_core::path::PathKey;
use kiloray_core::shade::{Counts, Path, Settings, Shader, Sum, Tables, Visibility};
use kiloray_core::store::{BudgetError, Line};
use kiloray_core::trace::{Cursor, Scalar, TraceError, Tracer};
use kiloray_core::view::Camera;
use kiloray_render::{Control, Error, Lanes, Options, PictureError, plan, render};
use kiloray_scene::compile::compile;
use kiloray_scene::import;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use support::{bits, compiled, run};

const WIDTH: u32 = 29;
const HEIGHT: u32 = 22;

fn options(file: &KiloView<'_>) -> Options {
    let settings = Settings { samples: 2, shadow_samples: 2, lights: 3, bounces: 5, seed: 7 };
    Options { settings, ..Options::new(WIDTH, HEIGHT, file.views()[0]) }
}

/// One ray after the other, by the simplest code there is.
struct Plain<'a>(KiloView<'a>, Cursor);

impl Visibility for Plain<'_> {
    type Error = TraceError<kiloray_core::block::NoBlock>;

    fn closest(&mut self, ray: &Ray) -> Result<Option<Hit>, Self::Error> {
        Scalar.closest(&mut self.1, &mut self.0, ray)
    }

    fn depths(&mut self, rays: &[Ray], depths: &mut [OpticalDepth]) -> Result<(), Self::Error> {
        for (ray, depth) in rays.iter().zip(depths) {
            *depth = OpticalDepth::CLEAR;
            let materials = self.0.materials();
            Scalar.every(&mut self.1, &mut self.0, ray, |hit| {
                *depth = depth.and(crossing(&materials[usize::from(hit.material)], ray, hit));
                false
            })?;
        }
        Ok(())
    }
}

/// The picture of [`Shader::trace`], path by path.
fn reference(file: &KiloView<'_>, options: &Options) -> (Vec<[u32; 3]>, Counts) {
    let shader = Shader::new(Tables::of(file), options.settings);
    let camera = Camera::new(&options.view, WIDTH, HEIGHT, options.settings.samples).unwrap();
    let mut plain = Plain(*file, Cursor::new());
    let mut counts = Counts::default();
    let mut pixels = Vec::new();
    for pixel in 0..WIDTH * HEIGHT {
        let mut sum = Sum::ZERO;
        for sample in 0..options.settings.samples {
            let key = PathKey::camera(options.settings.seed, pixel, sample);
            let ray = camera.ray(pixel % WIDTH, pixel / WIDTH, key);
            sum.add(shader.trace(&mut plain, &ray, Path::camera(key), &mut counts).unwrap());
        }
        let light = shader.unit().resolve(sum, options.settings.samples);
        pixels.push(light.to_array().map(f32::to_bits));
    }
    (pixels, counts)
}

/// The least memory that is not refused.
fn least(file: &KiloView<'_>, options: &Options) -> usize {
    match plan(file, &Options { memory: Some(0), ..*options }) {
        Err(Error::Budget(error)) => error.need(),
        other => panic!("no memory is enough: {other:?}"),
    }
}

#[test]
fn any_memory_any_blocks_any_threads_the_same_bits() {
    for scene in ["cornell", "glass"] {
        let mut expected = None;
        let mut clear = 0;
        for block_bytes in [1 << 10, 4 << 10, 16 << 10] {
            let compiled = compiled(scene, block_bytes);
            let file = KiloView::parse(compiled.bytes()).unwrap();
            file.check_blocks().unwrap();
            let base = options(&file);
            let (pixels, counts) = expected.get_or_insert_with(|| reference(&file, &base));
            assert!(counts.shadow > 0 && (scene == "cornell") == (counts.specular == 0));
            let memory = |bytes| Options { memory: Some(bytes), ..base };
            let runs = [
                memory(least(&file, &base)),
                memory(64 << 10),
                memory(256 << 10),
                memory(16 << 20),
                Options { lanes: Lanes::Scalar, ..memory(64 << 10) },
                Options { threads: 1, ..base },
                Options { threads: 2, ..base },
                Options { threads: 1, lanes: Lanes::Scalar, ..base },
                Options { batch: 1, ..base },
                Options { batch: 8, ..base },
            ];
            for options in &runs {
                let rendered = run(&file, options).unwrap();
                let what = format!(
                    "{scene}, blocks of {block_bytes}, {:?} bytes, {} threads, batch {}, {:?}",
                    options.memory, options.threads, options.batch, options.lanes
                );
                assert!(bits(&rendered) == *pixels, "{what}");
                let mut found = rendered.report.counts;
                clear += found.shadow_clear;
                // What was not traced because nothing is in the way is all that may differ.
                found.shadow += std::mem::take(&mut found.shadow_clear);
                assert_eq!(found, *counts, "{what}");
                assert_eq!(rendered.report.overflows, 0);
            }
        }
        assert!(clear > 0, "{scene}: no bundle was clear");
    }
}

#[test]
fn what_is_taken_for_clear_is_clear() {
    for scene in ["studio", "conference", "colour-cube:4", "sinc:24", "sphereflake:2", "furnace"] {
        let compiled = compiled(scene, 4 << 10);
        let file = KiloView::parse(compiled.bytes()).unwrap();
        let mut options = options(&file);
        options.settings.shadow_samples = 8;
        let (pixels, counts) = reference(&file, &options);
        let rendered = run(&file, &options).unwrap();
        assert!(bits(&rendered) == pixels, "{scene}");
        let found = rendered.report.counts;
        assert_eq!(found.shadow + found.shadow_clear, counts.shadow, "{scene}");
    }
}

/// The edge of a shadow under suns of any width, from so near that a pixel is a part of the penumbra.
#[test]
fn the_shadows_of_small_suns_are_not_taken_for_light() {
    for degrees in [0.005, 0.02, 0.1, 0.3, 0.533, 2.0] {
        let penumbra = 4.0 * f64::tan(f64::to_radians(degrees) / 2.0);
        let folder = tempfile::tempdir().unwrap();
        let (scene, view) = (folder.path().join("sun.rad"), folder.path().join("above.vf"));
        let text = format!(
            "void plastic grey 0 0 5 .5 .5 .5 0 0
             void light sun_mat 0 0 3 1e6 1e6 1e6
             sun_mat source sun 0 0 4 0 0 1 {degrees}
             grey polygon floor 0 0 12 -1 -1 0 1 -1 0 1 1 0 -1 1 0
             grey polygon knife 0 0 12 0 -1 1 0 1 1 -1 1 1 -1 -1 1"
        );
        let shown =
            format!("VIEW= -vtl -vp 0 0 .5 -vd 0 0 -1 -vu 0 1 0 -vh {penumbra} -vv {penumbra}");
        std::fs::write(&scene, text).unwrap();
        std::fs::write(&view, shown).unwrap();
        let model = import::load(&[scene, view], &import::ImportOptions::default()).unwrap();
        let blocks = kiloray_scene::compile::Options::blocks_of(1 << 10);
        let compiled = compile(&model, &blocks, &mut ()).unwrap();
        let file = KiloView::parse(compiled.bytes()).unwrap();
        let options = options(&file);
        let (pixels, _) = reference(&file, &options);
        assert!(bits(&run(&file, &options).unwrap()) == pixels, "{degrees} degrees");
    }
}

#[test]
fn the_least_memory_is_the_least() {
    let compiled = compiled("glass", 4 << 10);
    let file = KiloView::parse(compiled.bytes()).unwrap();
    let options = options(&file);
    let least = least(&file, &options);
    assert!(least < 8 << 10, "{least}");
    assert!(run(&file, &Options { memory: Some(least - 64), ..options }).is_err());
    let report = run(&file, &Options { memory: Some(least), ..options }).unwrap().report;
    assert_eq!(report.budget.line(Line::Frames).peak, 1);
    assert_eq!(report.budget.line(Line::Points).peak, 3, "two children, and one more of the first");
    assert!(report.budget.peak_bytes() <= least);
    assert!(report.cache.evictions > 1000 && report.cache.hits > 0);
}

#[test]
fn a_small_memory_is_refused_line_by_line() {
    let compiled = compiled("glass", 16 << 10);
    let file = KiloView::parse(compiled.bytes()).unwrap();
    let error = run(&file, &Options { memory: Some(10_000), ..options(&file) }).unwrap_err();
    let Error::Budget(error @ BudgetError { .. }) = error else { panic!("{error}") };
    let frames = error.lines().find(|l| l.line == Line::Frames).unwrap();
    assert_eq!(frames.need, 16 << 10);
    assert!(frames.have < 10_000 && error.to_string().contains("block frames"), "{error}");
}

#[test]
fn every_plan_stays_within_its_memory() {
    let compiled = compiled("glass", 1 << 10);
    let file = KiloView::parse(compiled.bytes()).unwrap();
    let base = options(&file);
    let mut last = 0;
    for memory in (least(&file, &base)..400_000).step_by(997) {
        let plan = plan(&file, &Options { memory: Some(memory), ..base }).unwrap();
        assert!(plan.budget(memory).is_ok());
        assert!(plan.frames >= 1 && plan.frames <= file.blocks() as usize);
        assert!(plan.batch >= last, "more memory, smaller batches");
        last = plan.batch;
    }
    assert!(last > 1);
}

#[test]
fn blocks_that_nobody_checked_are_no_danger() {
    let compiled = compiled("glass", 4 << 10);
    let len = compiled.bytes().len();
    let at = compiled.header().blocks_at as usize;
    let mut errors = 0;
    for step in 0..60 {
        let mut bytes = vec![kiloray_core::store::Chunk::ZERO; len.div_ceil(64)];
        let image: &mut [u8] = bytemuck::cast_slice_mut(&mut bytes);
        image[..len].copy_from_slice(compiled.bytes());
        // Headers, nodes and what follows, of every block.
        for byte in (at + step * 7 % 512..len).step_by(509) {
            image[byte] ^= 0x55;
        }
        let file = KiloView::parse(image).unwrap();
        let settings = Settings { samples: 1, shadow_samples: 1, ..Settings::default() };
        let options = Options { width: 4, height: 4, settings, ..options(&file) };
        for memory in [None, Some(32 << 10)] {
            errors += u32::from(run(&file, &Options { memory, ..options }).is_err());
        }
    }
    assert!(errors > 0, "none of them was found out");
}

#[test]
fn it_stops_when_told_and_reports_every_tile() {
    let compiled = compiled("cornell", 4 << 10);
    let file = KiloView::parse(compiled.bytes()).unwrap();
    for memory in [None, Some(64 << 10)] {
        let options = Options { memory, ..options(&file) };
        let stop = Control { cancel: &AtomicBool::new(true), progress: &|_, _| panic!("a tile") };
        assert!(matches!(render(&file, &options, &stop), Err(Error::Cancelled)));
        let calls = AtomicU64::new(0);
        let progress = |done, total| {
            assert_eq!(calls.fetch_add(1, Ordering::Relaxed) + 1, done);
            assert!(done <= total);
        };
        let go = Control { cancel: &AtomicBool::new(false), progress: &progress };
        render(&file, &options, &go).unwrap();
        assert!(calls.into_inner() > 1);
    }
}

#[test]
fn what_cannot_be_a_picture_is_refused() {
    let compiled = compiled("cornell", 4 << 10);
    let file = KiloView::parse(compiled.bytes()).unwrap();
    let options = options(&file);
    for (width, height) in [(0, 5), (5, 0), (u32::MAX, u32::MAX)] {
        let error = run(&file, &Options { width, height, ..options }).unwrap_err();
        assert!(matches!(error, Error::Picture(PictureError::Size { .. })), "{error}");
    }
    let mut view = options.view;
    view.up = view.direction;
    let error = run(&file, &Options { view, ..options }).unwrap_err();
    assert!(matches!(error, Error::Picture(PictureError::View)), "{error}");
}
