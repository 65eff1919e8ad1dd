//! `kiloray plan` for the nodes of a mesh.

use serde_json::Value;

use crate::support::Folder;

#[test]
fn the_budget_of_a_node_of_a_mesh_is_the_simulators() {
    let folder = Folder::new();
    let mesh = "colour-cube --block 4KiB --memory 64KiB --nodes 16 --topology torus:4x4";
    let json: Value =
        serde_json::from_str(&folder.run(&format!("plan {mesh} --json -")).done().out()).unwrap();
    let lines = json["lines"].as_array().unwrap();
    let sum: u64 = lines.iter().map(|line| line["bytes"].as_u64().unwrap()).sum();
    assert_eq!((&json["total"], &json["nodes"]), (&sum.into(), &16.into()));
    assert!(sum <= 65_536 && lines.iter().any(|line| line["line"] == "messages"));

    let text = folder.run(&format!("plan {mesh}")).done().out();
    assert!(text.contains("messages") && text.contains(&format!("{sum} of 65536")), "{text}");
    assert!(text.contains("Node 0 of 16") && text.contains("--owned-in-arena"), "{text}");
    assert!(text.contains(" bytes of memory are needed with these blocks."), "{text}");

    // Blocks on their way take a part of the frames alone.
    let frames = lines.iter().find(|line| line["line"] == "block frames").unwrap();
    let (frames, fetches) = (frames["capacity"].as_u64().unwrap(), &json["fetches"]);
    assert!(fetches.as_u64().unwrap() <= (frames / 8).max(1), "{json}");
    let both = format!("frames for {frames} others, and at most {fetches} of them on their way");
    assert!(text.contains(&both), "{text}");

    // The least memory is one: a byte less is refused, and the reason names it.
    let least = json["least"].as_u64().unwrap();
    let at = |memory: u64| {
        folder.run(&format!("plan colour-cube --block 4KiB --nodes 16 --memory {memory}"))
    };
    let _ = at(least).done();
    let need = format!("at least {least} bytes");
    for memory in [least - 1, 4096] {
        at(memory).refused(1, &["too small", "block frames", &need]);
    }
}

#[test]
fn less_memory_may_do_with_the_smaller_blocks_that_it_gets() {
    let folder = Folder::new();
    let plan = |memory: &str| folder.run(&format!("plan glass --nodes 7 --memory {memory}"));
    let of = |memory: &str| -> Value {
        serde_json::from_str(&plan(&format!("{memory} --json -")).done().out()).unwrap()
    };
    let (great, small) = (of("1MiB"), of("64KiB"));
    assert_eq!((&great["block_bytes"], &small["block_bytes"]), (&2048.into(), &1024.into()));
    assert_eq!(great["least"], small["least"]);
    let least = great["least"].as_u64().unwrap();
    let told = format!("At least {least} bytes of memory are needed.");
    let out = plan("1MiB").done().out();
    assert!(out.contains(&told), "no '{told}' in: {out}");
    plan(&least.to_string()).done();
    plan(&(least - 1).to_string()).refused(1, &["too small"]);
}

#[test]
fn any_option_of_a_mesh_means_a_mesh() {
    let folder = Folder::new();
    // With the memory that its nodes have where nothing is said.
    let json =
        |memory: &str| folder.run(&format!("plan glass --nodes 16 {memory} --json -")).done();
    assert_eq!(json("").out(), json("--memory 256KiB").out());
    let alone = folder.run("plan glass --json -").done().out();
    assert!(alone.contains("\"memory\": 65536"), "{alone}");
    for option in ["--topology hypercube", "--schedule data", "--block-replicas 2"] {
        let out = folder.run(&format!("plan cornell {option}")).done().out();
        assert!(out.contains("Node 0 of 64"), "{option}: {out}");
    }
    assert!(!folder.run("plan cornell").done().out().contains("Node"));
}

#[test]
fn owned_blocks_count_where_they_lie_in_the_arena() {
    let folder = Folder::new();
    let plan = |options: &str| folder.run(&format!("plan colour-cube --nodes 2 {options}"));
    let out = plan("--memory 64KiB").done().out();
    assert!(out.contains("with --owned-in-arena at least"), "{out}");
    plan("--memory 64KiB --owned-in-arena").refused(1, &["scene tables"]);
    let out = plan("--memory 1MiB --owned-in-arena").done().out();
    assert!(out.contains("scene tables") && out.contains("are counted"), "{out}");
}

