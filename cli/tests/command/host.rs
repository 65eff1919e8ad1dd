//! `kiloray host`: the same picture from processes, and what becomes of them.

use std::{
    fs,
    process::{Child, Stdio},
    time::Instant,
};

use serde_json::Value;

use crate::support::{FIELDS, Folder, field, is_gone, signal, until, worked};

/// Small, and quick.
const SMALL: &str = "glass --width 32 --height 24 --samples 1 --seed 3";
/// More than there is time for.
const LONG: &str = "host glass --width 400 --samples 4096 --nodes 3 -o long.png";

#[test]
fn processes_give_the_bits_of_one_node() {
    let folder = Folder::new();
    let expected = folder.counted(&format!("render {SMALL}"))["image_hash"].clone();
    for mesh in [
        "--nodes 3 --memory 64KiB --block 1KiB",
        "--topology ring --nodes 4 --schedule data",
        "--nodes 1",
    ] {
        let run = folder.counted(&format!("host {SMALL} {mesh}"));
        assert_eq!((&run["image_hash"], &run["complete"]), (&expected, &true.into()), "{mesh}");
        for name in FIELDS {
            assert!(field(&run, name).is_some(), "no {name}");
        }
        assert_eq!(run["faults"]["replaced"].as_array().map(Vec::len), Some(0), "{mesh}");
        let waits = &run["latencies"];
        // Word of the last tiles may not have left when the picture was there.
        let [tiles, given] = [&waits["tile"]["count"], &run["tiles"]["given"]].map(Value::as_u64);
        let nodes = run["nodes"].as_u64();
        assert!(tiles <= given && tiles.zip(nodes).map(|(t, n)| t + n) >= given, "{mesh}: {waits}");
        // The last blocks may have come after the picture was there.
        let fetched = run["blocks"]["fetched"].as_u64();
        assert!(waits["fetch"]["count"].as_u64() >= fetched, "{mesh}: {fetched:?}, {waits}");
        assert_eq!(
            run["per_node"].as_array().map(Vec::len),
            run["nodes"].as_u64().map(|n| n as usize)
        );
    }
    assert_eq!(folder.names(), ["glass.png", "run.json"]);
}

#[test]
fn sixty_four_processes_give_the_bits_of_one_node_and_leave_nothing() {
    let folder = Folder::new();
    let picture = "cornell --width 16 --height 16 --samples 1";
    let expected = folder.counted(&format!("render {picture}"))["image_hash"].clone();
    let mut command = folder.command();
    let line = format!("host {picture} --nodes 64 --json run.json -o cornell.png");
    command.args(line.split(' ')).stderr(Stdio::piped()).env("TMPDIR", folder.path());
    let host = command.spawn().expect("it starts");
    let nodes = nodes_of(&host, 64);
    let output = host.wait_with_output().expect("it ends");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    until(|| nodes.iter().all(|node| is_gone(*node)));
    assert_eq!(folder.names(), ["cornell.png", "run.json"]);
    let run = fs::read_to_string(folder.path().join("run.json")).expect("it is written");
    let run: serde_json::Value = serde_json::from_str(&run).expect("it is JSON");
    assert_eq!((&run["image_hash"], &run["nodes"]), (&expected, &64.into()));
}

#[test]
fn a_report_has_a_page_and_the_time_of_all_nodes_is_told() {
    let folder = Folder::new();
    let run = folder.counted(&format!("host {SMALL} --nodes 2 --report report"));
    // Nodes are there before the first pixel and after the last: of few pixels that is most of the time.
    let few = folder.counted("host glass --width 4 --height 4 --samples 1 --nodes 2 -o few.png");
    for run in [&run, &few] {
        let part = |name: &str| run["lost"][name].as_f64().expect(name);
        let lost: f64 =
            ["data", "answers", "credit", "imbalance", "messages", "absent"].map(part).iter().sum();
        assert!((0.0..1.0).contains(&lost), "{lost}");
    }
    assert_eq!(run["tiles"]["given_again"], 0);
    assert_eq!(run["memory"]["lines"][0]["line"].as_str(), Some("intersection points"));
    let page = fs::read_to_string(folder.path().join("report/index.html")).expect("it is there");
    for words in ["Where the time of the nodes went", "glass on 2 processes", "data:image/png"] {
        assert!(page.contains(words), "{words}");
    }
    assert!(folder.path().join("report/picture.png").exists());
    assert!(folder.path().join("report/report.json").exists());
    let told = folder.run(&format!("host {SMALL} --nodes 2 --report report -o glass.exr")).done();
    assert!(told.out().contains("\nreport     report/index.html\n"), "{}", told.out());
    let line = "cornell --width 8 --samples 1 --nodes 2 -o cornell.exr --report report";
    assert!(folder.counted(&format!("host {line}"))["options"]["exposure"].is_number());
}

