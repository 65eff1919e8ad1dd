//! `kiloray node` and `kiloray host --config`: the example of two machines, in two directories of one.

use std::{
    fs,
    net::TcpListener,
    path::Path,
    process::{Child, Command, Stdio},
    time::Duration,
};

use crate::support::{Folder, json, signal, until, within, worked};

const EXAMPLE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../node-host/examples/two-machines");
const MACHINES: [&str; 2] = ["alpha.example", "beta.example"];

/// Both machines' directories, as the guide has them, but for names, ports and the size of the picture.
fn machines(folder: &Folder) {
    folder.run("compile cornell --block 1KiB -o scene.kilo").done();
    let made = Command::new("sh")
        .arg(Path::new(EXAMPLE).join("certificates"))
        .arg("127.0.0.1")
        .current_dir(folder.path())
        .output()
        .expect("there is a shell");
    assert!(made.status.success(), "{}", String::from_utf8_lossy(&made.stderr));
    let mut text = fs::read_to_string(Path::new(EXAMPLE).join("mesh.toml")).expect("the example");
    let named = MACHINES.map(|machine| [7447, 7448].map(|port| format!("{machine}:{port}")));
    place(&mut text, named.as_flattened());
    for side in ["width", "height"] {
        let said = format!("{side} = 512\n");
        assert!(text.contains(&said), "{said}");
        text = text.replace(&said, &format!("{side} = 40\n"));
    }
    for machine in MACHINES {
        let place = folder.path().join(machine);
        fs::create_dir_all(place.join("tls")).expect("a directory");
        fs::write(place.join("mesh.toml"), &text).expect("a configuration");
        let mut copy = vec!["scene.kilo".to_owned()];
        copy.extend(["root", "certificate", "key"].map(|file| format!("tls/{file}.pem")));
        for file in copy {
            let from = folder.path().join(if file.starts_with("tls") { "127.0.0.1" } else { "." });
            fs::copy(from.join(&file), place.join(&file)).expect("it is copied");
        }
    }
}

/// Writes free ports of this machine in place of addresses. They are held together, so that no two are the same.
fn place(text: &mut String, named: &[String]) {
    let free: Vec<_> =
        named.iter().map(|_| TcpListener::bind("127.0.0.1:0").expect("a port")).collect();
    for (named, free) in named.iter().zip(free) {
        assert!(text.contains(named), "{named}");
        *text = text.replace(named, &free.local_addr().expect("an address").to_string());
    }
}

/// A configuration of two nodes of this machine, in `mesh.toml`, and its text.
fn pair(folder: &Folder) -> String {
    folder.run("compile cornell --block 1KiB -o scene.kilo").done();
    folder.run("host scene.kilo --nodes 2 --width 40 --write-config mesh.toml").done();
    let mut text = fs::read_to_string(folder.path().join("mesh.toml")).expect("a configuration");
    place(&mut text, &[7447, 7448].map(|port| format!("127.0.0.1:{port}")));
    folder.file("mesh.toml", &text);
    text
}

fn node(folder: &Folder, machine: &str, node: u16) -> Child {
    let mut command = folder.command();
    command.args([
        "node",
        "--config",
        &format!("{machine}/mesh.toml"),
        "--node",
        &node.to_string(),
    ]);
    command.stderr(Stdio::piped()).spawn().expect("it starts")
}

#[test]
fn two_machines_render_the_bits_of_one_node() {
    let folder = Folder::new();
    machines(&folder);
    let nodes: Vec<_> = (0..4).map(|n| node(&folder, MACHINES[usize::from(n / 2)], n)).collect();
    let config = format!("{}/mesh.toml", MACHINES[0]);
    folder.run(&format!("host --config {config} -o mesh.exr --json mesh.json --quiet")).done();
    for node in nodes {
        let output = node.wait_with_output().expect("it ends");
        assert!(output.status.success(), "{output:?}");
    }
    let run = json(&folder.path().join("mesh.json"));
    let picture = "--width 40 --height 40 --samples 16";
    folder.run(&format!("render scene.kilo {picture} -o one.exr --json one.json --quiet")).done();
    let one = json(&folder.path().join("one.json"));
    assert_eq!(run["image_hash"], one["image_hash"]);
    for option in
        ["width", "height", "samples", "bounces", "seed", "shadow_samples", "lights_per_point"]
    {
        assert_eq!(run["options"][option], one["options"][option], "{option}");
    }
    assert_eq!(run["options"]["memory"], 65536);
    assert_eq!(run["nodes"], 4);
}

