//! Notes on memories in which few blocks are at hand.

use serde_json::Value;

use crate::support::Folder;

const SMALL: &str = "--width 8 --height 8 --samples 1";

/// What is said of few blocks, on the standard error.
fn noted(folder: &Folder, line: &str) -> Option<String> {
    let told = folder.run(line).done().err();
    told.lines().find(|line| line.contains("has room for")).map(str::to_owned)
}

#[test]
fn few_frames_are_noted_with_a_memory_that_has_enough() {
    let folder = Folder::new();
    for (little, enough) in [
        (format!("sim glass {SMALL} --nodes 4 --no-baseline"), "64KiB"),
        (format!("render sinc:60 {SMALL}"), "64KiB"),
        ("plan colour-cube --nodes 16".into(), "256KiB"),
        ("plan glass --block 16KiB".into(), "256KiB"),
    ] {
        assert_eq!(noted(&folder, &format!("{little} --memory {enough}")), None, "{little}");
        let least = folder.run(&format!("{little} --memory 1KiB")).err();
        let (_, least) = least.split_once("at least ").expect("a memory is needed");
        let (least, _) = least.split_once(' ').expect("a unit");
        let told = noted(&folder, &format!("{little} --memory {least}"));
        let told = told.unwrap_or_else(|| panic!("{little}: no note at {least}"));
        assert!(told.starts_with("note: a node of "), "{told}");
        let (_, advised) = told.rsplit_once("give ").expect("what to give");
        assert_eq!(noted(&folder, &format!("{little} --memory {advised}")), None, "{little}");
    }
}

#[test]
fn the_note_is_in_the_json_and_not_said_in_quiet() {
    let folder = Folder::new();
    for line in
        ["render sinc:60 --memory 12KiB", "sim sinc:60 --nodes 16 --topology full --memory 16KiB"]
    {
        let ran = folder.run(&format!("{line} {SMALL} --quiet --json run.json")).done();
        assert_eq!(ran.err(), "");
        let run: Value = crate::support::json(&folder.path().join("run.json"));
        let notes = run["notes"].as_array().expect("notes");
        let is_it = |note: &Value| note.as_str().is_some_and(|n| n.contains("has room for"));
        assert!(notes.iter().any(is_it), "{line}: {notes:?}");
    }
}
