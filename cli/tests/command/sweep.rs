//! `kiloray sweep`.

use std::fs;

use crate::support::Folder;

const SMALL: &str = "--width 16 --height 16 --samples 1 --quiet";

fn lines(folder: &Folder, file: &str) -> Vec<Vec<String>> {
    let text = fs::read_to_string(folder.path().join(file)).expect("a table");
    // No field of these tables holds a comma but the error, which is last.
    text.lines().map(|line| line.split(',').map(str::to_owned).collect()).collect()
}

#[test]
fn all_combinations_are_in_the_table_in_order_and_to_the_byte() {
    let folder = Folder::new();
    let line = format!("sweep cornell --over schedule=hybrid,data --over nodes=1..4 {SMALL}");
    folder.run(&format!("{line} -o a --threads 3 --json a.json")).done();
    folder.run(&format!("{line} -o b --threads 1")).done();
    let table = lines(&folder, "a/sweep.csv");
    let points: Vec<_> = table.iter().map(|row| format!("{} {}", row[0], row[1])).collect();
    assert_eq!(points[0], "schedule nodes");
    assert_eq!(points[1..], ["hybrid 1", "hybrid 2", "hybrid 4", "data 1", "data 2", "data 4"]);
    let column = |name: &str| table[0].iter().position(|head| head == name).unwrap();
    let (hash, efficiency) = (column("image_hash"), column("efficiency"));
    for row in &table[1..] {
        assert_eq!(row[hash], table[1][hash]);
        assert!(row[efficiency].parse::<f64>().unwrap() > 0.0);
    }
    let names = |name: &str| {
        let mut names: Vec<_> = fs::read_dir(folder.path().join(name))
            .unwrap()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    };
    assert_eq!(names("a"), names("b"));
    for name in ["efficiency.svg", "index.html", "speed-up.svg", "sweep.csv", "time.svg"] {
        assert!(names("a").contains(&name.to_owned()), "no {name}");
    }
    for name in names("a") {
        let read =
            |folder_name| fs::read_to_string(folder.path().join(folder_name).join(&name)).unwrap();
        // The page names its command, in which -o and --threads differ.
        let differ = read("a").replace("--threads=3", "--threads=1") != read("b");
        assert!(!differ, "{name} differs");
    }
    let json: serde_json::Value =
        serde_json::from_str(&fs::read_to_string(folder.path().join("a.json")).unwrap()).unwrap();
    assert_eq!(json.as_array().unwrap().len(), 6);
    assert_eq!(json[2]["run"]["nodes"], 4);
}

#[test]
fn efficiency_and_losses_of_a_point_are_all_of_its_time() {
    let folder = Folder::new();
    let line = "--over slow=1:1,1:3 --nodes 4 --topology line --profile t800";
    folder.run(&format!("sweep cornell {SMALL} {line} -o s")).done();
    let table = lines(&folder, "s/sweep.csv");
    let is_part = |head: &str| head == "efficiency" || head.starts_with("lost_");
    for row in &table[1..] {
        let parts =
            table[0].iter().zip(row).filter(|(head, text)| is_part(head) && !text.is_empty());
        let sum: f64 = parts.map(|(_, text)| text.parse::<f64>().unwrap()).sum();
        assert!((sum - 1.0).abs() < 1e-6, "{sum}");
    }
    // The page has them all too, to a tenth of a hundredth.
    let page = fs::read_to_string(folder.path().join("s/index.html")).unwrap();
    let rows: Vec<_> = page.lines().filter(|line| line.starts_with("<tr><th>1:")).collect();
    assert_eq!(rows.len(), table.len() - 1);
    for row in rows {
        let cells = row.split("<td class=\"n\">");
        let parts = cells.filter_map(|cell| cell.strip_suffix(" %")?.parse::<f64>().ok());
        let efficiency: f64 = row.split("<td class=\"n\">").nth(3).unwrap().parse().unwrap();
        let sum = efficiency + parts.sum::<f64>() / 100.0;
        assert!((sum - 1.0).abs() < 0.01, "{sum}: {row}");
    }
}

