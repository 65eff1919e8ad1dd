//! `kiloray sim`.

use serde_json::Value;

use crate::support::{FIELDS, Folder, field, json};

/// Small, and quick.
const SMALL: &str = "--width 24 --height 24 --samples 1";

impl Folder {
    fn sim(&self, line: &str) -> Value {
        self.run(&format!("sim {line} --quiet --json sim.json")).done();
        json(&self.path().join("sim.json"))
    }
}

#[test]
fn a_mesh_gives_the_bits_of_one_node() {
    let folder = Folder::new();
    let picture = "glass --width 32 --height 24 --samples 1 --seed 3";
    folder.run(&format!("render {picture} --quiet --json render.json")).done();
    let hash = json(&folder.path().join("render.json"))["image_hash"].clone();
    for mesh in [
        "--nodes 4 --topology ring --shadow offer --points owner --no-baseline",
        "--topology mesh:3x2 --memory 64KiB --schedule data --points finder --no-baseline",
        "--topology torus:2x2x2 --schedule demand --placement round-robin --no-baseline",
        "--nodes 8 --topology tree --loss 1/50 --duplicate 1% --jitter 2us --no-baseline",
        "--nodes 9 --crash 4@300us --block-replicas 2 --slow 1:3 --no-baseline",
        "--nodes 6 --topology mesh:3x2 --group 3 --shadow steal --task-order made --owned-in-arena --no-baseline",
        "--nodes 4 --topology full --top 2 --prefetch 0 --task-order made --tile 5 --packet 512B --no-baseline",
    ] {
        let run = folder.sim(&format!("{picture} {mesh}"));
        assert_eq!(run["image_hash"], hash, "{mesh}");
        assert_eq!(run["complete"], true, "{mesh}");
        assert!(run["memory"]["peak"].as_u64() <= run["memory"]["limit"].as_u64(), "{mesh}");
    }
}

#[test]
fn the_json_has_what_scripts_rely_on() {
    let folder = Folder::new();
    let line = format!("cornell {SMALL} --nodes 6 --topology mesh:3x2 --memory 64KiB --loss 0.01");
    let run = folder.sim(&line);
    let more = [
        "options.topology",
        "options.loss",
        "lost.data",
        "lost.imbalance",
        "lost.repeated",
        "faults.lost",
    ];
    for name in FIELDS.into_iter().chain(more) {
        assert!(field(&run, name).is_some_and(|value| !value.is_null()), "no {name}");
    }
    assert_eq!((&run["nodes"], &run["memory"]["limit"]), (&6.into(), &65_536.into()));
    // A tile may be given out twice: then there are more rays, and the same picture.
    assert!(run["rays"]["primary"].as_u64().unwrap() >= 24 * 24);
    assert_eq!(run["tiles"]["pixels"], 24 * 24);
    let efficiency = run["efficiency"].as_f64().unwrap();
    let lost: f64 = run["lost"].as_object().unwrap().values().map(|x| x.as_f64().unwrap()).sum();
    assert!(efficiency > 0.0 && efficiency < 1.2, "{efficiency}");
    assert!((efficiency + lost - 1.0).abs() < 1e-6, "{efficiency} and {lost}");
    assert_eq!(folder.names(), ["cornell.png", "sim.json"]);
    // The same command, the same run, one after the other or both at once: all but the wall clock.
    let mut runs = [run, folder.sim(&format!("{line} --threads 1"))];
    runs[1]["options"]["threads"] = Value::Null;
    for run in &mut runs {
        let fields = run.as_object_mut().unwrap();
        assert!(fields.remove("time_s").is_some() && fields.remove("mesh_s").is_some());
    }
    assert_eq!(runs[0], runs[1]);
}

#[test]
fn faults_have_a_seed_of_their_own() {
    let folder = Folder::new();
    let run = |seeds: &str| {
        let faults = "--nodes 4 --topology ring --memory 64KiB --loss 1/20 --no-baseline";
        let run = folder.sim(&format!("cornell {SMALL} {faults} {seeds}"));
        let text = |name: &str| run[name].as_str().unwrap().to_owned();
        (text("image_hash"), text("fingerprint"), run["options"]["fault_seed"].as_u64().unwrap())
    };
    // Where nothing is said it is the picture's.
    let (picture, events, seed) = run("--seed 7");
    assert_eq!(seed, 7);
    assert_eq!(run("--seed 7 --fault-seed 7"), (picture.clone(), events.clone(), 7));
    // With another one others are lost, of the same picture.
    let other = run("--seed 7 --fault-seed 18446744073709551615");
    assert_eq!((&other.0, other.2), (&picture, u64::MAX));
    assert_ne!(other.1, events);
    assert_ne!(run("--fault-seed 7").0, picture);
    let line = format!("sim cornell {SMALL} --nodes 2 --no-baseline --seed 1 --fault-seed");
    let told = folder.run(&format!("{line} 2")).done().out();
    assert!(told.contains("seed 1, of faults 2"), "{told}");
}

