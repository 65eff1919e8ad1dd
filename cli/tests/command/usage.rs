//! The command line itself.

use std::{fs, process::Stdio};

use crate::support::{Folder, json};

#[test]
fn help_teaches() {
    let folder = Folder::new();
    let help = folder.run("--help").done().out();
    for command in [
        "render",
        "sim",
        "sweep",
        "compile",
        "plan",
        "calibrate",
        "compare",
        "scenes",
        "completions",
        "Examples:",
    ] {
        assert!(help.contains(command), "no '{command}' in: {help}");
    }
    for command in ["render", "sim", "sweep", "compile", "plan", "calibrate", "compare"] {
        let help = folder.run(&format!("{command} --help")).done().out();
        assert!(help.contains("Examples:"), "{command}: {help}");
    }
    let help = folder.run("render --help").done().out();
    let light = format!("each costs every node {} bytes", size_of::<kiloray_core::scene::Light>());
    let words: Vec<_> = help.split_whitespace().collect();
    assert!(words.join(" ").contains(&light), "no '{light}' in: {help}");
    for option in [
        "--width",
        "--height",
        "--view",
        "--samples",
        "--shadow-samples",
        "--lights-per-point",
        "--pixel-spacing",
        "--pixel-contrast",
        "--bounces",
        "--lighting",
        "--seed",
        "--block",
        "--threads",
        "--exposure",
        "--json",
        "--report",
        "--quiet",
        "--memory",
    ] {
        assert!(help.contains(option), "no '{option}' in: {help}");
    }
    let help = folder.run("sim --help").done().out();
    for option in [
        "--nodes",
        "--topology",
        "--memory",
        "--profile",
        "--schedule",
        "--placement",
        "--top",
        "--block-replicas",
        "--shadow <S>",
        "--points <P>",
        "--prefetch",
        "--task-order",
        "--tile",
        "--refusals",
        "--link-bandwidth",
        "--link-latency",
        "--packet",
        "--switching",
        "--loss",
        "--duplicate",
        "--jitter",
        "--slow",
        "--crash",
        "--owned-in-arena",
        "--trace",
        "--no-baseline",
        "256KiB",
    ] {
        assert!(help.contains(option), "no '{option}' in: {help}");
    }
    assert!(folder.run("--version").done().out().contains(env!("CARGO_PKG_VERSION")));
}

#[test]
fn senseless_lines_are_refused_in_one_line() {
    let folder = Folder::new();
    for (line, part) in [
        ("render", "provided: <SCENE>"),
        ("paint cornell", "paint"),
        ("render cornell --widht 3", "--width"),
        ("render cornell --width 0", "1 to 65536"),
        ("render cornell --width 1000000000 --height 1000000000", "1 to 65536"),
        ("render cornell --width 65536 --height 65536", "268435456"),
        ("render cornell --samples -1", "1 to 262144"),
        ("render cornell --samples 0", "1 to 262144"),
        ("render cornell --shadow-samples many", "1 to"),
        ("render cornell --lights-per-point 0", "1 to"),
        ("render cornell --bounces 1000", "0 to 64"),
        ("render cornell --seed -1", "0 to 18446744073709551615"),
        ("render cornell --memory banana", "64KiB"),
        ("render cornell --memory 64kib", "KiB"),
        ("render cornell --memory 1.5MiB", "MiB"),
        ("render cornell --memory 99999999999GiB", "more than"),
        ("render cornell --block 3KiB", "4KiB"),
        ("render cornell --threads 0", "1 to 1024"),
        ("render cornell --lighting global", "direct"),
        ("render cornell --exposure bright", "auto"),
        ("render cornell --view 0", "from 1"),
        ("render cornell --view front", "default"),
        ("render cornell --view 7", "default"),
        ("render cornell -o out.jpg", ".png, .hdr or .exr"),
        ("render cornell -o out", ".png, .hdr or .exr"),
        ("render cornel", "cornell"),
        ("render cornell:3", "one size"),
        ("render sinc:1000000", "2 to 2236"),
        ("calibrate --threads 0", "1 to 1024"),
        ("calibrate --repeats 0", "--repeats"),
        ("completions tcsh", "bash"),
    ] {
        folder.run(line).refused(2, &[part]);
    }
    assert!(folder.names().is_empty(), "something is left behind");
}