#[test]
fn what_cannot_be_is_said_in_one_line() {
    let folder = Folder::new();
    folder.run("host cornell --nodes 2 --threads 2").refused(2, &["--threads", "--nodes"]);
    folder
        .run("host cornell --nodes 7 --topology torus:2x4")
        .refused(2, &["--topology", "7 nodes"]);
    for mesh in ["--nodes 257", "--topology torus:32x32", "--nodes 32768 --memory 64KiB"] {
        let words = ["at most 256 processes", "kiloray sim", "--config"];
        folder.run(&format!("host cornell {mesh}")).refused(2, &words);
    }
    folder.run("host cornell --nodes 2 --memory 4KiB").refused(1, &["--memory", "at least"]);
    folder.run("host cornell --nodes 2 --profile pc").refused(2, &["--profile"]);
    folder.run("node --config mesh.toml --node 0").refused(1, &["mesh.toml"]);
    folder.file("mesh.toml", "name = 'a mesh'");
    folder.run("node --config mesh.toml --node 0").refused(1, &["mesh.toml", "missing field"]);
}

#[test]
fn an_interrupt_keeps_what_is_rendered() {
    let folder = Folder::new();
    let mut command = folder.command();
    let line = "host glass --width 1000 --samples 16 --nodes 3 -o long.png --report page --quiet";
    command.args(line.split(' ')).stderr(Stdio::piped());
    let host = command.spawn().expect("it starts");
    let nodes = nodes_of(&host, 3);
    // Some tiles are there then.
    until(|| nodes.iter().all(|node| worked(*node) > 100));
    let begin = Instant::now();
    signal("-INT", host.id());
    let output = host.wait_with_output().expect("it ends");
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(1), "{message}");
    assert!(
        message.contains("interrupted; what was rendered is in long.incomplete.png"),
        "{message}"
    );
    assert_eq!(folder.names(), ["long.incomplete.png", "page"]);
    let page = |name: &str| folder.path().join("page").join(name).exists();
    assert!(page("index.html") && page("picture.incomplete.png") && !page("picture.png"));
    assert!(nodes.iter().all(|node| is_gone(*node)), "after {:?}", begin.elapsed());
}

#[test]
fn nodes_end_with_their_host() {
    let folder = Folder::new();
    let mut command = folder.command();
    command.args(LONG.split(' ')).stderr(Stdio::null()).env("TMPDIR", folder.path());
    let mut host = command.spawn().expect("it starts");
    let nodes = nodes_of(&host, 3);
    // One that is frozen, though it has long begun, ends too.
    let threads = || fs::read_dir(format!("/proc/{}/task", nodes[0])).map_or(0, Iterator::count);
    // That of interrupts comes first, then the one that waits for the end of the host.
    until(|| threads() > 2);
    signal("-STOP", nodes[0]);
    host.kill().expect("it is killed");
    host.wait().expect("it is dead");
    until(|| nodes.iter().all(|node| is_gone(*node)));
    // The directory of the nodes is gone too; the picture's file is that of a command that was killed.
    let left = folder.names();
    assert!(!left.iter().any(|name| name.starts_with("kiloray-nodes-")), "{left:?}");
}

/// The processes of a host's nodes, as soon as there are so many.
pub(crate) fn nodes_of(host: &Child, count: usize) -> Vec<u32> {
    let mut all = Vec::new();
    until(|| {
        let path = format!("/proc/{0}/task", host.id());
        let threads = fs::read_dir(path).into_iter().flatten().flatten();
        all = threads
            .filter_map(|thread| fs::read_to_string(thread.path().join("children")).ok())
            .flat_map(|text| {
                text.split_whitespace().filter_map(|n| n.parse().ok()).collect::<Vec<u32>>()
            })
            .collect();
        all.len() == count
    });
    all
}