#[test]
fn no_node_owns_more_than_its_read_only_memory_holds() {
    let folder = Folder::new();
    let plan =
        |options: &str| folder.run(&format!("plan colour-cube --block 1KiB --nodes 64 {options}"));
    let most = |options: &str| -> u64 {
        let json: Value =
            serde_json::from_str(&plan(&format!("--json - {options}")).done().out()).unwrap();
        let [blocks, bytes] = [&json["owned"]["most"], &json["block_bytes"]];
        blocks.as_u64().unwrap() * bytes.as_u64().unwrap()
    };
    // The top of the tree gives way where its size was not said.
    let (top, least) = (most(""), most("--top 1"));
    assert!(least < top);
    assert!((least..top).contains(&most(&format!("--rom {}", top - 1))));
    assert_eq!(most(&format!("--rom {least}")), least);
    // Blocks cannot be smaller.
    let need = "; give more, or more --nodes";
    let refused = plan(&format!("--rom {}", least - 1));
    assert!(refused.err().trim_end().ends_with(need), "{}", refused.err());
    refused.refused(1, &[&format!("--rom {}B", least - 1), &format!("blocks, {}KiB", least >> 10)]);
    plan(&format!("--rom {least} --top 64KiB")).refused(1, &["--rom", "smaller --top"]);
    // All have the root alone.
    let one = folder.run("plan cornell --block 16KiB --nodes 64 --rom 3KiB");
    one.refused(1, &["--rom 3KiB: a node owns up to 1 block, 16KiB; give more, or smaller blocks"]);
}

#[test]
fn what_cannot_be_is_refused() {
    let folder = Folder::new();
    for (options, part) in [
        ("--nodes 63 --topology torus:8x8", "64 nodes, not 63"),
        ("--nodes 0", "--nodes"),
        ("--topology star", "unknown topology"),
        ("--nodes 4 --block-replicas 5", "at most 4 copies"),
        ("--nodes 12 --topology hypercube", "power of two"),
        ("--nodes 4 --block 64KiB --packet 599B", "at least 600B"),
    ] {
        folder.run(&format!("plan cornell {options}")).refused(2, &[part]);
    }
}

#[test]
fn of_all_ram_the_firmware_takes_its_part() {
    let folder = Folder::new();
    let out = folder.run("plan cornell --nodes 4 --ram 64KiB").done().out();
    assert!(out.contains("34.0 KiB are left"), "{out}");
    assert!(out.contains("of 34816"), "{out}");
    for mesh in ["", "--nodes 4 "] {
        let little = folder.run(&format!("plan cornell {mesh}--ram 20KiB"));
        assert!(little.out().contains("nothing is left"), "{}", little.out());
        let message = little.err();
        little.refused(1, &["--ram 20KiB: the firmware takes 30.0 KiB and the node at least "]);
        let (_, enough) = message.trim_end().rsplit_once("give ").expect("what to give");
        folder.run(&format!("plan cornell {mesh}--ram {enough} --block 4KiB")).done();
    }
    folder.run("plan cornell --nodes 4 --ram 30KiB").refused(1, &["--ram 30KiB", "give "]);
    folder.run("plan cornell --ram 64KiB --memory 64KiB").refused(2, &["--memory"]);
}

#[test]
fn blocks_too_great_for_a_memory_are_noted() {
    let folder = Folder::new();
    folder.run("compile cornell -o great.kilo -q").done();
    folder.run("compile cornell --block 4KiB -o fits.kilo -q").done();
    let notes = |line: &str| folder.run(&format!("plan {line}")).done().err();
    let told = notes("great.kilo --nodes 4 --memory 256KiB");
    assert!(told.contains("blocks of 16KiB") && told.contains("--block 1KiB"), "{told}");
    for line in [
        "great.kilo --nodes 4 --memory 4MiB",
        "great.kilo --nodes 4 --memory 256KiB --block 16KiB",
        "great.kilo --memory 256KiB",
        "fits.kilo --nodes 4 --memory 256KiB",
    ] {
        let told = notes(line);
        assert!(!told.contains("blocks of"), "{line}: {told}");
    }
}
