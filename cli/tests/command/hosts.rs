//! What holds on every host of the node: the simulator, processes, boards. Written once, and run on each.

use serde_json::Value;

use crate::support::{Folder, json};

/// A command that renders on a mesh of nodes.
struct Host {
    /// The command, and how many nodes of what kind.
    command: &'static str,
    /// Meshes that are tried with each scene.
    meshes: &'static [&'static str],
    /// Width and height of the pictures by which they are tried.
    size: [u64; 2],
    /// Budgets that cannot work, and what the refusal must say.
    refused: &'static [(&'static str, i32, &'static [&'static str])],
}

const SIMULATED: Host = Host {
    command: "sim --no-baseline",
    meshes: &["--nodes 4 --topology ring --memory 64KiB", "--nodes 2 --block 1KiB --schedule data"],
    size: [16, 12],
    refused: &[
        ("cornell --nodes 2 --memory 4KiB", 1, &["--memory", "needed"]),
        ("sinc:300 --nodes 4 --memory 64KiB --owned-in-arena", 1, &["tables"]),
    ],
};
#[cfg(feature = "host")]
const PROCESSES: Host = Host {
    command: "host",
    meshes: &["--nodes 4 --topology ring --memory 64KiB", "--nodes 2 --block 1KiB --schedule data"],
    size: [16, 12],
    refused: &[("cornell --nodes 2 --memory 4KiB", 1, &["--memory", "at least"])],
};
const BOARDS: Host = Host {
    command: "board",
    meshes: &["--qemu 2 --block 1KiB", "--qemu 2 --processes 2 --block 1KiB --memory 48KiB"],
    // Bytes take their time over emulated UARTs.
    size: [8, 6],
    refused: &[
        ("cornell --qemu 1 --processes 1 --topology line --memory 4KiB", 1, &["node 1", "needed"]),
        ("cornell --memory 64KiB", 2, &["--memory", "firmware"]),
        ("sinc:600 --qemu 1 --machine lm3s6965evb --topology line", 1, &["take more boards"]),
    ],
};

/// One with a few surfaces, one with all that light can do, one that fills many blocks, one lit by a sky.
const SCENES: [&str; 4] = ["cornell", "glass", "sinc:12", "colour-cube:4"];
const PICTURE: &str = "--width 16 --height 12 --samples 1 --seed 5 --quiet --json run.json";

fn run(folder: &Folder, line: &str) -> Value {
    folder.run(line).done();
    json(&folder.path().join("run.json"))
}

/// The picture has the bits of one machine, and no node took more memory than it was given.
fn keeps_bits_and_budgets(host: &Host) {
    let folder = Folder::new();
    let [width, height] = host.size;
    for scene in SCENES {
        let picture = format!("{scene} {PICTURE} --width {width} --height {height}");
        let expected = run(&folder, &format!("render {picture}"))["image_hash"].clone();
        for mesh in host.meshes {
            let run = run(&folder, &format!("{} {picture} {mesh}", host.command));
            let name = format!("{} {scene} {mesh}", host.command);
            assert_eq!((&run["image_hash"], &run["complete"]), (&expected, &true.into()), "{name}");
            let [limit, peak] = ["limit", "peak"].map(|part| run["memory"][part].as_u64());
            assert!(peak > Some(0) && peak <= limit, "{name}: {}", run["memory"]);
            let rays = run["rays"]["primary"].as_u64();
            assert!(rays >= Some(width * height), "{name}: {}", run["rays"]);
            let told = run["per_node"].as_array().map(Vec::len);
            assert!(told.is_none_or(|told| run["nodes"] == told), "{name}: {}", run["per_node"]);
        }
    }
}

/// The picture of a run that something has happened to has the bits of one machine.
#[track_caller]
fn survives(folder: &Folder, picture: &str, ran: Value) {
    let expected = run(folder, &format!("render {picture}"))["image_hash"].clone();
    assert_eq!((&ran["image_hash"], &ran["complete"]), (&expected, &true.into()));
}

/// What cannot work is refused in one line, before there is a file.
fn refuses_budgets(host: &Host) {
    let folder = Folder::new();
    for (line, code, parts) in host.refused {
        folder.run(&format!("{} {line}", host.command)).refused(*code, parts);
    }
    assert!(folder.names().is_empty(), "something is left behind: {:?}", folder.names());
}

mod simulated {
    use super::*;

    #[test]
    fn keep_bits_and_budgets() {
        keeps_bits_and_budgets(&SIMULATED);
    }

    #[test]
    fn refuse_budgets() {
        refuses_budgets(&SIMULATED);
    }

    #[test]
    fn survive_a_death() {
        survive("--crash 1@200us --block-replicas 2");
    }

    #[test]
    fn survive_losses() {
        survive("--loss 1/50");
    }

    fn survive(faults: &str) {
        let folder = Folder::new();
        let picture = format!("sinc:24 {PICTURE} --width 48 --height 48");
        let command = format!("{} {picture} --nodes 3 {faults}", SIMULATED.command);
        survives(&folder, &picture, run(&folder, &command));
    }
}

#[cfg(feature = "host")]
mod processes {
    use super::*;
    use crate::host::nodes_of;
    use crate::support::signal;

    #[test]
    fn keep_bits_and_budgets() {
        keeps_bits_and_budgets(&PROCESSES);
    }

    #[test]
    fn refuse_budgets() {
        refuses_budgets(&PROCESSES);
    }

