//! What holds on every host of the node: the simulator, processes, boards. Written once, and run on each.

use serde_json::Value;

use crate::support::{Folder, json};

/// A command that renders on a mesh of nodes.
struct Host {
    /// The command, and how many nodes of what kind.
    command: &'static str,
    /// Meshes that are tried with each scene.
    meshes: &'static [&'static str],
    /// Budgets that cannot work, and what the refusal must say.
    refused: &'static [(&'static str, i32, &'static [&'static str])],
}

const SIMULATED: Host = Host {
    command: "sim --no-baseline",
    meshes: &["--nodes 4 --topology ring --memory 64KiB", "--nodes 2 --block 1KiB --schedule data"],
    refused: &[
        ("cornell --nodes 2 --memory 4KiB", 1, &["--memory", "needed"]),
        ("sinc:300 --nodes 4 --memory 64KiB --owned-in-arena", 1, &["tables"]),
    ],
};
#[cfg(feature = "host")]
const PROCESSES: Host = Host {
    command: "host",
    meshes: &["--nodes 4 --topology ring --memory 64KiB", "--nodes 2 --block 1KiB --schedule data"],
    refused: &[("cornell --nodes 2 --memory 4KiB", 1, &["--memory", "at least"])],
};
const BOARDS: Host = Host {
    command: "board",
    meshes: &["--qemu 2 --block 1KiB"],
    refused: &[
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
    for scene in SCENES {
        let expected = run(&folder, &format!("render {scene} {PICTURE}"))["image_hash"].clone();
        for mesh in host.meshes {
            let run = run(&folder, &format!("{} {scene} {PICTURE} {mesh}", host.command));
            let name = format!("{} {scene} {mesh}", host.command);
            assert_eq!((&run["image_hash"], &run["complete"]), (&expected, &true.into()), "{name}");
            // A board's arena is as large as its firmware says: it cannot be greater.
            if let Some(limit) = run["memory"]["limit"].as_u64() {
                assert!(run["memory"]["peak"].as_u64().is_some_and(|peak| peak <= limit), "{name}");
            }
        }
    }
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
        let folder = Folder::new();
        let picture = format!("sinc:24 {PICTURE} --width 48 --height 48");
        let expected = run(&folder, &format!("render {picture}"))["image_hash"].clone();
        let mesh = "--nodes 3 --crash 1@200us --block-replicas 2 --loss 1/50";
        let run = run(&folder, &format!("{} {picture} {mesh}", SIMULATED.command));
        assert_eq!((&run["image_hash"], &run["complete"]), (&expected, &true.into()));
    }
}

#[cfg(feature = "host")]
mod processes {
    use super::*;
    use crate::host::{nodes_of, signal};

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
        let expected = run(&folder, &format!("render {picture}"))["image_hash"].clone();
        let mut command = folder.command();
        command.args(format!("{} {picture} --nodes 3", PROCESSES.command).split(' '));
        let mut host = command.spawn().expect("it starts");
        signal("-KILL", nodes_of(&host, 3)[1]);
        assert!(host.wait().expect("it ends").success());
        let run = json(&folder.path().join("run.json"));
        assert_eq!((&run["image_hash"], &run["complete"]), (&expected, &true.into()));
        // On a busy machine others may be silent for too long, and be replaced too.
        assert!(run["faults"]["replaced"].as_array().is_some_and(|replaced| !replaced.is_empty()));
    }
}

/// They need QEMU, and a compiler for boards.
mod boards {
    use super::*;

    #[test]
    #[ignore = "needs QEMU and a compiler for boards: run by .ci/run board"]
    fn keep_bits_and_budgets() {
        keeps_bits_and_budgets(&BOARDS);
    }

    #[test]
    #[ignore = "needs QEMU and a compiler for boards: run by .ci/run board"]
    fn refuse_budgets() {
        refuses_budgets(&BOARDS);
    }
}