#[test]
fn a_person_is_told_what_it_cost() {
    let folder = Folder::new();
    let told = folder
        .run(&format!("sim cornell {SMALL} --nodes 4 --loss 1/20 --trace t.json"))
        .done()
        .out();
    for part in [
        "cornell.png",
        "torus:2x2",
        "virtual time",
        "efficiency",
        "memory",
        "packets lost",
        "seed 0",
    ] {
        assert!(told.contains(part), "no '{part}' in: {told}");
    }
    let few = folder.run(&format!("sim cornell {SMALL} --nodes 4 --no-baseline --slow 1:3")).done();
    assert!(few.out().contains("faults     1 slow node, "), "{}", few.out());
    let trace = json(&folder.path().join("t.json"));
    let events = trace["traceEvents"].as_array().unwrap();
    let slices: Vec<_> = events.iter().filter(|event| event["ph"] == "X").collect();
    assert!(slices.len() > 10);
    assert!((0..4).all(|node| slices.iter().any(|slice| slice["tid"] == node)));
    let quiet = folder.run(&format!("sim cornell {SMALL} --nodes 4 --no-baseline -q")).done();
    assert_eq!((quiet.out(), quiet.err()), (String::new(), String::new()));
}

#[test]
fn a_crash_behind_the_end_is_said_not_to_have_been() {
    let folder = Folder::new();
    let line = format!("cornell {SMALL} --nodes 4 --no-baseline --block-replicas 4");
    let told = |line: &str| folder.run(line).done().err();
    let late = told(&format!("sim {line} --crash 3@1us,2@10s"));
    assert!(late.starts_with("note: node 2 did not crash: the run was over at "), "{late}");
    let both = told(&format!("sim {line} --crash 3@9s,2@10s"));
    assert!(both.starts_with("note: nodes 3 and 2 did not crash"), "{both}");
    let twice = told(&format!("sim {line} --crash 3@9s,2@10s,3@10s"));
    assert!(twice.starts_with("note: nodes 3 and 2 did not crash"), "{twice}");
    for crash in ["--crash 3@1us", "--crash 2@10s --quiet"] {
        assert_eq!(told(&format!("sim {line} {crash}")), "", "{crash}");
    }
    let sweep = told(&format!("sweep {line} --over crash=2@1us,2@9s,3@9s"));
    let starts = "note: in the first of 2 points node 2 did not crash";
    assert!(sweep.starts_with(starts) && sweep.lines().count() == 1, "{sweep}");
}

#[test]
fn a_block_that_is_lost_ends_the_run_and_leaves_what_there_is() {
    let folder = Folder::new();
    // The top of the tree is nowhere else but at its owners, and all but one of them die at once.
    let line = "sim sinc:60 --width 48 --height 48 --samples 4 --nodes 4 --top 0 --crash 1@300us,2@300us,3@300us --json run.json --report page";
    folder.run(line).refused(1, &["block", "lost", "sinc-60.incomplete.png"]);
    let run = json(&folder.path().join("run.json"));
    assert_eq!((&run["complete"], &run["efficiency"]), (&false.into(), &Value::Null));
    assert!(run["lost_block"].is_u64());
    assert!(run["tiles"]["pixels"].as_u64().unwrap() < 48 * 48);
    assert_eq!(folder.names(), ["page", "run.json", "sinc-60.incomplete.png"]);
    let page = |name: &str| folder.path().join("page").join(name).exists();
    assert!(page("index.html") && page("picture.incomplete.png") && !page("picture.png"));
}

#[test]
fn heavy_faults_of_links_are_noted_before_the_run() {
    let folder = Folder::new();
    let line = "sim cornell --width 8 --height 8 --samples 1 --nodes 2 --no-baseline";
    let told = |faults: &str| folder.run(&format!("{line} {faults}")).done().err();
    let heavy = told("--loss 0.3 --jitter 1ms");
    assert!(heavy.starts_with("note: ") && heavy.contains("--loss and --jitter"), "{heavy}");
    assert_eq!(heavy.lines().count(), 1, "{heavy}");
    for light in [
        "--jitter 1us --link-latency 0ns",
        "--loss 0.1",
        "--loss 0.2 --jitter 50us",
        "--loss 0.3 --quiet",
    ] {
        assert_eq!(told(light), "", "{light}");
    }
}