#[test]
fn a_port_in_use_is_named_with_its_node() {
    let folder = Folder::new();
    let text = pair(&folder);
    let held = TcpListener::bind("127.0.0.1:0").expect("a port");
    let address = held.local_addr().expect("an address").to_string();
    let (_, first) = text.split_once("tcp/").expect("an address");
    let (first, _) = first.split_once('"').expect("its end");
    folder.file("mesh.toml", text.replace(first, &address));
    let said = folder.run("node --config mesh.toml --node 0");
    said.refused(1, &["node 0: cannot listen at tcp/", &address, "in use"]);
}

#[test]
fn a_node_without_its_file_is_named() {
    let folder = Folder::new();
    pair(&folder);
    fs::remove_file(folder.path().join("scene.kilo")).expect("it is there");
    let said = folder.run("node --config mesh.toml --node 1");
    said.refused(1, &["node 1: ", "scene.kilo", "o such file"]);
    folder.run("node --config other.toml --node 1").refused(1, &["node 1: ", "other.toml"]);
}

#[test]
fn a_node_of_another_scene_is_named_on_both_sides() {
    let folder = Folder::new();
    let text = pair(&folder);
    fs::create_dir(folder.path().join("other")).expect("a directory");
    folder.file("other/mesh.toml", text);
    folder.run("compile glass --block 1KiB -o other/scene.kilo").done();
    let mut right = node(&folder, ".", 0);
    // A host that sees the wrong one first ends before the right one has heard of it, which waits for the next host then.
    for _ in 0..10 {
        let wrong = node(&folder, "other", 1);
        folder.run("host --config mesh.toml").refused(1, &["node 1 has another scene file"]);
        let ended = wrong.wait_with_output().expect("it ends");
        let said = String::from_utf8_lossy(&ended.stderr);
        assert_eq!(ended.status.code(), Some(1), "{said}");
        assert!(said.contains("node 1: the host has another scene file"), "{said}");
        let has_ended = || right.try_wait().expect("it can be asked").is_some();
        if within(Duration::from_secs(2), has_ended) {
            break;
        }
    }
    let _ = right.kill();
    let ended = right.wait_with_output().expect("it ends");
    let said = String::from_utf8_lossy(&ended.stderr);
    assert!(said.contains("node 0: the host has gone"), "{said}");
}

#[test]
fn a_node_whose_host_has_gone_says_so() {
    let folder = Folder::new();
    let text = pair(&folder);
    folder.file("mesh.toml", text.replace("width = 40", "width = 4000"));
    let nodes = [0, 1].map(|number| node(&folder, ".", number));
    let mut command = folder.command();
    command.args(["host", "--config", "mesh.toml", "--json", "-"]);
    let mut host = command.spawn().expect("it starts");
    // They know the host when they are at work for it.
    until(|| nodes.iter().all(|node| worked(node.id()) > 20));
    host.kill().expect("it is killed");
    let _ = host.wait();
    for (number, node) in nodes.into_iter().enumerate() {
        let output = node.wait_with_output().expect("it ends");
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{said}");
        assert!(said.contains(&format!("node {number}: the host has gone")), "{said}");
    }
}

#[test]
fn packets_in_which_no_block_can_be_sent_are_refused() {
    let folder = Folder::new();
    let text = pair(&folder);
    assert!(text.contains("packet = 0"), "{text}");
    folder.run("compile cornell --block 64KiB -o scene.kilo").done();
    folder.file("mesh.toml", text.replace("packet = 0", "packet = 400"));
    let words = ["packet = 400: blocks of 65536 bytes need at least 600"];
    folder.run("host --config mesh.toml").refused(2, &words);
    folder.run("node --config mesh.toml --node 0").refused(2, &words);
    let typed = folder.run("host cornell --block 64KiB --nodes 2 --packet 400B");
    typed.refused(2, &["--packet 400B: blocks of 64KiB need at least 600B"]);
}

