use clap::Parser;
use kiloray_core::network::{NodeId, Topology};
use kiloray_sim::{NodeTime, Outcome};

use super::*;
use crate::{args::Command, picture::Picture};

fn topology(text: &str, nodes: u32) -> Topology {
    Topology::parse(text, nodes).unwrap()
}

/// A page and JSON of a report made by hand, by a command line.
pub(super) fn with_run<T>(line: &str, end: End, what: impl FnOnce(&Run<'_>) -> T) -> T {
    let words = ["kiloray", "sim", "cornell", "--width=4", "--height=4"];
    let words = words.into_iter().chain(line.split_whitespace());
    let command = args::Arguments::try_parse_from(words).unwrap().command;
    let Some(Command::Sim(sim)) = command else { panic!("not sim") };
    let scene = load(&sim, true).unwrap();
    let options = options(&sim, &scene).unwrap();
    let report = fixture::report(&options.mesh.topology);
    let picture = Picture { width: 4, height: 4, pixels: vec![[0.5; 3]; 16] };
    let outcome = Outcome { picture, end, overflows: 0, division: options.mesh, report };
    let time = NodeTime { trace: 2_000_000, ..NodeTime::default() };
    let done = Done {
        outcome,
        image_hash: "00".into(),
        baseline: Some(Baseline { virtual_ns: 2_000_000, time }),
        mesh_s: 1.0,
        all_s: 1.5,
    };
    what(&Run::new(&sim, &scene, &options, &done, Some(1.0)))
}

#[test]
fn what_is_lost_and_efficiency_make_one() {
    with_run("--nodes 16", End::Complete, |run| {
        let efficiency = run.done.efficiency().unwrap();
        assert!((efficiency - 2.0 / 16.0).abs() < 1e-12, "{efficiency}");
        let report = &run.done.outcome.report;
        let losses = lost::lost(report, run.done.baseline.as_ref());
        let sum: f64 = losses.iter().map(|loss| loss.part).sum();
        assert!((sum + efficiency - 1.0).abs() < 1e-12, "{sum}");
        // Node i of n works i / n of the time: (n - 1) / 2n is spent at work, a tenth of it on messages.
        let of = |name: &str| losses.iter().find(|loss| loss.name == name).unwrap().part;
        assert!((of("data") - 17.0 / 32.0).abs() < 1e-9);
        assert!((of("messages") + of("refused") - 1.5 / 32.0).abs() < 1e-6);
        // 10 refusals sent, 10 received, 5 rays in vain each way, of 120 messages.
        assert!((of("refused") / (of("messages") + of("refused")) - 30.0 / 120.0).abs() < 1e-9);
        assert!((of("repeated") - (15.0 / 32.0 * 0.9 - 2.0 / 16.0)).abs() < 1e-6);
    });
}

#[test]
fn a_run_that_was_stopped_has_no_efficiency() {
    for (end, why) in [
        (End::Cancelled, "is incomplete: interrupted"),
        (End::Stuck, "is incomplete: nothing moves any more"),
        (End::Slow(NodeId(2)), "is incomplete: nothing moves any more but node 2, slow by"),
        (End::Lost(7), "is incomplete: block 7 is lost: no living node holds a copy"),
    ] {
        with_run("--nodes 4", end, |run| {
            assert_eq!(run.done.efficiency(), None);
            let json = run.as_json();
            // Nor is a part of a picture compared with all of it otherwise.
            assert!(json["efficiency"].is_null() && json["virtual_time_one_node_s"].is_null());
            assert!(json["lost"]["repeated"].is_null() && json["bounds_s"]["work"].is_null());
            assert!(
                json["lost"].as_object().unwrap().values().all(|part| part.as_f64() >= Some(0.0))
            );
            assert_eq!(run.as_json()["complete"], false);
            let shown = html::Shown::new(&run.done.outcome.picture, args::Exposure::Auto).unwrap();
            assert!(page::page(run, &shown).contains(why), "{why}");
        });
    }
}

#[test]
fn a_cut_is_crossed_within_the_run() {
    // The last packets were on their way when it ended.
    let report = fixture::report(&topology("line", 8));
    let cut = cut::worst(&report, 1_000).unwrap();
    assert_eq!(
        (cut.name.as_str(), cut.bytes, cut.bound_ns),
        ("out of x above 6", 7000, report.virtual_ns)
    );
}

#[test]
fn the_worst_cut_is_where_the_bytes_are() {
    // In the fixture a link between nodes a and b carries 1000 (min(a, b) + 1) bytes.
    let worst = |text, nodes| cut::worst(&fixture::report(&topology(text, nodes)), 1_000_000_000);
    // The last plane of the line has the link of node 6.
    let line = worst("line", 8).unwrap();
    assert_eq!((line.links, line.bytes, line.bound_ns), (1, 7000, 7000));
    // Rows 4..=6 and 7 of a mesh of 8 x 8: the last plane of y has nodes 48 to 55.
    let mesh = worst("mesh:8x8", 64).unwrap();
    assert_eq!((mesh.links, mesh.bytes), (8, 1000 * (49..=56).sum::<u64>()), "{}", mesh.name);
    // Half a ring has two links: of node 6 to 7 and 2 to 3.
    let ring = worst("ring", 8).unwrap();
    assert_eq!((ring.links, ring.bytes), (2, 10_000), "{}", ring.name);
    // Of an odd ring each node begins a half: of 7 and 8, from 6 to 7 and from 2 to 3.
    let odd = worst("ring", 9).unwrap();
    assert_eq!((odd.links, odd.bytes), (2, 12_000), "{}", odd.name);
    let mut five = fixture::report(&topology("ring", 5));
    for link in &mut five.links {
        if [(Some(2), Some(3)), (Some(0), Some(4))].contains(&(link.from, link.to)) {
            link.bytes = 1_000_000;
        }
    }
    let worst_of_five = cut::worst(&five, 1_000_000_000).unwrap();
    assert_eq!((worst_of_five.links, worst_of_five.bytes), (2, 2_000_000));
    assert_eq!(worst_of_five.name, "into x 3 to 4");
    // Node 14 of a binary tree of 15 is the child of node 6.
    let tree = worst("tree", 15).unwrap();
    assert_eq!((tree.links, tree.bytes), (1, 7000), "{}", tree.name);
    let full = worst("full", 4).unwrap();
    assert_eq!((full.links, full.bytes), (4, 6000), "{}", full.name);
    assert_eq!(worst("line", 1), None);
}

#[test]
fn every_topology_has_its_page() {
    for (line, size) in [
        ("--topology torus:8x8", 400_000),
        ("--topology mesh:5x3", 400_000),
        ("--topology torus:4x4x4", 400_000),
        ("--topology ring --nodes 9", 400_000),
        ("--topology line --nodes 100", 400_000),
        ("--topology hypercube --nodes 32", 400_000),
        ("--topology tree:3 --nodes 40", 400_000),
        ("--topology full --nodes 12", 400_000),
        ("--nodes 1", 400_000),
        ("--topology torus:64x64", 2_000_000),
        ("--topology ring --nodes 4096", 2_000_000),
    ] {
        with_run(line, End::Complete, |run| {
            let shown = html::Shown::new(&run.done.outcome.picture, args::Exposure::Auto).unwrap();
            let page = page::page(run, &shown);
            assert!(page.len() < size, "{line}: {} bytes", page.len());
            for text in
                ["at work", "block frames", "Worst cut", "99 %", "waiting for blocks", "Over time"]
            {
                let is_there = page.to_lowercase().contains(&text.to_lowercase());
                assert!(is_there || line == "--nodes 1", "{line}: no '{text}'");
            }
            for no in ["NaN", "inf%", "http://", "https://", "<script"] {
                let page = page.replace("http://www.w3.org/2000/svg", "");
                assert!(!page.contains(no), "{line}: {no}");
            }
        });
    }
}

#[test]
fn the_details_are_json_with_every_node_and_link() {
    with_run("--topology mesh:3x3", End::Complete, |run| {
        let json: serde_json::Value = serde_json::from_str(&run.as_json_with_details()).unwrap();
        let count = |name: &str| json[name].as_array().unwrap().len();
        assert_eq!((count("per_node"), count("per_link")), (9, 24));
        assert_eq!(json["per_node"][4]["time"]["idle_data"], 1_000_000 - 444_444);
        assert_eq!(json["nodes"], 9);
    });
}

#[test]
fn the_trace_is_json_with_a_track_for_each_node() {
    with_run("--nodes 4", End::Complete, |run| {
        let mut bytes = Vec::new();
        let options = Options { trace: 1, ..run.options.clone() };
        trace::write(&run.done.outcome.report, &options, &mut bytes).unwrap();
        let json: serde_json::Value = serde_json::from_slice(&bytes).unwrap();
        let events = json["traceEvents"].as_array().unwrap();
        let tracks = events.iter().filter(|event| event["name"] == "thread_name").count();
        assert_eq!(tracks, 4);
        let slice = events.iter().find(|event| event["ph"] == "X").unwrap();
        assert_eq!((&slice["ts"], &slice["dur"]), (&1.234.into(), &5.678.into()));
        assert_eq!(slice["tid"], 1);
        let flow: Vec<_> = events
            .iter()
            .filter(|event| event["name"] == "fetch")
            .map(|event| (&event["ph"], &event["tid"], &event["ts"]))
            .collect();
        let way = [("s", 1, 1.5), ("t", 3, 2.6), ("f", 1, 3.7)];
        let way = way.map(|(phase, node, at)| (phase.into(), node.into(), at.into()));
        assert_eq!(flow, way.each_ref().map(|(phase, node, at)| (phase, node, at)));
        assert!(events.iter().any(|event| event["name"] == "crash" && event["ts"] == 500.0));
        assert!(json["otherData"]["cut"].as_str().unwrap().contains("first 1 events"));
    });
}

#[test]
fn topologies_follow_the_nodes_and_the_other_way_round() {
    let of = |line: &str| {
        with_run(line, End::Complete, |run| {
            (run.options.mesh.topology.nodes(), run.topology.clone())
        })
    };
    assert_eq!(of(""), (64, "torus:8x8".into()));
    assert_eq!(of("--nodes 12"), (12, "torus:4x3".into()));
    assert_eq!(of("--topology mesh:4x2"), (8, "mesh:4x2".into()));
    assert_eq!(of("--topology hypercube --nodes 16"), (16, "hypercube".into()));
    assert_eq!(of("--topology tree:3"), (64, "tree:3".into()));
}

#[test]
fn heavy_faults_of_links_are_named_where_nothing_moves() {
    for (line, part) in [
        ("", "mistake of Kiloray"),
        ("--loss 1/5 --jitter 10us", "mistake of Kiloray"),
        ("--loss 0.9", "less of --loss"),
        ("--loss 0.9 --jitter 10s", "less of --loss and --jitter"),
    ] {
        with_run(line, End::Stuck, |run| {
            let why = why_incomplete(run.done.outcome.end, run.options).unwrap();
            assert!(why.contains(part), "{line}: {why}");
        });
    }
}