#[cfg(unix)]
#[test]
fn an_interrupt_leaves_what_is_rendered() {
    let folder = Folder::new();
    let line = "sim sinc:60 --width 2000 --height 2000 --samples 64 --nodes 4 --no-baseline --json run.json";
    let mut child = folder
        .command()
        .args(line.split(' '))
        .stdout(std::process::Stdio::null())
        .stderr(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    // The picture's file is begun when the command can be interrupted.
    while !folder.names().iter().any(|name| name.ends_with(".part")) {
        assert!(child.try_wait().unwrap().is_none(), "it ended");
        std::thread::yield_now();
    }
    // Two that come together are one wish: a terminal and `timeout` both send theirs.
    let both = format!("kill -INT {0}; kill -TERM {0}", child.id());
    std::process::Command::new("sh").args(["-c", &both]).status().unwrap();
    let ended = child.wait_with_output().unwrap();
    let told = String::from_utf8_lossy(&ended.stderr);
    assert_eq!(ended.status.code(), Some(1), "{told}");
    assert!(told.contains("interrupted") && told.contains("sinc-60.incomplete.png"), "{told}");
    assert_eq!(json(&folder.path().join("run.json"))["complete"], false);
    assert_eq!(folder.names(), ["run.json", "sinc-60.incomplete.png"]);
}

#[test]
fn senseless_meshes_are_refused_in_one_line() {
    let folder = Folder::new();
    for (line, part) in [
        ("--nodes 0", "1 to 32768"),
        ("--nodes 63 --topology torus:8x8", "64 nodes, not 63"),
        ("--topology star", "hypercube"),
        ("--topology hypercube --nodes 12", "power of two"),
        ("--profile z80", "t800"),
        ("--profile z80", "calibrate"),
        ("--schedule fast", "demand"),
        ("--placement anywhere", "round-robin"),
        ("--loss 2", "between 0 and 1"),
        ("--fault-seed -1", "a whole number from 0"),
        ("--loss 1 --nodes 2", "lost"),
        ("--crash 5", "5@2ms"),
        ("--crash 5@2", "ns, us, ms or s"),
        ("--crash 99@1ms --nodes 4", "0 to 3"),
        ("--crash 0@1us --crash 1@1us --nodes 2", "nobody is left"),
        ("--slow 1:0", "5:10"),
        ("--slow 1:2,1:3 --nodes 2", "two factors"),
        ("--block-replicas 9 --nodes 4", "at most 4"),
        ("--packet 128B", "280B to 16408B"),
        ("--packet 16409B", "280B to 16408B"),
        ("--packet 279B", "280B"),
        ("--packet 400B --block 64KiB", "--packet 400B: blocks of 64KiB need at least 600B"),
        ("--packet 64KiB", "16408B"),
        ("--link-bandwidth fast", "1GB/s"),
        ("--link-latency 1000000s", "0 to 10s"),
        ("--jitter 11s", "0 to 10s"),
        ("--link-latency 1", "1us"),
        ("--prefetch some", "all"),
        ("--shadow give", "keep, offer, steal"),
        ("--points master", "finder, owner"),
        ("--tile 0", "1 to 256"),
        ("-o out.jpg", ".png, .hdr or .exr"),
    ] {
        folder.run(&format!("sim cornell {SMALL} {line}")).refused(2, &[part]);
    }
    for (line, part) in [
        ("--memory 1KiB", "needed"),
        ("--memory 64KiB --packet 16KiB", "messages"),
        ("--memory 64KiB --packet 16KiB", "give more, or smaller packets with --packet"),
        ("--memory 4KiB --topology full", "give more, or a --topology with fewer links"),
        ("--memory 4KiB --packet 280B", "give more, or a --topology with fewer links"),
        ("--trace nowhere/t.json", "nowhere"),
    ] {
        folder.run(&format!("sim cornell {SMALL} --nodes 4 {line}")).refused(1, &[part]);
    }
    folder.run("sim sinc:300 --owned-in-arena --nodes 4 --memory 64KiB").refused(1, &["tables"]);
    let blocks = "give more, or smaller blocks with --block";
    folder
        .run("sim sinc:60 --nodes 16 --topology full --memory 16KiB --block 4KiB")
        .refused(1, &[blocks]);
    assert!(folder.names().is_empty(), "something is left behind: {:?}", folder.names());
}
