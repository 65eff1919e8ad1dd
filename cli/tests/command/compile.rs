//! `kiloray compile`.

use crate::support::Folder;

#[test]
fn it_prints_what_the_scene_needs_and_writes_a_file() {
    let folder = Folder::new();
    let out = folder.run("compile sphereflake:1 --block 4KiB -o flake.kilo").done().out();
    for part in ["4 triangles, 10 spheres", "blocks", "needs", "specular", "skips", "flake.kilo"] {
        assert!(out.contains(part), "no '{part}' in: {out}");
    }
    assert_eq!(folder.names(), ["flake.kilo"]);
    // It can be read again, with the same figures.
    let json = |scene: &str| -> serde_json::Value {
        let out = folder.run(&format!("compile {scene} --json -")).done().out();
        serde_json::from_str(&out).unwrap()
    };
    let (made, read) = (json("sphereflake:1 --block 4KiB"), json("flake.kilo"));
    for field in
        ["surfaces", "materials", "lights", "views", "needs", "position_error", "file_bytes"]
    {
        assert_eq!(made[field], read[field], "{field}");
        assert!(!made[field].is_null(), "{field}");
    }
    assert_eq!(made["needs"]["spheres"], true);
    assert_eq!(made["needs"]["dielectric"], false);
}

#[test]
fn what_it_cannot_do_is_refused() {
    let folder = Folder::new();
    folder.file("zero.kilo", "");
    folder.file("bad.kilo", [7; 5000]);
    folder.run("compile cornell -o cornell.png").refused(2, &["cornell.png", ".kilo"]);
    folder.run("compile cornell -o no/where.kilo").refused(1, &["no/where.kilo", "directory"]);
    folder.run("compile cornell --block 5KiB").refused(2, &["4KiB"]);
    folder.run("compile zero.kilo").refused(1, &["zero.kilo"]);
    folder.run("compile bad.kilo").refused(1, &["bad.kilo"]);
    folder.run("compile missing.kilo").refused(1, &["missing.kilo", "no such file"]);
    folder.run("compile bad.kilo cornell").refused(2, &["bad.kilo", "alone"]);
    folder.run("compile cornell glass").refused(2, &["glass", "cornell"]);
    folder.run("compile cornell:2").refused(2, &["one size"]);
    folder.run("compile colour-cube:1000").refused(2, &["1 to 94"]);
    folder.run("compile nonsense").refused(2, &["nonsense", "cornell", "sinc:N", "no such file"]);
    assert_eq!(folder.names(), ["bad.kilo", "zero.kilo"], "something is left behind");
}

#[test]
fn a_compiled_scene_keeps_its_block_size() {
    let folder = Folder::new();
    folder.run("compile cornell --block 2KiB -o c.kilo --quiet").done();
    folder.run("compile c.kilo --block 2KiB --quiet").done();
    folder.run("compile c.kilo --block 4KiB").refused(2, &["2048", "compile"]);
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_told() {
    let folder = Folder::new();
    folder.run("compile cornell --json /dev/full --quiet").refused(1, &["/dev/full", "full"]);
}

#[test]
fn blocks_are_dealt_out_to_nodes() {
    let folder = Folder::new();
    let out = folder.run("compile colour-cube --block 1KiB --nodes 8 --json -").done().out();
    let json: serde_json::Value = serde_json::from_str(&out).unwrap();
    let blocks = json["blocks"]["count"].as_u64().unwrap();
    let share = &json["placement"]["blocks"];
    let (least, most) = (share["least"].as_u64().unwrap(), share["most"].as_u64().unwrap());
    // As many blocks at the root as fit a sixteenth of 256 KiB lie with all, the others are divided.
    let top = 16;
    assert!(top > blocks / 64 && most - least <= 1);
    assert!((8 * (least - top)..=8 * (most - top)).contains(&(blocks - top)));
    assert_eq!(json["placement"]["bytes"]["most"], most * 1024);
    let out = folder.run("compile colour-cube --block 1KiB --nodes 8").done().out();
    let told = format!("8 nodes: each has {least} to {most} blocks of 1.00 KiB, ");
    assert!(out.contains(&told) && out.contains(&format!("; {top} at the root lie")), "{out}");
    let out = folder.run("compile colour-cube --nodes 4 --block-replicas 4").done().out();
    assert!(out.contains("4 nodes, 4 copies"), "{out}");
    folder
        .run("compile cornell --nodes 4 --block-replicas 5")
        .refused(2, &["--block-replicas 5", "4"]);
    folder.run("compile cornell --nodes 0").refused(2, &["--nodes"]);
    folder.run("compile cornell --placement round-robin").refused(2, &["--nodes"]);
    // Less of the top gives way to a read-only memory, but for the root.
    let fits = (1 + (blocks - 1).div_ceil(8)) * 1024;
    let compile = "compile colour-cube --block 1KiB --nodes 8 --rom";
    let out = folder.run(&format!("{compile} {fits}")).done().out();
    assert!(out.contains("the root's lies with all"), "{out}");
    let refused = folder.run(&format!("{compile} {}", fits - 1));
    refused.refused(1, &["--rom", &format!("{}KiB; give more, or more --nodes", fits >> 10)]);
}

#[test]
fn blocks_for_nodes_are_those_that_a_simulation_takes() {
    let folder = Folder::new();
    let json = |line: &str| -> serde_json::Value {
        serde_json::from_str(&folder.run(&format!("{line} --json -")).done().out()).unwrap()
    };
    let (compiled, planned) = (json("compile glass --nodes 16"), json("plan glass --nodes 16"));
    assert_eq!(compiled["blocks"]["block_bytes"], planned["block_bytes"]);
    assert_eq!(compiled["placement"]["blocks"]["least"], planned["owned"]["least"]);
    assert_eq!(compiled["placement"]["blocks"]["most"], planned["owned"]["most"]);
    folder.run("compile sinc:60 --nodes 16 --rom 20KiB").done();
    assert_eq!(json("compile glass")["blocks"]["block_bytes"], 16_384);
    let help = folder.run("compile --help").done().out();
    let block_bytes = planned["block_bytes"].as_u64().unwrap();
    assert!(help.contains(&format!("with --nodes {}KiB", block_bytes >> 10)), "{help}");
}
