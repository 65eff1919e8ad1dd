//! `kiloray render`.

use std::{fs, path::Path};

use serde_json::Value;

use crate::support::{FIELDS, Folder, field, json};

impl Folder {
    /// Renders, and reads the JSON.
    fn render(&self, line: &str) -> Value {
        self.counted(&format!("render {line}"))
    }

    fn hash(&self, line: &str) -> String {
        self.render(line)["image_hash"].as_str().expect("a hash").to_owned()
    }
}

/// Pixels of an EXR file.
fn pixels(path: &Path) -> (usize, Vec<[f32; 3]>) {
    let image = exr::prelude::read_first_rgba_layer_from_file(
        path,
        |size, _| (size.width(), vec![[0.0; 3]; size.area()]),
        |(width, pixels): &mut (usize, Vec<_>), at, (r, g, b, _): (f32, f32, f32, f32)| {
            pixels[at.y() * *width + at.x()] = [r, g, b];
        },
    );
    image.expect("an EXR file").layer_data.channel_data.pixels
}

#[test]
fn the_json_has_what_scripts_rely_on() {
    let folder = Folder::new();
    let run = folder.render("cornell --width 40 --height 30 --samples 2 --seed 7 --memory 64KiB");
    for name in FIELDS {
        assert!(field(&run, name).is_some(), "no {name}");
    }
    assert_eq!((&run["width"], &run["height"], &run["nodes"]), (&40.into(), &30.into(), &1.into()));
    assert_eq!(run["rays"]["primary"], 40 * 30 * 2);
    assert!(run["rays"]["shadow"].as_u64().unwrap() > 1000);
    assert_eq!(run["memory"]["limit"], 65_536);
    assert!((1..=65_536).contains(&run["memory"]["peak"].as_u64().unwrap()));
    assert_eq!(run["options"]["seed"], 7);
    assert_eq!(run["image_hash"].as_str().unwrap().len(), 64);
    assert_eq!(folder.names(), ["cornell.png", "run.json"]);
}

#[test]
fn the_bits_depend_on_the_seed_and_not_on_the_machine() {
    let folder = Folder::new();
    let line = "sphereflake:2 --width 48 --height 40 --samples 2";
    let hash = folder.hash(line);
    for other in ["--threads 1", "--threads 3", "--memory 16KiB --block 1KiB", "--memory 1MiB"] {
        assert_eq!(folder.hash(&format!("{line} {other}")), hash, "{other}");
    }
    folder.run("compile sphereflake:2 --block 2KiB -o flake.kilo --quiet").done();
    let compiled = "flake.kilo --width 48 --height 40 --samples 2";
    assert_eq!(folder.hash(compiled), hash);
    assert_eq!(folder.hash(&format!("{compiled} --memory 20KiB")), hash);
    assert_ne!(folder.hash(&format!("{line} --seed 1")), hash);
    // The last one given wins.
    assert_eq!(folder.hash(&format!("{line} --seed 1 --seed 0 --width 9 --width 48")), hash);
}

#[test]
fn the_furnace_reads_one_half() {
    let folder = Folder::new();
    folder.run("render furnace:2 --width 32 -o f.exr --samples 16 --quiet").done();
    let (width, pixels) = pixels(&folder.path().join("f.exr"));
    // Whole pixels beside the ball are 1, on it 1/2 but for the noise of the samples.
    assert_eq!(pixels[0], [1.0; 3]);
    let middle: Vec<_> = (14..18).flat_map(|y| (14..18).map(move |x| y * width + x)).collect();
    let mean = middle.iter().map(|&i| f64::from(pixels[i][1])).sum::<f64>() / 16.0;
    assert!((mean - 0.5).abs() < 0.01, "{mean}");
}

#[test]
fn every_kind_of_picture_shows_the_same() {
    let folder = Folder::new();
    let line = "cornell --width 24 --samples 4 --quiet --exposure 2";
    for name in ["a.exr", "a.hdr", "a.png", "b.png"] {
        folder.run(&format!("render {line} -o {name}")).done();
    }
    // RGBE has a step of 1/128 at worst, truncated and read as its middle; dark channels lose most.
    let out = folder.run("compare a.exr a.hdr --json -").done().out();
    let measures: Value = serde_json::from_str(&out).unwrap();
    assert!((measures["measures"]["all"]["mean_ratio"].as_f64().unwrap() - 1.0).abs() < 1e-2);
    assert_eq!(
        fs::read(folder.path().join("a.png")).unwrap(),
        fs::read(folder.path().join("b.png")).unwrap()
    );
    folder.run("compare a.png b.png --fail-above 0 --quiet").done();
}