#[test]
fn an_interrupt_before_all_nodes_are_there_says_so() {
    let folder = Folder::new();
    pair(&folder);
    let mut command = folder.command();
    let line = "host --config mesh.toml -o a.png --json run.json --report page";
    command.args(line.split(' ')).stdout(Stdio::piped()).stderr(Stdio::piped());
    let host = command.spawn().expect("it starts");
    // The picture's file is begun when the command can be interrupted.
    until(|| folder.names().iter().any(|name| name.ends_with(".part")));
    signal("-INT", host.id());
    let output = host.wait_with_output().expect("it ends");
    let [out, err] = [&output.stdout, &output.stderr].map(|text| String::from_utf8_lossy(text));
    assert_eq!(output.status.code(), Some(1), "{err}");
    let told = "error: interrupted before all nodes were there; no pixel is complete\n";
    assert_eq!(err, told);
    assert!(out.starts_with("no picture: 40 x 40"), "{out}");
    assert!(out.contains("not all nodes were there") && !out.contains("until all"), "{out}");
    let run = json(&folder.path().join("run.json"));
    for name in ["start_s", "mesh_s"] {
        assert!(run[name].is_null(), "{name}: {}", run[name]);
    }
    assert!(run["options"]["exposure"].is_null(), "{}", run["options"]);
    assert_eq!((&run["complete"], &run["tiles"]["pixels"]), (&false.into(), &0.into()));
    assert_eq!(folder.names(), ["mesh.toml", "page", "run.json", "scene.kilo"]);
    let page = fs::read_to_string(folder.path().join("page/index.html")).expect("it is there");
    assert!(page.contains("is incomplete: interrupted before all nodes"), "{page}");
    assert!(!page.contains("until all nodes") && !page.contains("data:image/png"), "{page}");
    assert!(!folder.path().join("page/picture.png").exists());
    assert!(!folder.path().join("page/picture.incomplete.png").exists());
}

#[test]
fn what_would_be_open_to_all_is_refused() {
    let folder = Folder::new();
    folder.run("compile cornell --block 1KiB -o scene.kilo").done();
    folder.run("host scene.kilo --nodes 1 --write-config mesh.toml").done();
    assert_eq!(folder.names(), ["mesh.toml", "scene.kilo"]);
    let text = fs::read_to_string(folder.path().join("mesh.toml")).expect("a configuration");
    assert!(text.contains("scene = \"scene.kilo\"\n"), "{text}");
    folder.file("mesh.toml", text.replace("127.0.0.1", "0.0.0.0"));
    let words = ["tcp/0.0.0.0:7447", "quic/0.0.0.0:7447", "--insecure"];
    folder.run("node --config mesh.toml --node 0").refused(2, &words);
    let fifth = folder.run("node --config mesh.toml --node 5");
    fifth.refused(2, &["error: node 5: mesh.toml has nodes 0 to 0 only"]);
    folder.run("host --config mesh.toml").refused(2, &words);
    folder.file("mesh.toml", text);
    let elsewhere = "node --config mesh.toml --node 0 --listen tcp/[::]:7447";
    folder.run(elsewhere).refused(2, &["tcp/[::]:7447", "--insecure"]);
    folder.run("host --config mesh.toml --samples 2").refused(2, &["--config", "--samples"]);
    // The scene that it names is read too.
    folder.run("host --config mesh.toml --json scene.kilo").refused(2, &["scene.kilo", "reads it"]);
    folder.run("host cornell --nodes 2 --write-config other.toml").refused(2, &["compile"]);
    folder.run("host").refused(2, &["SCENE"]);
    let alone = folder.run("host scene.kilo --insecure");
    alone.refused(2, &["--insecure", "--config"]);
    folder.run("host --insecure").refused(2, &["--config"]);
}

