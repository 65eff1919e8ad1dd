//! What the tests share: a directory, and the command in it.

use std::{
    fs,
    path::{Path, PathBuf},
    process::{Command, Output},
    thread,
    time::{Duration, Instant},
};

use serde_json::Value;
use tempfile::TempDir;

/// What scripts rely on in the JSON of any run: fields in fields behind dots.
pub(crate) const FIELDS: [&str; 32] = [
    "version",
    "options",
    "image_hash",
    "width",
    "height",
    "nodes",
    "time_s",
    "virtual_time_s",
    "efficiency",
    "position_error",
    "rays.primary",
    "rays.shadow",
    "rays.specular",
    "rays.ambient",
    "skipped",
    "messages.count",
    "messages.bytes",
    "blocks.count",
    "blocks.bytes",
    "blocks.fetched",
    "memory.limit",
    "memory.peak",
    "memory.peak_node",
    "points.capacity",
    "points.peak",
    "cache.hits",
    "cache.misses",
    "cache.evictions",
    "retries",
    "refusals",
    "lost",
    "faults",
];

/// A field of a run's JSON.
pub(crate) fn field<'v>(run: &'v Value, name: &str) -> Option<&'v Value> {
    name.split('.').try_fold(run, |value, name| value.get(name))
}

pub(crate) fn json(path: &Path) -> Value {
    serde_json::from_str(&fs::read_to_string(path).expect("a JSON file")).expect("JSON")
}

/// An empty directory in which the command runs.
pub(crate) struct Folder(TempDir);

impl Folder {
    pub(crate) fn new() -> Self {
        Self(tempfile::tempdir().expect("a temporary directory"))
    }

    pub(crate) fn path(&self) -> &Path {
        self.0.path()
    }

    pub(crate) fn file(&self, name: &str, text: impl AsRef<[u8]>) -> PathBuf {
        let path = self.path().join(name);
        fs::write(&path, text).expect("a file is written");
        path
    }

    /// Names of all files in it.
    pub(crate) fn names(&self) -> Vec<String> {
        let mut names: Vec<_> = fs::read_dir(self.path())
            .expect("the directory")
            .map(|entry| entry.expect("an entry").file_name().to_string_lossy().into_owned())
            .collect();
        names.sort();
        names
    }

    pub(crate) fn command(&self) -> Command {
        let mut command = Command::new(assert_cmd::cargo::cargo_bin!("kiloray"));
        command.current_dir(self.path());
        command
    }

    /// Runs a line of arguments.
    pub(crate) fn run(&self, line: &str) -> Ran {
        let arguments = line.split(' ').filter(|word| !word.is_empty());
        Ran(self.command().args(arguments).output().expect("the command runs"), line.into())
    }

    /// Runs a line that renders, and reads what it says of the run.
    pub(crate) fn counted(&self, line: &str) -> Value {
        self.run(&format!("{line} --quiet --json run.json")).done();
        json(&self.path().join("run.json"))
    }
}

/// What came of a run.
pub(crate) struct Ran(Output, String);

impl Ran {
    pub(crate) fn code(&self) -> Option<i32> {
        self.0.status.code()
    }

    pub(crate) fn out(&self) -> String {
        String::from_utf8_lossy(&self.0.stdout).into_owned()
    }

    pub(crate) fn err(&self) -> String {
        String::from_utf8_lossy(&self.0.stderr).into_owned()
    }

    /// It ended well.
    #[track_caller]
    pub(crate) fn done(self) -> Self {
        assert_eq!(self.code(), Some(0), "{}: {}", self.1, self.err());
        self
    }

    /// It ended with this code and one line that has all these parts in it.
    #[track_caller]
    pub(crate) fn refused(self, code: i32, parts: &[&str]) -> Self {
        let message = self.err();
        assert_eq!(self.code(), Some(code), "{}: {message}", self.1);
        assert!(message.starts_with("error: "), "{}: {message}", self.1);
        assert_eq!(message.lines().count(), 1, "{}: {message}", self.1);
        for part in parts {
            assert!(message.contains(part), "{}: no '{part}' in: {message}", self.1);
        }
        self
    }
}

/// Whether a process has ended.
pub(crate) fn is_gone(process: u32) -> bool {
    // Nobody may have asked how it ended yet.
    let state = fs::read_to_string(format!("/proc/{process}/stat")).unwrap_or_default();
    state.is_empty() || state.contains(") Z ")
}

/// The time that a process has worked (1/100 s).
#[cfg(feature = "host")]
pub(crate) fn worked(process: u32) -> u64 {
    let stat = fs::read_to_string(format!("/proc/{process}/stat")).unwrap_or_default();
    let behind_name = stat.rsplit_once(')').map_or("", |(_, rest)| rest);
    behind_name.split_whitespace().nth(11).and_then(|ticks| ticks.parse().ok()).unwrap_or(0)
}

/// Sends a signal.
pub(crate) fn signal(name: &str, process: u32) {
    let command = format!("kill {name} {process}");
    let sent = Command::new("sh").args(["-c", &command]).status().expect("there is a shell");
    assert!(sent.success(), "{command}");
}

/// Waits until something is so; for ever is too long.
#[track_caller]
pub(crate) fn until(is_so: impl FnMut() -> bool) {
    assert!(within(Duration::from_secs(60), is_so), "it takes too long");
}

/// Whether something comes to be so within a time.
pub(crate) fn within(limit: Duration, mut is_so: impl FnMut() -> bool) -> bool {
    let begin = Instant::now();
    while !is_so() {
        if begin.elapsed() > limit {
            return false;
        }
        thread::yield_now();
    }
    true
}