#[test]
fn no_two_outputs_have_one_name() {
    let folder = Folder::new();
    folder.file("old.png", "as it was");
    let small = "--width 8 --samples 1";
    for (line, name) in [
        ("render cornell -o old.png --json old.png", "old.png"),
        ("render cornell -o new.png --json ./new.png", "new.png"),
        ("render cornell -o page/picture.png --report page", "picture.png"),
        ("sim cornell --json run.json --trace run.json", "run.json"),
        ("sim cornell --json - --trace -", "standard output"),
    ] {
        // A picture can be sent into a directory that is there.
        if line.contains("page") {
            fs::create_dir(folder.path().join("page")).unwrap();
        }
        folder.run(&format!("{line} {small}")).refused(2, &[name, "two outputs"]);
    }
    folder.run("compile cornell -o a.kilo --json a.kilo").refused(2, &["a.kilo"]);
    assert_eq!(folder.names(), ["old.png", "page"]);
    assert_eq!(fs::read(folder.path().join("old.png")).unwrap(), b"as it was");
    // A device takes what several write.
    #[cfg(unix)]
    folder.run("compile cornell --json /dev/null").done();
}

/// It is refused before anything is read, by whatever name.
#[test]
fn no_output_goes_where_an_input_is() {
    let folder = Folder::new();
    let kept = ["t.obj", "in.rad", "v.vf", "a.png", "b.hdr", "p.json"];
    for name in kept {
        folder.file(name, "as it was");
    }
    fs::create_dir(folder.path().join("sub")).unwrap();
    for (line, name) in [
        ("render t.obj --json t.obj", "t.obj"),
        ("render cornell --view v.vf --json sub/../v.vf", "v.vf"),
        ("sim t.obj --trace ./t.obj", "t.obj"),
        ("sim cornell --profile p.json --json p.json", "p.json"),
        ("sweep in.rad --json in.rad", "in.rad"),
        ("plan in.rad --json in.rad", "in.rad"),
        ("compile v.vf in.rad --json in.rad", "in.rad"),
        ("compare a.png b.hdr -o a.png", "a.png"),
        ("compare a.png b.hdr --json b.hdr", "b.hdr"),
        ("compare b.hdr b.hdr --mask a.png -o a.png", "a.png"),
    ] {
        folder.run(line).refused(2, &[name, "reads it"]);
    }
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink(folder.path().join("t.obj"), folder.path().join("link.png"))
            .unwrap();
        folder.run("render t.obj -o link.png").refused(2, &["link.png", "reads it"]);
    }
    for name in kept {
        assert_eq!(fs::read(folder.path().join(name)).unwrap(), b"as it was", "{name}");
    }
    // A built-in scene is no file, even if one is called as it is.
    folder.file("cornell", "as it was");
    folder.run("compile cornell --json cornell").done();
    assert!(json(&folder.path().join("cornell"))["surfaces"].is_number());
}