#[test]
fn the_exposure_is_told_of_whatever_picture_has_one() {
    let folder = Folder::new();
    for command in ["render", "sim --nodes 2 --no-baseline"] {
        let exposure = |output: &str| {
            let line = format!("{command} cornell --width 8 --samples 1 {output}");
            folder.counted(&line)["options"]["exposure"].clone()
        };
        let png = exposure("-o a.png");
        assert!(png.is_number(), "{command}: {png}");
        assert_eq!(exposure("-o a.exr --report page"), png, "{command}");
        assert!(exposure("-o a.exr").is_null(), "{command}");
        let told = folder
            .run(&format!("{command} cornell --width 8 --samples 1 -o a.exr --report page"))
            .done();
        assert!(!told.out().contains("exposure"), "{command}: {}", told.out());
    }
}

#[test]
fn views_are_chosen_and_fitted() {
    let folder = Folder::new();
    let first = folder.hash("cornell --width 20 --samples 1");
    for view in ["--view default", "--view 1", "--view 9 --view 1"] {
        assert_eq!(folder.hash(&format!("cornell --width 20 --samples 1 {view}")), first, "{view}");
    }
    // The same view from a file: the box is seen from 8 m before it.
    folder.file("same.vf", "rvu -vtv -vp -2.78 -8 2.73 -vd 0 1 0 -vu 0 0 1 -vh 39.3 -vv 39.3\n");
    assert_eq!(folder.hash("cornell same.vf --width 20 --samples 1"), first);
    assert_eq!(folder.hash("cornell --view same.vf --width 20 --samples 1"), first);
    folder.run("compile cornell --block 4KiB -o c.kilo --quiet").done();
    assert_eq!(folder.hash("c.kilo --view same.vf --width 20 --samples 1"), first);
    let wide = folder.render("cornell --width 40 --height 20 --samples 1");
    assert_eq!((&wide["width"], &wide["height"]), (&40.into(), &20.into()));
    // What a file holds beside options of a view is said, however it is named.
    folder.file("more.vf", "rvu -vtv -vp -2.78 -8 2.73 -vd 0 1 0 -x 800\n");
    for line in ["render cornell more.vf", "render cornell --view more.vf"] {
        let ran = folder.run(&format!("{line} --width 20 --samples 1")).done();
        let message = ran.err();
        assert!(message.starts_with("note: more.vf:1: an option that is no view"), "{message}");
    }
    for typed in ["-vp 1 2 3 -vd 0 1 0 -foo", "-vp 3 4 5 -vd 0 1 0 foo"] {
        let ran = folder.command().args(["render", "cornell", "--view", typed]).output().unwrap();
        let message = String::from_utf8_lossy(&ran.stderr);
        assert_eq!(ran.status.code(), Some(2), "{message}");
        assert!(message.contains("foo` is not a view option; there are -vtv"), "{message}");
    }
    folder.file("bad.vf", "rvu -vp 1 2\n");
    folder.run("render cornell --view bad.vf").refused(1, &["bad.vf"]);
    folder.run("render cornell same.vf --view nobody").refused(2, &["nobody", "same", "default"]);
}

#[test]
fn a_report_is_a_page() {
    let folder = Folder::new();
    let line = "render cornell --width 16 --samples 1 --memory 64KiB --report out/page";
    assert!(folder.run(line).done().out().contains("index.html"));
    let page = fs::read_to_string(folder.path().join("out/page/index.html")).unwrap();
    for part in ["data:image/png;base64,", "shadow", "block frames", "cornell"] {
        assert!(page.contains(part), "no {part}");
    }
    assert_eq!(json(&folder.path().join("out/page/report.json"))["width"], 16);
    assert_eq!(fs::read_dir(folder.path().join("out/page")).unwrap().count(), 3);
}

#[test]
fn a_memory_that_is_too_small_is_refused_with_what_is_needed() {
    let folder = Folder::new();
    folder
        .run("render cornell --memory 1KiB")
        .refused(1, &["--memory 1KiB: ", "at least", "block frames", "--block"]);
    folder.run("plan cornell --memory 1KiB").refused(1, &["at least"]);
    let plan = folder.run("plan cornell --memory 64KiB").done().out();
    assert!(plan.contains("block frames") && plan.contains("65536"), "{plan}");
    let out = folder.run("plan cornell --memory 64KiB --json -").done().out();
    let plan: Value = serde_json::from_str(&out).unwrap();
    let lines = plan["lines"].as_array().unwrap();
    let sum: u64 = lines.iter().map(|line| line["bytes"].as_u64().unwrap()).sum();
    assert_eq!(plan["total"], sum);
    assert!(folder.names().is_empty(), "something is left behind");
}