#[test]
fn an_axis_stands_as_typed_and_in_bytes() {
    let folder = Folder::new();
    let line = "sweep cornell --over memory=128KiB,256KiB --nodes 2 --no-baseline";
    folder.run(&format!("{line} {SMALL} -o out")).done();
    let table = lines(&folder, "out/sweep.csv");
    let column = |name: &str| table[0].iter().position(|head| head == name).unwrap();
    let bytes = column("memory_bytes");
    let points: Vec<_> = table[1..].iter().map(|row| (&*row[0], &*row[bytes])).collect();
    assert_eq!(points, [("128KiB", "131072"), ("256KiB", "262144")]);
}

#[test]
fn one_option_at_a_time_has_plots_for_each() {
    let folder = Folder::new();
    let line = format!("sweep cornell --each --over nodes=1,2 --over prefetch=0,all {SMALL}");
    folder.run(&format!("{line} --nodes 4 -o out")).done();
    let table = lines(&folder, "out/sweep.csv");
    let column = |name: &str| table[0].iter().position(|head| head == name).unwrap();
    let nodes = column("nodes");
    let points: Vec<_> =
        table.iter().map(|row| format!("{} {} {}", row[0], row[1], row[nodes])).collect();
    let expected = ["over value nodes", "nodes 1 1", "nodes 2 2", "prefetch 0 4", "prefetch all 4"];
    assert_eq!(points, expected);
    let page = fs::read_to_string(folder.path().join("out/index.html")).unwrap();
    assert!(page.contains("Over nodes") && page.contains("Over prefetch"));
    for name in ["nodes-speed-up.svg", "prefetch-efficiency.svg"] {
        assert!(folder.path().join("out").join(name).exists(), "no {name}");
    }
}

#[test]
fn plots_of_an_older_sweep_go() {
    let folder = Folder::new();
    let sweep = |over: &str| {
        folder.run(&format!("sweep cornell {over} --nodes 4 {SMALL} -o out")).done();
        let mut names: Vec<_> = fs::read_dir(folder.path().join("out"))
            .unwrap()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    };
    let first = sweep("--over schedule=hybrid,data");
    assert!(first.contains(&"speed-up.svg".to_owned()), "{first:?}");
    folder.file("out/mine.svg", "no plot");
    let each = sweep("--each --over prefetch=0,all");
    assert!(each.contains(&"prefetch-speed-up.svg".to_owned()), "{each:?}");
    assert!(each.contains(&"mine.svg".to_owned()) && !each.contains(&"speed-up.svg".to_owned()));
    let mut again = sweep("--over schedule=hybrid,data");
    again.retain(|name| name != "mine.svg");
    assert_eq!(again, first);
}

#[test]
fn an_axis_takes_the_place_of_what_was_typed_of_its_option() {
    let folder = Folder::new();
    let line = "sweep cornell --slow 1:2 --over slow=1:3,0:2 --nodes 2 --no-baseline --json -";
    let out = folder.run(&format!("{line} {SMALL}")).done().out();
    let all: serde_json::Value = serde_json::from_str(&out).unwrap();
    let slow = |point: usize| all[point]["run"]["options"]["slow"].clone();
    let one = |node: u16, factor: f64| serde_json::json!([{ "node": node, "factor": factor }]);
    assert_eq!([slow(0), slow(1)], [one(1, 3.0), one(0, 2.0)]);
}

#[test]
fn a_point_that_fails_stops_no_other() {
    let folder = Folder::new();
    let line =
        format!("sweep cornell --over memory=1KiB,64KiB --nodes 2 {SMALL} --no-baseline -o out");
    folder.run(&line).refused(1, &["1 of 2 points failed", "sweep.csv"]);
    let table = lines(&folder, "out/sweep.csv");
    assert!(
        table[1].last().unwrap().contains("give more") || table[1].join(",").contains("too small")
    );
    assert_eq!(table[2].last().unwrap(), "");
    let page = fs::read_to_string(folder.path().join("out/index.html")).unwrap();
    assert!(page.contains("Points that failed") && page.contains("too small"));
}