/// Nor where a file is that was not typed: another has named it.
#[test]
fn no_output_goes_where_a_file_is_that_others_name() {
    let folder = Folder::new();
    folder.file("e.obj", "mtllib e.mtl\nusemtl m\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    folder.file("e.mtl", "newmtl m\nKd 1 0 0\n");
    folder.file("top.rad", "!xform inc.rad\n");
    folder.file("inc.rad", "void plastic m 0 0 5 .5 .5 .5 0 0\nm sphere s 0 0 4 0 0 0 1\n");
    folder.file("v.vf", "rvu -vp 0 -9 0 -vd 0 1 0\n");
    folder.file("p.json", "as it was");
    let all = ["e.mtl", "inc.rad", "v.vf", "p.json"];
    let bytes = || all.map(|name| fs::read(folder.path().join(name)).unwrap());
    let before = bytes();
    for (line, name) in [
        ("render e.obj -o x.hdr --json e.mtl", "e.mtl"),
        ("render top.rad -o x.hdr --json inc.rad", "inc.rad"),
        ("sim top.rad --nodes 2 --trace ./inc.rad", "inc.rad"),
        ("compile top.rad --json inc.rad", "inc.rad"),
        ("plan e.obj --json e.mtl", "e.mtl"),
        ("sweep cornell --over profile=pc,p.json --json p.json", "p.json"),
        ("sweep cornell --over view=1,v.vf --json v.vf", "v.vf"),
    ] {
        let small = if line.starts_with(['c', 'p']) { "" } else { "--width 8 --samples 1" };
        folder.run(&format!("{line} {small}")).refused(2, &[name, "reads it"]);
    }
    assert_eq!(bytes(), before);
}

/// What was complete before stays, and nobody says that it does not.
#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_said_of_what_did_not_fit() {
    let folder = Folder::new();
    let run = folder.run("render cornell --width 8 --samples 1 -o a.png --json /dev/full");
    run.refused(1, &["/dev/full: the disk is full"]);
    assert_eq!(folder.names(), ["a.png"]);
}

#[test]
fn a_report_goes_into_a_directory() {
    let folder = Folder::new();
    folder.file("file", "as it was");
    let small = "--width 8 --samples 1 -o a.png";
    for path in ["file", "file/page"] {
        let line = format!("render cornell {small} --report {path}");
        folder.run(&line).refused(1, &["file"]);
    }
    // An error behind it takes it away again.
    folder.run(&format!("render cornell {small} --report new/page --json new/page/report.json"));
    assert_eq!(folder.names(), ["file"]);
}

/// A pipe would wait for who writes, a device has no end.
#[cfg(target_os = "linux")]
#[test]
fn only_files_are_read() {
    let folder = Folder::new();
    let kinds = ["rad", "vf", "kilo", "json", "toml", "exr"];
    for kind in kinds {
        let pipe = folder.path().join(format!("pipe.{kind}"));
        assert!(std::process::Command::new("mkfifo").arg(pipe).status().unwrap().success());
        let device = folder.path().join(format!("device.{kind}"));
        std::os::unix::fs::symlink("/dev/zero", device).unwrap();
        fs::create_dir(folder.path().join(format!("folder.{kind}"))).unwrap();
        folder.file(&format!("empty.{kind}"), "");
        let circle = folder.path().join(format!("circle.{kind}"));
        std::os::unix::fs::symlink(&circle, &circle).unwrap();
    }
    let names = ["pipe", "device", "folder", "empty", "circle"];
    for name in names {
        let part = match name {
            "pipe" | "device" => "not a regular file",
            "circle" => "in a circle; make them lead to a file",
            _ => name,
        };
        for line in [
            "compile NAME.rad",
            "compile NAME.kilo",
            "render cornell NAME.vf",
            "render cornell --view NAME.vf",
            "sim cornell --profile NAME.json",
            #[cfg(feature = "host")]
            "host --config NAME.toml",
            "compare NAME.exr NAME.exr",
        ] {
            let line = format!("{} --quiet", line.replace("NAME", name));
            folder.run(&line).refused(1, &[name, part]);
        }
    }
    assert_eq!(folder.names().len(), names.len() * kinds.len(), "something is left behind");
}

/// More than there is: the system says no before anything is begun.
#[cfg(target_os = "linux")]
#[test]
fn what_needs_too_much_memory_is_refused() {
    let folder = Folder::new();
    let faces = "f 1 2 3\n".repeat(6_000_000);
    fs::write(folder.path().join("many.obj"), format!("v 0 0 0\nv 1 0 0\nv 0 1 0\n{faces}"))
        .unwrap();
    for (kib, line, part) in [
        (2_000_000, "render cornell --width 16384 --height 16384", "fewer pixels"),
        (2_000_000, "sim cornell --width 16384 --height 16384", "fewer pixels"),
        (2_000_000, "compile sinc:2236", "fewer surfaces"),
        (2_000_000, "sim cornell --nodes 32768 --width 16", "fewer --nodes"),
        (180_000, "compile many.obj --quiet", "split the scene"),
    ] {
        let script = format!("ulimit -v {kib}; exec \"$0\" {line}");
        let ended = std::process::Command::new("sh")
            .args(["-c", &script])
            .arg(folder.command().get_program())
            .current_dir(folder.path())
            .output()
            .unwrap();
        let message = String::from_utf8_lossy(&ended.stderr);
        assert_eq!(ended.status.code(), Some(1), "{line}: {message}");
        assert!(message.contains("memory") && message.contains(part), "{line}: {message}");
        assert_eq!(message.lines().count(), 1, "{line}: {message}");
    }
    assert_eq!(folder.names(), ["many.obj"], "something is left behind");
}

