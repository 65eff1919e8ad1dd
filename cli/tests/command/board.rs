//! `kiloray board`, as far as it goes without boards; with them see `node-board/ring`.

use crate::support::Folder;

#[test]
fn a_mesh_that_cannot_be_wired_is_refused() {
    let folder = Folder::new();
    folder.run("board cornell --topology star").refused(2, &["--topology star", "ring"]);
    folder.run("board cornell --qemu 9 --topology mesh:3x3").refused(2, &["4 links", "has 3"]);
    folder.run("board cornell --qemu 0").refused(2, &["1 to"]);
    folder.run("board cornell --qemu 500").refused(2, &["1 to 64"]);
    folder.run("board cornell --machine pc").refused(2, &["mps2-an386", "lm3s6965evb"]);
    folder.run("board cornell --memory 64KiB").refused(2, &["--memory", "firmware"]);
    folder.run("board cornell -o cornell.gif").refused(2, &["cornell.gif"]);
    assert!(folder.names().is_empty(), "something is left behind");
}

#[test]
fn options_that_would_do_nothing_are_refused() {
    let folder = Folder::new();
    for (line, part) in [
        ("--boards 4 --qemu 2", "--boards"),
        ("--boards 4 --noise 1/100", "--boards"),
        ("--boards 4 --processes 1", "--boards"),
        ("--baud 300 --machine lm3s6965evb", "--baud"),
        ("--boards 4", "--serial"),
        ("--baud 9600", "--serial"),
        ("--block-replicas 5", "4 nodes hold at most 4 copies"),
        ("--qemu 2 --processes 1 --block-replicas 4", "3 nodes hold at most 3 copies"),
    ] {
        folder.run(&format!("board cornell {line}")).refused(2, &[part]);
    }
}

#[test]
fn a_file_that_is_no_firmware_is_refused() {
    let folder = Folder::new();
    folder.file("notes.txt", "no firmware\n");
    folder.file("empty.elf", "");
    for (name, part) in [
        ("notes.txt", "is no firmware, which is an ELF file"),
        ("empty.elf", "is no firmware"),
        ("missing.elf", "no such file"),
    ] {
        folder.run(&format!("board cornell --firmware {name}")).refused(1, &[name, part]);
    }
}

#[test]
fn a_share_is_written_for_a_node_that_exists() {
    let folder = Folder::new();
    folder.run("compile glass --block 1KiB --nodes 4 --for-node 3 -o node3.bin --quiet").done();
    assert_eq!(folder.names(), ["node3.bin"]);
    let compile = "compile glass --nodes 4 -o node.bin --for-node";
    folder.run(&format!("{compile} 4")).refused(2, &["--for-node 4", "from 0 to 3"]);
    folder.run("compile glass -o node.bin --for-node 4").refused(2, &["from 0 to 3"]);
    folder.run("compile glass --nodes 4 --for-node 0").refused(2, &["--output"]);
    assert_eq!(folder.names(), ["node3.bin"]);
    // It is no scene, whatever its name.
    folder.run("compile glass --for-node 3 -o node3.kilo --quiet").done();
    let words = ["node3.kilo: is the share of one node", "name the scene itself"];
    folder.run("render node3.kilo").refused(1, &words);
    // As 'kiloray board' has it where nothing is said.
    folder.run("compile glass --for-node 3 -o default.bin --quiet").done();
    let [share, default] = ["node3.bin", "default.bin"].map(|name| folder.path().join(name));
    assert_eq!(std::fs::read(share).expect("a share"), std::fs::read(default).expect("another"));
}
