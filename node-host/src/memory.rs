use serde::{Deserialize, Serialize};

use crate::Error;

/// What a node's process holds beside its arena and its blocks: the program, the network and their threads.
///
/// Measured: 26 to 36 MiB with up to 16 neighbours, most of it stacks of threads that are reserved and not used, so that the resident set is less. One that runs away
/// soon holds more.
pub const PROCESS_BYTES: usize = 64 << 20;

/// What a node's process holds, as the system counts it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct ProcessMemory {
    /// What it may hold: its arena, the blocks that it maps, and [`PROCESS_BYTES`] \[bytes\].
    pub budget_bytes: u64,
    /// The most that it ever held in memory at a time \[bytes\]; left out where the system does not tell.
    pub peak_bytes: Option<u64>,
    /// Of this, at the end, what is in no file: its arena and all else that it has written \[bytes\].
    pub own_bytes: Option<u64>,
    /// What the system would let it write at most \[bytes\]; left out where it is not enforced.
    pub limit_bytes: Option<u64>,
}

impl ProcessMemory {
    /// Of this process, which maps so many bytes of blocks and has an arena of `memory` bytes.
    pub(crate) fn now(memory: usize, mapped: u64, enforce: bool) -> Self {
        let own = own_limit(memory);
        let (peak_bytes, own_bytes) = resident();
        Self {
            budget_bytes: own + mapped,
            peak_bytes,
            own_bytes,
            limit_bytes: enforce.then_some(own),
        }
    }
}

/// Has the system refuse this process memory beyond an arena of so many bytes and [`PROCESS_BYTES`]: what would be more ends it.
///
/// # Errors
/// [`Error::Options`] where the system does not do so.
pub(crate) fn enforce(memory: usize) -> Result<(), Error> {
    limit(own_limit(memory))
}

fn own_limit(memory: usize) -> u64 {
    (memory + PROCESS_BYTES) as u64
}

/// Bounds what this process can write of memory of its own. Files that are mapped do not count, nor what is reserved and not used yet.
#[cfg(target_os = "linux")]
fn limit(bytes: u64) -> Result<(), Error> {
    use rustix::process::{Resource, Rlimit, setrlimit};
    let limit = Rlimit { current: Some(bytes), maximum: Some(bytes) };
    setrlimit(Resource::Data, limit).map_err(|error| {
        Error::Options(format!("--enforce: the memory cannot be limited: {error}"))
    })
}

#[cfg(not(target_os = "linux"))]
fn limit(_: u64) -> Result<(), Error> {
    Err(Error::Options("--enforce: this system does not limit the memory of a process".into()))
}

/// The most that this process had in memory, and what of it is in no file \[bytes\].
#[cfg(target_os = "linux")]
fn resident() -> (Option<u64>, Option<u64>) {
    let status = procfs::process::Process::myself().and_then(|process| process.status());
    let bytes = |kibibytes: Option<u64>| kibibytes.map(|kibibytes| kibibytes << 10);
    status.map_or((None, None), |status| (bytes(status.vmhwm), bytes(status.rssanon)))
}

#[cfg(not(target_os = "linux"))]
fn resident() -> (Option<u64>, Option<u64>) {
    (None, None)
}

#[cfg(all(test, target_os = "linux"))]
mod tests {
    use std::os::unix::process::ExitStatusExt;
    use std::process::{Command, Output};

    use super::*;

    /// How much a process of this test writes.
    const GROW: &str = "KILORAY_TEST_GROW";

    #[test]
    fn a_process_that_exceeds_its_limit_dies_and_does_not_grow() {
        if let Ok(bytes) = std::env::var(GROW) {
            enforce(1 << 20).expect("a limit");
            let held = vec![1_u8; bytes.parse().expect("a number")];
            println!("held {}", held.iter().map(|&byte| usize::from(byte)).sum::<usize>());
            return;
        }
        let name = "memory::tests::a_process_that_exceeds_its_limit_dies_and_does_not_grow";
        let grown = |bytes: usize| -> Output {
            let program = std::env::current_exe().expect("this program");
            let mut command = Command::new(program);
            command.args([name, "--exact", "--nocapture"]).env(GROW, bytes.to_string());
            command.output().expect("it runs")
        };
        let holds = |output: &Output, bytes: usize| {
            String::from_utf8_lossy(&output.stdout).contains(&format!("held {bytes}"))
        };
        let less = grown(PROCESS_BYTES / 4);
        assert!(less.status.success() && holds(&less, PROCESS_BYTES / 4), "{less:?}");
        let more = grown(2 * PROCESS_BYTES);
        assert!(!holds(&more, 2 * PROCESS_BYTES), "{more:?}");
        assert_eq!(more.status.signal(), Some(6), "{more:?}");
    }
}