#[test]
fn a_scene_that_cannot_be_had_is_the_error_of_its_points() {
    let folder = Folder::new();
    for lights in ["1,100", "100,1"] {
        let line = format!("sweep glass --over lights={lights} --nodes 2 {SMALL} --no-baseline");
        folder.run(&format!("{line} -o out")).refused(1, &["1 of 2 points failed"]);
        for row in &lines(&folder, "out/sweep.csv")[1..] {
            let refused = row.join(",").contains("3 lights, and at most 1");
            assert_eq!(refused, row[0] == "1", "{row:?}");
        }
        fs::remove_dir_all(folder.path().join("out")).unwrap();
    }
    // The size that memory gives is none that was asked for.
    folder.run("compile cornell --block 16KiB -o c.kilo -q").done();
    let line = format!("sweep c.kilo --each --over nodes=1 --over block=4KiB {SMALL}");
    folder.run(&format!("{line} --no-baseline -o out")).refused(1, &["1 of 2 points failed"]);
    assert!(lines(&folder, "out/sweep.csv")[2].join(",").contains("leave out --block"));
    // Without any there is nothing to sweep over.
    let line = format!("sweep glass --lights 1 --over nodes=1,2 {SMALL} -o none");
    folder.run(&line).refused(1, &["3 lights, and at most 1"]);
    assert!(!folder.names().contains(&"none".to_owned()));
}

/// The runs that points are compared with are none.
#[cfg(unix)]
#[test]
fn its_bar_counts_points() {
    use std::io::Read;

    use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};

    let folder = Folder::new();
    let near = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY).expect("a pseudo-terminal");
    grantpt(&near).and_then(|()| unlockpt(&near)).expect("it is ours");
    let name = ptsname(&near, Vec::new()).expect("it has a name").into_string().expect("of text");
    let far = fs::File::options().read(true).write(true).open(name).expect("it opens");
    let mut command = folder.command();
    command.args("sweep cornell --over nodes=1,2 --width 16 --samples 1".split(' '));
    let mut child =
        command.stdout(std::process::Stdio::null()).stderr(far).spawn().expect("it starts");
    drop(command);
    // What reads from a terminal that nobody holds any more has an error, not an end.
    let mut shown = Vec::new();
    let _ = fs::File::from(near).read_to_end(&mut shown);
    assert!(child.wait().expect("it ends").success());
    let shown = String::from_utf8_lossy(&shown);
    assert!(shown.contains("0 of 2 points"), "{shown}");
    assert!(!shown.contains("of 3 points") && !shown.contains("3/"), "{shown}");
}

#[test]
fn senseless_sweeps_are_refused_in_one_line() {
    let folder = Folder::new();
    for (line, part) in [
        ("--over nodes", "nodes=1..256"),
        ("--over banana=1", "memory"),
        ("--over nodes=8..1", "upwards"),
        ("--over nodes=1 --over nodes=2", "twice"),
        ("--over memory=banana", "64KiB"),
        ("--over schedule=hybrid,fast", "demand"),
        ("--over packet=128B,512B", "280B"),
        ("--over threads=1,2", "'threads' is no option to vary"),
        ("--over exposure=0,1", "'exposure' is no option to vary"),
        ("--over nodes=1,2 --report page", "-o"),
        (
            "--over seed=1..1024 --over samples=1..1024 --over bounces=0,1,2,3 --over nodes=1..32768 --over memory=1KiB..1GiB",
            "20000",
        ),
    ] {
        folder.run(&format!("sweep cornell {line}")).refused(2, &[part]);
    }
    assert!(folder.names().is_empty(), "something is left behind");
}