#[test]
fn quiet_says_nothing_and_a_pipe_sees_no_bar() {
    let folder = Folder::new();
    let ran = folder.run("render cornell --width 9 --samples 1 --quiet").done();
    assert_eq!((ran.out(), ran.err()), (String::new(), String::new()));
    let ran = folder.run("render cornell --width 9 --samples 1").done();
    assert_eq!(ran.err(), "");
    assert!(ran.out().contains("cornell.png") && ran.out().contains("rays"), "{}", ran.out());
}

#[test]
fn bad_files_are_refused_by_name_and_line() {
    let folder = Folder::new();
    folder.file("nan.obj", "v 0 0 0\nv nan 1 0\nv 0 1 inf\nf 1 2 3\n");
    folder.file("short.rad", "void polygon a 0 0 9 0 0 0 1 0 0\n");
    folder.file("random.kilo", (0..9999).map(|i: u32| (i * 31 % 251) as u8).collect::<Vec<_>>());
    folder.file("model.glb", [0; 64]);
    folder.file("run.rad", "!rm -rf nothing\n");
    fs::create_dir(folder.path().join("folder.kilo")).unwrap();
    let before = folder.names();
    for (name, part) in [
        ("nan.obj", "nan.obj:2"),
        ("short.rad", "short.rad:"),
        ("random.kilo", "random.kilo"),
        ("model.glb", ".rad"),
        ("run.rad", "run.rad:1"),
        ("missing.rad", "no such file"),
        ("no/such/thing", "thing"),
        (".", "."),
        ("folder.kilo", "folder.kilo: is a directory"),
    ] {
        folder.run(&format!("render {name} -o out.png")).refused(1, &[part]);
    }
    assert_eq!(folder.names(), before, "something is left behind");
}

#[test]
fn more_lights_than_allowed_are_refused_with_the_number() {
    let folder = Folder::new();
    let refused = folder.run("compile conference --lights 23 -o rooms.kilo");
    refused.refused(1, &["24 lights", "at most 23", "--lights 24"]);
    assert_eq!(folder.names(), [""; 0]);
    assert_eq!(folder.run("compile conference --lights 24").code(), Some(0));
}

#[test]
fn files_are_sought_beside_the_one_that_names_them_then_here() {
    let folder = Folder::new();
    let spheres = |n: usize| "m sphere s 0 0 4 0 0 0 1\n".repeat(n);
    fs::create_dir(folder.path().join("rooms")).unwrap();
    folder.file("rooms/room.rad", "void plastic m 0 0 5 .5 .5 .5 0 0\n!xform lib/ball.rad\n");
    let small = "render rooms/room.rad --width 8 --samples 1";
    folder.run(small).refused(1, &["rooms/lib/ball.rad: no such file", "room.rad:2"]);
    fs::create_dir(folder.path().join("lib")).unwrap();
    folder.file("lib/ball.rad", spheres(1));
    assert_eq!(folder.counted(small)["surfaces"], 1);
    fs::create_dir(folder.path().join("rooms/lib")).unwrap();
    folder.file("rooms/lib/ball.rad", spheres(2));
    assert_eq!(folder.counted(small)["surfaces"], 2, "the nearer one counts");
}

#[test]
fn what_was_ignored_is_said_before_the_error() {
    let folder = Folder::new();
    folder.file("empty.rad", "");
    folder.file("void.rad", "void sphere s 0 0 4 0 0 0 1\n");
    folder.file("sky.rad", "void light l 0 0 3 1 1 1\nl source s 0 0 4 0 0 1 90\n");
    for (names, note, error) in [
        ("empty.rad", "the file is empty", "nothing to render"),
        ("void.rad", "void.rad:1: a surface whose modifier is void", "nothing to render"),
        ("void.rad sky.rad", "void.rad:1: a surface whose modifier is void", "no view"),
    ] {
        for command in ["render", "sim"] {
            let ran = folder.run(&format!("{command} {names}"));
            let message = ran.err();
            let [first, last] = message.lines().collect::<Vec<_>>()[..] else {
                panic!("{message}")
            };
            assert_eq!(ran.code(), Some(1), "{message}");
            assert!(first.starts_with("note: ") && first.contains(note), "{message}");
            assert!(last.starts_with("error: ") && last.contains(error), "{message}");
            folder.run(&format!("{command} {names} --quiet")).refused(1, &[error]);
        }
    }
}

