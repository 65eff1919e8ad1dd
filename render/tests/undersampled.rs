//! A picture with fewer camera rays than pixels: what is traced is as in the whole picture, the rest lies between.

mod support;

use kiloray_core::block::KiloView;
use kiloray_core::shade::Settings;
use kiloray_render::{Control, Lanes, Options, Rendered, Undersampling, render};
use kiloray_scene::compile::Compiled;
use std::sync::Mutex;
use std::sync::atomic::AtomicBool;
use support::{bits, compiled, run};

const BLOCK: usize = 4 << 10;
const SIZES: [(u32, u32); 6] = [(1, 1), (1, 9), (10, 1), (2, 2), (37, 22), (64, 33)];

/// The file of a scene, and pictures of it.
struct Scene<'f>(KiloView<'f>);

impl<'f> Scene<'f> {
    fn new(compiled: &'f Compiled) -> Self {
        let file = KiloView::parse(compiled.bytes()).unwrap();
        file.check_blocks().unwrap();
        Self(file)
    }

    fn options(&self, (width, height): (u32, u32)) -> Options {
        let settings = Settings { samples: 2, shadow_samples: 4, ..Settings::default() };
        Options { settings, threads: 1, ..Options::new(width, height, self.0.views()[0]) }
    }

    fn render(&self, options: &Options) -> Rendered {
        run(&self.0, options).unwrap()
    }
}

fn undersampled(options: Options, spacing: u32, contrast: f32) -> Options {
    Options { undersampling: Some(Undersampling { spacing, contrast }), ..options }
}

/// Where the squares along a side begin and end.
fn lattice(len: u32, spacing: u32) -> Vec<u32> {
    let mut lines: Vec<_> = (0..len).step_by(spacing as usize).collect();
    if lines.last() != Some(&(len - 1)) {
        lines.push(len - 1);
    }
    lines
}

#[test]
fn between_corners_that_may_differ_as_they_like_it_is_bilinear() {
    let compiled = compiled("sinc:8", BLOCK);
    let scene = Scene::new(&compiled);
    for size in SIZES {
        let whole = scene.render(&scene.options(size)).picture;
        for spacing in [1, 2, 4, 8, 32] {
            let some = scene.render(&undersampled(scene.options(size), spacing, f32::MAX));
            let (columns, rows) = (lattice(size.0, spacing), lattice(size.1, spacing));
            let traced = (columns.len() * rows.len()) as u64;
            assert_eq!(some.report.interpolated, u64::from(size.0 * size.1) - traced);
            assert_eq!(some.report.counts.primary, 2 * traced, "{size:?}, {spacing}");
            // Two lines around a place, and the part of the way between them.
            let around = |lines: &[u32], at: u32| {
                let next = lines.partition_point(|&line| line < at);
                let (low, high) = (lines[next.saturating_sub(1)], lines[next]);
                (low, high, f64::from(at - low) / f64::from((high - low).max(1)))
            };
            for (index, pixel) in (0..).zip(&some.picture.pixels) {
                let (left, right, across) = around(&columns, index % size.0);
                let (above, below, down) = around(&rows, index / size.0);
                for (channel, &value) in pixel.iter().enumerate() {
                    let corner = |x: u32, y: u32| {
                        f64::from(whole.pixels[(y * size.0 + x) as usize][channel])
                    };
                    let row = |y| (1.0 - across) * corner(left, y) + across * corner(right, y);
                    let expected = (1.0 - down) * row(above) + down * row(below);
                    let error = (f64::from(value) - expected).abs();
                    assert!(error <= 1e-6 * expected.max(1e-3), "{size:?}, {spacing}, {index}");
                }
            }
        }
    }
}

#[test]
fn what_is_traced_is_as_in_the_whole_picture_on_any_machine() {
    for name in ["cornell", "glass"] {
        let compiled = compiled(name, BLOCK);
        let scene = Scene::new(&compiled);
        for (spacing, contrast) in [(4, 0.0), (2, 0.1), (8, 0.3)] {
            let whole = scene.options((61, 47));
            let base = undersampled(whole, spacing, contrast);
            let expected = scene.render(&base);
            let differ = bits(&scene.render(&whole)).into_iter().zip(bits(&expected));
            let differ = differ.filter(|(whole, some)| whole != some).count() as u64;
            let report = &expected.report;
            assert!(differ <= report.interpolated, "{name}: {differ}");
            assert_eq!(report.counts.primary + 2 * report.interpolated, 2 * 61 * 47);
            assert!(contrast == 0.0 || report.interpolated > 300, "{name}: {report:?}");
            for options in [
                Options { threads: 2, ..base },
                Options { threads: 3, batch: 4, ..base },
                Options { lanes: Lanes::Scalar, ..base },
                Options { memory: Some(64 << 10), ..base },
                Options { memory: Some(1 << 20), batch: 2, ..base },
            ] {
                let rendered = scene.render(&options);
                assert!(bits(&rendered) == bits(&expected), "{name}: {options:?}");
                assert_eq!(rendered.report.interpolated, report.interpolated);
            }
        }
    }
}