#[test]
fn numbers_of_a_configuration_are_in_the_bounds_of_the_command() {
    let folder = Folder::new();
    let text = pair(&folder);
    for (said, instead, words) in [
        ("samples = 16", "samples = 0", "from 1 to 262144"),
        ("samples = 16", "samples = 262145", "from 1 to 262144"),
        ("shadow_samples = 0", "shadow_samples = 4097", "from 0 to 4096"),
        ("lights_per_point = 64", "lights_per_point = 0", "from 1 to 65535"),
        ("bounces = 8", "bounces = 65", "from 0 to 64"),
        ("packet = 0", "packet = 279", "from 280 to 16408"),
        ("packet = 0", "packet = 16409", "from 280 to 16408"),
        ("replicas = 1", "replicas = 0", "from 1 to 2"),
        ("replicas = 1", "replicas = 3", "from 1 to 2"),
        ("nearest = 0", "nearest = 17", "from 0 to 16"),
        ("group = 0", "group = 32769", "from 0 to 32768"),
        ("group = 0", "group = 0\ntile = 257", "from 1 to 256"),
        ("group = 0", "group = 0\ntile = 0", "from 1 to 256"),
    ] {
        assert!(text.contains(&format!("\n{said}\n")), "no {said} in {text}");
        let changed = text.replace(&format!("\n{said}\n"), &format!("\n{instead}\n"));
        folder.file("mesh.toml", changed);
        let field = instead.rsplit('\n').next().unwrap_or(instead);
        for command in ["host --config mesh.toml", "node --config mesh.toml --node 0"] {
            folder.run(command).refused(1, &["mesh.toml: ", field, words]);
        }
    }
}

#[test]
fn what_a_configuration_says_is_not_said_beside_it() {
    let folder = Folder::new();
    for said in [
        "cornell",
        "--width 8",
        "--height 8",
        "--view front",
        "--samples 2",
        "--shadow-samples 2",
        "--lights-per-point 2",
        "--bounces 2",
        "--lighting direct",
        "--seed 2",
        "--memory 64KiB",
        "--block 1KiB",
        "--nodes 2",
        "--topology ring",
        "--schedule data",
        "--shadow keep",
        "--points owner",
        "--prefetch all",
        "--task-order made",
        "--tile 8",
        "--group 4",
        "--refusals 2",
        "--placement round-robin",
        "--top 2",
        "--rom 1MiB",
        "--block-replicas 2",
        "--packet 512B",
        "--enforce",
        "--write-config other.toml",
    ] {
        let name = said.split(' ').next().filter(|name| name.starts_with('-')).unwrap_or("SCENE");
        let words = ["--config <FILE>", "cannot be used with", name];
        folder.run(&format!("host --config mesh.toml {said}")).refused(2, &words);
    }
    // What is left: then the file is looked for.
    let beside = "-o a.exr --lights 9 --exposure 1 --json a.json --report page --quiet --insecure";
    folder.run(&format!("host --config mesh.toml {beside}")).refused(1, &["mesh.toml"]);
    folder.run("host --config mesh.toml --threads 2").refused(2, &["--nodes says how many"]);
}

#[test]
fn no_output_is_promised_where_a_configuration_is_written() {
    let folder = Folder::new();
    folder.run("compile cornell --block 1KiB -o scene.kilo").done();
    for said in ["--output a.png", "--json a.json", "--report page", "--exposure 1"] {
        let name = said.split(' ').next().unwrap_or(said);
        let line = format!("host scene.kilo --nodes 1 --write-config mesh.toml {said}");
        folder.run(&line).refused(2, &["--write-config <FILE>", "cannot be used with", name]);
    }
    assert_eq!(folder.names(), ["scene.kilo"]);
}

#[test]
fn nodes_keep_to_their_memory() {
    let folder = Folder::new();
    let scene = "glass --width 32 --height 24 --samples 1 --seed 3";
    folder.run(&format!("render {scene} --quiet --json one.json")).done();
    folder.run(&format!("host {scene} --nodes 3 --enforce --quiet --json mesh.json")).done();
    let [one, run] = ["one", "mesh"].map(|name| json(&folder.path().join(format!("{name}.json"))));
    assert_eq!(run["image_hash"], one["image_hash"]);
    assert_eq!(run["faults"]["replaced"], serde_json::json!([]));
    let bytes = |name: &str| run["memory"]["processes"][name].as_u64().expect(name);
    assert!(bytes("peak") <= bytes("budget"), "{}", run["memory"]);
    assert!(bytes("limit") <= bytes("budget"), "{}", run["memory"]);
}