    #[test]
    fn survive_a_death() {
        let folder = Folder::new();
        let picture = format!("sinc:24 {PICTURE} --width 160 --height 160 --samples 8");
        let mut command = folder.command();
        command.args(format!("{} {picture} --nodes 3", PROCESSES.command).split(' '));
        let mut host = command.spawn().expect("it starts");
        signal("-KILL", nodes_of(&host, 3)[1]);
        assert!(host.wait().expect("it ends").success());
        let run = json(&folder.path().join("run.json"));
        survives(&folder, &picture, run.clone());
        // On a busy machine others may be silent for too long, and be replaced too.
        assert!(run["faults"]["replaced"].as_array().is_some_and(|replaced| !replaced.is_empty()));
    }
}

/// They need QEMU, and a compiler for boards.
mod boards {
    use std::fs;
    use std::process::{Child, Stdio};

    use super::*;
    use crate::support::{is_gone, signal, until};

    /// A run of some seconds, in which something happens.
    fn spawn(folder: &Folder, line: &str) -> Child {
        let mut command = folder.command();
        command.args(format!("{} {line}", BOARDS.command).split(' ')).stderr(Stdio::piped());
        command.env("TMPDIR", folder.path()).spawn().expect("it starts")
    }

    /// The process of each node of a host, as soon as all are there: emulators and others, by the share that they were given.
    fn nodes_of(folder: &Folder, count: usize) -> Vec<u32> {
        let mut all = Vec::new();
        let place = folder.path().display().to_string();
        until(|| {
            all = fs::read_dir("/proc")
                .into_iter()
                .flatten()
                .flatten()
                .filter_map(|process| {
                    let line = fs::read(process.path().join("cmdline")).ok()?;
                    let line = String::from_utf8_lossy(&line).replace('\0', " ");
                    // Not the shell that guards an emulator.
                    let is_node = line.starts_with("qemu") || line.contains(" line-node ");
                    let (_, rest) = line.split_once(&place).filter(|_| is_node)?;
                    let (_, node) = rest.split_once("/node")?;
                    let node: u32 = node.split_once(".bin")?.0.parse().ok()?;
                    Some((node, process.file_name().to_str()?.parse().ok()?))
                })
                .collect();
            all.len() == count
        });
        all.sort_unstable();
        all.into_iter().map(|(_, process)| process).collect()
    }

    #[test]
    #[ignore = "needs QEMU and a compiler for boards: run by .ci/run ring"]
    fn survive_noise() {
        let folder = Folder::new();
        let picture = format!("sinc:12 {PICTURE} --block 1KiB");
        let run = run(&folder, &format!("{} {picture} --qemu 2 --noise 1/2000", BOARDS.command));
        let damaged = |link: &Value| link["damaged"].as_u64().unwrap_or(0);
        let links = run["host_links"].as_array().cloned().unwrap_or_default();
        assert!(links.iter().map(damaged).sum::<u64>() > 0, "no frame was damaged: {links:?}");
        survives(&folder, &picture, run);
    }

    #[test]
    #[ignore = "needs QEMU and a compiler for boards: run by .ci/run ring"]
    fn survive_a_death() {
        let folder = Folder::new();
        let picture = format!("sinc:12 {PICTURE} --block 1KiB --width 48");
        let mesh = "--qemu 2 --processes 1 --topology full --block-replicas 2";
        let mut host = spawn(&folder, &format!("{picture} {mesh}"));
        signal("-KILL", nodes_of(&folder, 3)[1]);
        assert!(host.wait().expect("it ends").success());
        let run = json(&folder.path().join("run.json"));
        assert_eq!(run["faults"]["died"], serde_json::json!([1]));
        survives(&folder, &picture, run);
    }

    #[test]
    #[ignore = "needs QEMU and a compiler for boards: run by .ci/run ring"]
    fn a_death_that_cannot_be_survived_is_said() {
        for (mesh, part) in [("", "--block-replicas 2"), (" --block-replicas 2", "led over it")] {
            let folder = Folder::new();
            let host = spawn(
                &folder,
                &format!(
                    "sinc:12 {PICTURE} --width 48 --qemu 2 --processes 1 --topology line{mesh}"
                ),
            );
            signal("-KILL", nodes_of(&folder, 3)[1]);
            let output = host.wait_with_output().expect("it ends");
            let message = String::from_utf8_lossy(&output.stderr);
            assert_eq!(output.status.code(), Some(1), "{message}");
            assert!(message.contains("node 1 has ended (signal 9)"), "{message}");
            assert!(message.contains(part), "{message}");
        }
    }

    #[test]
    #[ignore = "needs QEMU and a compiler for boards: run by .ci/run ring"]
    fn end_with_their_host() {
        let folder = Folder::new();
        let mut host =
            spawn(&folder, &format!("sinc:12 {PICTURE} --width 64 --qemu 2 --processes 2"));
        let nodes = nodes_of(&folder, 4);
        host.kill().expect("it is killed");
        host.wait().expect("it is dead");
        until(|| nodes.iter().all(|node| is_gone(*node)));
    }

    #[test]
    #[ignore = "needs QEMU and a compiler for boards: run by .ci/run ring"]
    fn keep_bits_and_budgets() {
        keeps_bits_and_budgets(&BOARDS);
    }

    #[test]
    #[ignore = "needs QEMU and a compiler for boards: run by .ci/run ring"]
    fn refuse_budgets() {
        refuses_budgets(&BOARDS);
    }
}