#[test]
fn where_corners_differ_everywhere_all_is_traced() {
    let compiled = compiled("cornell", BLOCK);
    let scene = Scene::new(&compiled);
    for size in SIZES.into_iter().chain([(3, 3), (3, 64), (6, 3), (5, 5)]) {
        let whole = bits(&scene.render(&scene.options(size)));
        for spacing in [1, 2, 4, 8, 16, 32] {
            let some = scene.render(&undersampled(scene.options(size), spacing, 0.0));
            assert!(bits(&some) == whole, "{size:?}, {spacing}: {:?}", some.report.interpolated);
        }
    }
}

#[test]
fn a_square_is_interpolated_where_its_corners_differ_by_no_more_than_the_contrast() {
    let compiled = compiled("cornell", BLOCK);
    let scene = Scene::new(&compiled);
    let (width, height, contrast) = (63_usize, 49_usize, 0.15_f32);
    let options = scene.options((width as u32, height as u32));
    let whole = scene.render(&options).picture.pixels;
    let some = scene.render(&undersampled(options, 2, contrast)).picture.pixels;
    let brightness = |pixel: [f32; 3]| pixel.into_iter().fold(0.0, f32::max);
    let starts = (0..height - 1).step_by(2);
    let corners = starts.flat_map(|y| (0..width - 1).step_by(2).map(move |x| (x, y)));
    let mut first: Vec<_> = corners.map(|(x, y)| brightness(whole[y * width + x])).collect();
    first.sort_by(f32::total_cmp);
    let usual = first[first.len() / 2];
    let mut interpolated = [0, 0];
    // The middles of all squares of two pixels.
    for (x, y) in (1..height).step_by(2).flat_map(|y| (1..width).step_by(2).map(move |x| (x, y))) {
        let corners = [(x - 1, y - 1), (x + 1, y - 1), (x - 1, y + 1), (x + 1, y + 1)]
            .map(|(x, y)| whole[y * width + x]);
        let most = |values: [f32; 4]| values.into_iter().fold(f32::MIN, f32::max);
        let channels = [0, 1, 2].map(|channel| corners.map(|corner| corner[channel]));
        let darkest = corners.map(brightness).into_iter().fold(f32::MAX, f32::min);
        let allowed = contrast * darkest.max(usual);
        let alike = |values: [f32; 4]| most(values) + most(values.map(|v| -v)) <= allowed;
        let found = some[y * width + x];
        if channels.into_iter().all(alike) {
            interpolated[usize::from(darkest > usual)] += 1;
            for (value, corners) in found.into_iter().zip(channels) {
                let mean = corners.iter().sum::<f32>() / 4.0;
                assert!((value - mean).abs() <= 1e-6 * mean, "{x}, {y}: {value} of {corners:?}");
            }
        } else {
            assert_eq!(found, whole[y * width + x], "{x}, {y}");
        }
    }
    assert!(interpolated.iter().all(|n| (10..500).contains(n)), "{interpolated:?}");
}

#[test]
fn less_contrast_is_less_error() {
    let compiled = compiled("cornell", BLOCK);
    let scene = Scene::new(&compiled);
    let whole = scene.options((96, 96));
    let whole = Options { settings: Settings { shadow_samples: 64, ..whole.settings }, ..whole };
    let reference = scene.render(&whole).picture;
    let mean = reference.pixels.iter().flatten().sum::<f32>() / (3.0 * 96.0 * 96.0);
    let mut last = (0.0, 0);
    for contrast in [0.02, 0.1, 0.3] {
        let some = scene.render(&undersampled(whole, 4, contrast));
        let pairs = some.picture.pixels.iter().flatten().zip(reference.pixels.iter().flatten());
        let squares: f32 = pairs.map(|(a, b)| (a - b) * (a - b)).sum();
        let rmse = (squares / (3.0 * 96.0 * 96.0)).sqrt() / mean;
        assert!(rmse > last.0 && rmse < contrast, "{rmse} at {contrast}");
        assert!(some.report.interpolated > last.1, "{:?} at {contrast}", some.report);
        last = (rmse, some.report.interpolated);
    }
}

#[test]
fn progress_never_goes_back() {
    let compiled = compiled("cornell", BLOCK);
    let scene = Scene::new(&compiled);
    let heard = Mutex::new(Vec::new());
    let progress = |done, all| heard.lock().unwrap().push((done, all));
    let control = Control { cancel: &AtomicBool::new(false), progress: &progress };
    render(&scene.0, &undersampled(scene.options((64, 64)), 4, 0.1), &control).unwrap();
    let heard = heard.into_inner().unwrap();
    assert!(heard.is_sorted() && heard.iter().all(|(done, all)| done <= all && *all == heard[0].1));
    // Each round goes over all tiles.
    assert_eq!(heard.len() as u64 % (heard[0].1 / 3), 0);
}