#[test]
fn a_sky_alone_is_a_scene() {
    let folder = Folder::new();
    folder.file("sky.rad", "void light l 0 0 3 1 1 1\nl source s 0 0 4 0 0 1 90\n");
    folder.file("up.vf", "rvu -vtv -vp 0 -5 0 -vd 0 1 .5 -vu 0 0 1 -vh 40 -vv 40\n");
    let picture = "sky.rad up.vf --width 12 --samples 1";
    let expected = folder.counted(&format!("render {picture}"))["image_hash"].clone();
    for command in ["render --memory 64KiB", "sim --nodes 4", "host --nodes 2"] {
        let run = folder.counted(&format!("{command} {picture}"));
        assert_eq!(run["image_hash"], expected, "{command}");
    }
}

#[test]
fn what_is_too_small_beside_the_rest_is_said() {
    let folder = Folder::new();
    let scene = "void plastic w 0 0 5 .5 .5 .5 0 0\nw sphere far 0 0 4 0 0 0 1e9\n\
                 w polygon p 0 0 9 5e8 0 0 500000000.1 0 0 5e8 .1 0\n";
    folder.file("far.rad", scene);
    let message = folder.run("render far.rad --width 8 --samples 1").done().err();
    assert!(message.contains("left out (1 time)"), "{message}");
}

#[test]
fn pixels_may_be_left_out() {
    let folder = Folder::new();
    let picture = "render cornell --width 64 --samples 2";
    let whole = folder.counted(picture);
    assert_eq!(whole["skipped"]["pixels_interpolated"], 0);
    assert_eq!(whole["options"]["pixel_spacing"], 1);
    let some = folder.counted(&format!("{picture} --pixel-spacing 4"));
    let left_out = some["skipped"]["pixels_interpolated"].as_u64().unwrap();
    assert_eq!(some["rays"]["primary"].as_u64().unwrap() + 2 * left_out, 2 * 64 * 64);
    assert!(left_out > 500 && some["image_hash"] != whole["image_hash"], "{some}");
    assert_eq!(some["options"]["pixel_contrast"], 0.1);
    let small = folder.counted(&format!("{picture} --pixel-spacing 4 --memory 64KiB"));
    assert_eq!(small["image_hash"], some["image_hash"]);
    let more = folder.counted(&format!("{picture} --pixel-spacing 4 --pixel-contrast 0.01"));
    assert!(more["skipped"]["pixels_interpolated"].as_u64().unwrap() < left_out);
    let said = folder.run(&format!("{picture} --pixel-spacing 4 --report page")).done().out();
    assert!(said.contains("% of the pixels interpolated"), "{said}");
    let page = fs::read_to_string(folder.path().join("page/index.html")).unwrap();
    assert!(page.contains("pixels interpolated") && page.contains("squares of 4"), "{page}");
    for (option, parts) in [
        ("--pixel-spacing 3", ["--pixel-spacing", "power of two"]),
        ("--pixel-spacing 64", ["--pixel-spacing", "32"]),
        ("--pixel-spacing 4 --pixel-contrast -1", ["--pixel-contrast", "not negative"]),
        ("--pixel-contrast 0.2", ["required", "--pixel-spacing"]),
    ] {
        folder.run(&format!("{picture} {option}")).refused(2, &parts);
    }
}

#[test]
fn files_become_one_scene() {
    let folder = Folder::new();
    folder.file("paint.rad", "void plastic grey 0 0 5 .5 .5 .5 0 0\n");
    folder.file("floor.rad", "grey polygon floor 0 0 12 -5 -5 0 5 -5 0 5 5 0 -5 5 0\n");
    folder.file("lamp.rad", "void light shine 0 0 3 9 9 9\nshine sphere lamp 0 0 4 0 0 3 .5\n");
    let run = folder.render("paint.rad floor.rad lamp.rad --width 16 --samples 1");
    assert_eq!(run["surfaces"], 3);
    // Nothing lies between the floor and the lamp: no shadow ray need be traced.
    assert!(run["skipped"]["shadow_clear"].as_u64().unwrap() > 0);
    assert_eq!(folder.names().iter().filter(|name| name.ends_with(".png")).count(), 1);
    // Without a lamp there is a default one, and a word on it.
    let ran = folder.run("render paint.rad floor.rad --width 16 --samples 1").done();
    assert!(ran.err().lines().all(|line| line.starts_with("note: ")), "{}", ran.err());
    assert!(ran.err().contains("light") && ran.err().contains("view"), "{}", ran.err());
    folder.file("eye.vf", "rvu -vp 0 -9 3 -vd 0 3 -1\n");
    let line = "render paint.rad floor.rad lamp.rad --view eye.vf --width 16 --samples 1";
    assert_eq!(folder.run(line).done().err(), "");
}