/// As of a file.
#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_behind_the_standard_output_is_told() {
    let folder = Folder::new();
    for line in ["scenes", "completions bash", "--help"] {
        let full = fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
        let ended = folder.command().args(line.split(' ')).stdout(full).output().unwrap();
        let message = String::from_utf8_lossy(&ended.stderr);
        assert_eq!(ended.status.code(), Some(1), "{line}: {message}");
        assert!(message.starts_with("error: standard output: the disk is full"), "{message}");
    }
}

#[test]
fn the_scenes_are_listed() {
    let folder = Folder::new();
    let table = folder.run("scenes").done().out();
    let json = folder.run("scenes --json").done().out();
    let json: serde_json::Value = serde_json::from_str(&json).unwrap();
    let all = json.as_array().unwrap();
    assert!(all.len() >= 8);
    for scene in all {
        let name = scene["name"].as_str().unwrap();
        assert!(table.contains(name), "{name}");
        assert!(scene["surfaces"].as_u64().unwrap() > 10);
    }
}

#[test]
fn shells_are_completed() {
    let folder = Folder::new();
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let script = folder.run(&format!("completions {shell}")).done().out();
        assert!(
            script.contains("shadow-samples")
                && script.contains("block-replicas")
                && script.contains("kiloray"),
            "{shell}"
        );
        // What nobody types, and names.
        assert!(!script.contains("line-node") && script.contains("stm32f4"), "{shell}");
        for hidden in ["incarnation", "tied"] {
            assert!(!script.contains(hidden), "{shell} offers --{hidden}");
        }
    }
}

/// Words and files as bash offers them.
#[cfg(target_os = "linux")]
#[test]
fn files_are_offered_for_files_alone() {
    let folder = Folder::new();
    folder.file("kiloray.bash", folder.run("completions bash").done().out());
    folder.file("torus-of-a-file.rad", "");
    let offered = |line: &str| {
        let words: Vec<_> = line.split(' ').collect();
        let script = format!(
            "source ./kiloray.bash; COMP_WORDS=({line} t); COMP_CWORD={0}; COMP_LINE='{line} t'; COMP_POINT=${{#COMP_LINE}}; \
             _kiloray kiloray t {1}; printf '%s ' \"${{COMPREPLY[@]}}\"",
            words.len(),
            words[words.len() - 1],
        );
        let mut bash = std::process::Command::new("bash");
        let output = bash.args(["-c", &script]).current_dir(folder.path()).output().unwrap();
        String::from_utf8_lossy(&output.stdout).into_owned()
    };
    assert_eq!(offered("kiloray sim --topology").trim(), "torus tree");
    assert_eq!(offered("kiloray sim --profile").trim(), "t800");
    assert_eq!(offered("kiloray sim --json").trim(), "torus-of-a-file.rad");
    for number in ["--nodes", "--memory", "--crash"] {
        let all = offered(&format!("kiloray sim {number}"));
        assert!(!all.contains("torus-of-a-file"), "{number}: {all}");
    }
}

#[test]
fn a_reader_that_goes_away_is_no_error() {
    let folder = Folder::new();
    for line in ["scenes", "completions bash", "--help", "compile cornell --json -"] {
        let mut child = folder
            .command()
            .args(line.split(' '))
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        drop(child.stdout.take());
        let ended = child.wait_with_output().unwrap();
        assert_eq!(String::from_utf8_lossy(&ended.stderr), "", "{line}");
        assert_eq!(ended.status.code(), Some(0), "{line}");
    }
}
