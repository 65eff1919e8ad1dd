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
    let out = folder.run("compile colour-cube --block 4KiB --nodes 8 --json -").done().out();
    let json: serde_json::Value = serde_json::from_str(&out).unwrap();
    let blocks = json["blocks"]["count"].as_u64().unwrap();
    let share = &json["placement"]["blocks"];
    let (least, most) = (share["least"].as_u64().unwrap(), share["most"].as_u64().unwrap());
    // The root's block lies with all, the others are divided.
    let dealt = blocks - 1;
    assert!(most - least <= 1 && (8 * (least - 1)..=8 * (most - 1)).contains(&dealt));
    assert_eq!(json["placement"]["bytes"]["most"], most * 4096);
    let out = folder.run("compile colour-cube --block 4KiB --nodes 8").done().out();
    assert!(out.contains(&format!("8 nodes: each has {least} to {most} blocks")), "{out}");
    let out = folder.run("compile colour-cube --nodes 4 --block-replicas 4").done().out();
    assert!(out.contains("4 nodes, 4 copies"), "{out}");
    folder
        .run("compile cornell --nodes 4 --block-replicas 5")
        .refused(2, &["--block-replicas 5", "4"]);
    folder.run("compile cornell --nodes 0").refused(2, &["--nodes"]);
    folder.run("compile cornell --placement round-robin").refused(2, &["--nodes"]);
    let fits = most * 4096;
    let compile = "compile colour-cube --block 4KiB --nodes 8 --rom";
    folder.run(&format!("{compile} {fits}")).done();
    let refused = folder.run(&format!("{compile} {}", fits - 1));
    refused.refused(1, &["--rom", &format!("{}KiB; give more", fits >> 10), "--block"]);
}