#[test]
fn nothing_half_written_is_left() {
    let folder = Folder::new();
    folder.file("old.png", "as it was");
    folder.run("render cornell --memory 1KiB -o old.png").refused(1, &["--memory 1KiB: too small"]);
    folder.run("render cornell -o no/where.png").refused(1, &["no/where.png", "directory"]);
    fs::create_dir(folder.path().join("dir.png")).unwrap();
    folder.run("render cornell -o dir.png").refused(1, &["dir.png", "is a directory"]);
    assert_eq!(fs::read(folder.path().join("old.png")).unwrap(), b"as it was");
    assert_eq!(folder.names(), ["dir.png", "old.png"]);
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_told() {
    let folder = Folder::new();
    for name in ["full.png", "full.exr", "full.hdr"] {
        std::os::unix::fs::symlink("/dev/full", folder.path().join(name)).unwrap();
        folder
            .run(&format!("render cornell --width 9 --samples 1 -o {name}"))
            .refused(1, &[name, "full"]);
    }
}

#[cfg(unix)]
#[test]
fn an_interrupt_ends_it_and_leaves_nothing() {
    use std::{
        process::{Command, Stdio},
        time::{Duration, Instant},
    };
    let folder = Folder::new();
    folder.file("old.png", "as it was");
    let line =
        "render cornell --width 4000 --samples 4096 -o old.png --json run.json --report page";
    let mut child = folder.command().args(line.split(' ')).stderr(Stdio::piped()).spawn().unwrap();
    let begun = Instant::now();
    // Both files are begun once rendering starts.
    while folder.names().iter().filter(|name| name.ends_with(".part")).count() < 2 {
        assert!(begun.elapsed() < Duration::from_secs(60), "it does not begin");
        assert!(child.try_wait().unwrap().is_none(), "it ended early");
        std::thread::yield_now();
    }
    let status = Command::new("kill").args(["-INT", &child.id().to_string()]).status();
    assert!(status.unwrap().success());
    let ended = child.wait_with_output().unwrap();
    let message = String::from_utf8_lossy(&ended.stderr);
    assert_eq!(ended.status.code(), Some(1), "{message}");
    assert!(message.starts_with("error: interrupted") && message.lines().count() == 1, "{message}");
    assert_eq!(fs::read(folder.path().join("old.png")).unwrap(), b"as it was");
    assert!(!folder.names().iter().any(|name| name.ends_with(".part")), "{:?}", folder.names());
    assert!(!folder.path().join("page").exists(), "an empty directory is left");
}

/// A sun as a sphere, and a box beside which nothing else is small.
#[test]
fn what_a_far_surface_does_to_the_others_is_said() {
    let folder = Folder::new();
    let boxes = "void plastic W 0 0 5 .5 .5 .5 0 0\n!genbox W b .8 .8 .8 | xform -t .1 .3 .2\n\
                 void light S 0 0 3 1e4 1e4 1e4\n";
    folder.file("far.rad", format!("{boxes}S sphere sun 0 0 4 3e6 -3e6 1e7 5e4\n"));
    folder.file("near.rad", format!("{boxes}S source sun 0 0 4 3 -3 10 .5\n"));
    let small = "--width 8 --samples 1 --json run.json";
    for (name, is_told) in [("far", true), ("near", false)] {
        let told = folder.run(&format!("render {name}.rad {small}")).done().err();
        let run = json(&folder.path().join("run.json"));
        let error = run["position_error"].as_f64().unwrap();
        assert_eq!(error > 0.01, is_told, "{error}");
        for says in ["note: the scene reaches so far", "to 3.0e-1 only", "12 of 13 surfaces"] {
            assert_eq!(told.contains(says), is_told, "{told}");
        }
    }
}
