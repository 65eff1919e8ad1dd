//! `kiloray calibrate`, and what reads its profiles.

use serde_json::{Value, json};

use crate::support::{self, Folder};

const SIM: &str = "sim cornell --nodes 2 --width 16 --samples 1 --no-baseline -o a.png";

/// A machine on which each operation takes so long [ns].
fn profile(ns: f64) -> Value {
    let mut profile = json!({ "name": "even", "source": "made up", "together": true });
    for operation in [
        "node",
        "leaf",
        "block",
        "ray",
        "shadow_ray",
        "bundle_ray",
        "bundle_node",
        "bundle_box",
        "bundle_ray_box",
        "bundle_triangle",
        "bundle_ray_triangle",
        "shading",
        "light",
        "light_bundle",
        "light_sample",
        "clip",
        "message",
        "copy",
        "check",
    ] {
        profile[operation] = json!(ns);
    }
    profile
}

#[test]
fn a_machine_is_measured_and_its_profile_used() {
    let folder = Folder::new();
    let out = folder.run("calibrate -o mine.json --threads 1 --repeats 1 --quick").done().out();
    for part in ["cornell", "not used", "mine", "--profile mine.json"] {
        assert!(out.contains(part), "no '{part}' in: {out}");
    }
    let mine = support::json(&folder.path().join("mine.json"));
    assert_eq!(mine["name"], "mine");
    folder.run(&format!("{SIM} --profile mine.json --json run.json")).done();
    let run = support::json(&folder.path().join("run.json"));
    assert_eq!(run["options"]["profile"], "mine.json");
    assert_eq!(run["profile_source"], mine["source"]);
    assert!(run["virtual_time_s"].as_f64() > Some(0.0));
    assert_eq!(folder.names(), ["a.png", "mine.json", "run.json"]);
}

#[test]
fn virtual_time_is_that_of_the_profile() {
    let folder = Folder::new();
    // Links so quick that time is the nodes' alone.
    let time = |ns: f64| {
        folder.file("even.json", profile(ns).to_string());
        let links = "--link-latency 0ns --link-bandwidth 1000GB/s";
        folder.run(&format!("{SIM} --profile even.json {links} --json run.json --nodes 1")).done();
        support::json(&folder.path().join("run.json"))["virtual_time_s"].as_f64().expect("a time")
    };
    let ratio = time(2000.0) / time(1000.0);
    assert!((ratio - 2.0).abs() < 0.01, "{ratio}");

    let axes = "--over profile=pc,even.json -o table --width 16 --samples 1 --nodes 2 --quiet";
    folder.run(&format!("sweep cornell {axes}")).done();
    let table = std::fs::read_to_string(folder.path().join("table/sweep.csv")).expect("a table");
    assert!(table.contains("even.json") && table.lines().count() == 3, "{table}");
}

#[test]
fn a_name_of_a_profile_writes_nothing_but_letters_to_a_terminal() {
    let folder = Folder::new();
    let mut named = profile(1000.0);
    named["name"] = json!("red\u{1b}[31m\nnodes");
    folder.file("named.json", named.to_string());
    let out = folder.run(&format!("{SIM} --profile named.json")).done().out();
    assert!(out.contains("profile red [31m nodes,"), "{out}");
    assert!(!out.contains(|c: char| c.is_control() && c != '\n'), "{out:?}");
}

#[test]
fn files_that_are_no_profiles_are_refused_by_name() {
    let folder = Folder::new();
    let with = |field: &str, value: Value| {
        let mut profile = profile(100.0);
        profile[field] = value;
        profile.to_string()
    };
    for (text, code, part) in [
        (String::new(), 1, "calibrate"),
        ("{}".into(), 1, "name"),
        (with("node", json!("fast")), 1, "expected f64"),
        (with("knoten", json!(1.0)), 1, "knoten"),
        (with("leaf", json!(-1.0)), 2, "up to four triangles"),
        (with("clip", json!(1e300)), 2, "clipping"),
        (profile(0.0).to_string(), 2, "a ray"),
    ] {
        folder.file("wrong.json", text);
        folder.run(&format!("{SIM} --profile wrong.json")).refused(code, &[part]);
    }
    folder.run(&format!("{SIM} --profile none.json")).refused(1, &["none.json", "no such file"]);
    folder.run("calibrate -o none/mine.json").refused(1, &["none"]);
    folder.run("calibrate -o mine.txt").refused(2, &[".json"]);
    assert_eq!(folder.names(), ["wrong.json"]);
}
