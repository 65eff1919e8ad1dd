use std::collections::VecDeque;
use std::ffi::OsString;
use std::fs;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStderr, Command, ExitStatus, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};
use std::{io, thread};

use kiloray_core::network::NodeId;
use tempfile::TempDir;

use crate::{Config, Error, Place};

/// How the directory of a supervisor is called: nodes remove no other.
pub(crate) const FOLDER_PREFIX: &str = "kiloray-nodes-";
/// Times in a row that a node may die before it is there.
const DEATHS_MAX: u32 = 5;
/// How long a process may take to be there, and so much more for each node of the mesh, as they share the processors. On two processors with many times
/// as much to do, 64 were there after a second.
const START_LIMITS: [Duration; 2] = [Duration::from_secs(10), Duration::from_millis(100)];
/// Times in a row that a node may be late. Each has twice as long as the one before: frozen ones cost little, and where all are slow few are replaced in vain.
const LATE_MAX: u32 = 2;
/// Lines that are kept of what a node says.
const LINES: usize = 8;
/// Longest line that is kept \[bytes\].
const LINE_BYTES: u64 = 1024;

/// The nodes of one machine: a process for each, which is started, watched, replaced when it dies, and ended with this one.
///
/// Its directory holds the configuration, the sockets and the scene. When the supervisor dies, the nodes see it by the end of
/// their standard input, end, and remove it.
#[derive(Debug)]
pub struct Supervisor {
    program: PathBuf,
    folder: TempDir,
    nodes: Vec<Process>,
    is_over: bool,
}

/// A node that was replaced.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize)]
pub struct Replacement {
    /// Its number.
    pub node: u16,
    /// What became of the process before.
    pub cause: String,
}

#[derive(Debug)]
struct Process {
    child: Child,
    incarnation: u32,
    begun: Instant,
    is_there: bool,
    /// Deaths since one of its processes was there, and how many of them were ended as they were late.
    deaths: u32,
    late: u32,
    said: Arc<Mutex<VecDeque<String>>>,
    reader: Option<JoinHandle<()>>,
}

/// The directory of a mesh on this machine, before its nodes are started.
#[derive(Debug)]
pub struct Folder(TempDir);

impl Folder {
    /// Makes one, for this user alone.
    ///
    /// # Errors
    /// [`Error::Io`].
    pub fn new() -> Result<Self, Error> {
        let folder = tempfile::Builder::new().prefix(FOLDER_PREFIX).tempdir();
        let path = std::env::temp_dir();
        folder.map(Self).map_err(|source| Error::Io { path, source })
    }

    /// Where it is.
    #[must_use]
    pub fn path(&self) -> &Path {
        self.0.path()
    }

    /// Where its nodes listen: sockets in it, that nobody else can reach.
    #[must_use]
    pub fn addresses(&self, nodes: u16) -> Vec<String> {
        let path = self.0.path().display().to_string();
        (0..nodes).map(|node| format!("unixsock-stream/{path}/{node}")).collect()
    }
}

impl Supervisor {
    /// Starts the nodes of a configuration: `program node --config FILE --node N` for each. Once `cancel` is set no more are
    /// started: [`run_host`](crate::run_host) with the same ends soon.
    ///
    /// # Errors
    /// [`Error::Io`] if that cannot be.
    pub fn start(
        program: &Path,
        folder: Folder,
        config: &Config,
        cancel: &AtomicBool,
    ) -> Result<Self, Error> {
        let Folder(folder) = folder;
        let path = folder.path().join(CONFIG);
        fs::write(&path, config.to_text()?).map_err(|source| Error::Io { path, source })?;
        let mut this = Self { program: program.into(), folder, nodes: Vec::new(), is_over: false };
        for node in 0..config.addresses.len() {
            if cancel.load(Ordering::Relaxed) {
                break;
            }
            let process = this.spawn(node as u16, 0)?;
            this.nodes.push(process);
        }
        Ok(this)
    }

    /// The process of each node, by the system's number.
    #[must_use]
    pub fn processes(&self) -> Vec<u32> {
        self.nodes.iter().map(|process| process.child.id()).collect()
    }

    /// A process has taken its place.
    pub(crate) fn is_there(&mut self, node: Place, incarnation: u32) {
        if let Some(process) = self.nodes.get_mut(usize::from(node.id().0))
            && process.incarnation == incarnation
        {
            process.is_there = true;
            (process.deaths, process.late) = (0, 0);
        }
    }

    /// A process is not heard of any more: another takes its place.
    pub(crate) fn silent(
        &mut self,
        node: Place,
        incarnation: u32,
    ) -> Result<Option<Replacement>, Error> {
        let Some(process) = self.nodes.get_mut(usize::from(node.id().0)) else { return Ok(None) };
        if process.incarnation != incarnation {
            return Ok(None);
        }
        self.end(node.id(), "was not heard of any more".into()).map(Some)
    }

    /// Replaces those that have died, or run and are not there for too long: they may have been frozen before anybody could miss them.
    pub(crate) fn look(&mut self, now: Instant) -> Result<Vec<Replacement>, Error> {
        let mut replaced = Vec::new();
        let [least, each] = START_LIMITS;
        let limit = least + each * self.nodes.len() as u32;
        for (at, node) in (0..self.nodes.len()).zip((0..).map(NodeId)) {
            let process = &mut self.nodes[at];
            let limit = limit * 2_u32.pow(process.late);
            match process.child.try_wait() {
                Ok(None) if process.is_there || now - process.begun < limit => {}
                Ok(None) => {
                    let cause = format!("was not there after {} s", limit.as_secs());
                    if process.late == LATE_MAX {
                        return Err(Error::Node { node: Place::new(node), cause });
                    }
                    process.late += 1;
                    replaced.push(self.end(node, cause)?);
                }
                Ok(Some(status)) => replaced.push(self.died(node, Ok(status))?),
                Err(error) => replaced.push(self.died(node, Err(error))?),
            }
        }
        Ok(replaced)
    }

    /// Waits until all have ended by themselves, so long at most; the others are ended.
    pub fn stop(mut self, most: Duration) {
        self.is_over = true;
        let begin = Instant::now();
        for process in &mut self.nodes {
            // Closed: it need not wait for us.
            drop(process.child.stdin.take());
        }
        while begin.elapsed() < most
            && self.nodes.iter_mut().any(|p| matches!(p.child.try_wait(), Ok(None)))
        {
            thread::sleep(Duration::from_millis(5));
        }
    }

    /// Ends a process, as it would go on if it is frozen only; another takes its place.
    fn end(&mut self, node: NodeId, cause: String) -> Result<Replacement, Error> {
        let process = &mut self.nodes[usize::from(node.0)];
        let is_alive = matches!(process.child.try_wait(), Ok(None));
        let _ = process.child.kill();
        let status = process.child.wait();
        if is_alive { self.replace(node, cause) } else { self.died(node, status) }
    }

    /// A process has ended: by what it did itself, or by a signal.
    fn died(&mut self, node: NodeId, status: io::Result<ExitStatus>) -> Result<Replacement, Error> {
        let process = &mut self.nodes[usize::from(node.0)];
        let cause = match &status {
            Ok(status) => status.to_string(),
            Err(error) => error.to_string(),
        };
        // It has said why.
        if status.is_ok_and(|status| status.code().is_some_and(|code| code != 0)) {
            return Err(Error::Node {
                node: Place::new(node),
                cause: process.last_words().unwrap_or(cause),
            });
        }
        self.replace(node, cause)
    }

    fn replace(&mut self, node: NodeId, cause: String) -> Result<Replacement, Error> {
        let at = usize::from(node.0);
        let Process { incarnation, deaths, late, .. } = self.nodes[at];
        let deaths = deaths + 1;
        if deaths > DEATHS_MAX {
            let cause = format!("has died {deaths} times before it was there ({cause})");
            return Err(Error::Node { node: Place::new(node), cause });
        }
        let process = self.spawn(node.0, incarnation + 1)?;
        self.nodes[at] = Process { deaths, late, ..process };
        Ok(Replacement { node: node.0, cause })
    }

    fn spawn(&self, node: u16, incarnation: u32) -> Result<Process, Error> {
        let config = self.folder.path().join(CONFIG);
        let number = |number: u32| OsString::from(number.to_string());
        let mut command = Command::new(&self.program);
        command
            .args(["node".as_ref(), "--config".as_ref(), config.as_os_str()])
            .args(["--node".into(), number(node.into())])
            .args(["--incarnation".into(), number(incarnation), "--tied".into()])
            .stdin(Stdio::piped())
            .stdout(Stdio::null())
            .stderr(Stdio::piped());
        // What is typed to end this process is for this one alone.
        #[cfg(unix)]
        std::os::unix::process::CommandExt::process_group(&mut command, 0);
        let failed = |source| Error::Io { path: self.program.clone(), source };
        let mut child = command.spawn().map_err(failed)?;
        let said = Arc::default();
        let reader = child.stderr.take().map(|stderr| {
            let said = Arc::clone(&said);
            thread::spawn(move || listen(stderr, &said))
        });
        let begun = Instant::now();
        Ok(Process { child, incarnation, begun, is_there: false, deaths: 0, late: 0, said, reader })
    }
}

/// What the configuration is called in the directory.
const CONFIG: &str = "mesh.toml";

impl Process {
    /// The last line that it said.
    fn last_words(&mut self) -> Option<String> {
        // It is dead: all is there.
        if let Some(reader) = self.reader.take() {
            let _ = reader.join();
        }
        let said = self.said.lock().unwrap_or_else(PoisonError::into_inner);
        let last = said.iter().rev().find_map(|line| line.strip_prefix("error: "));
        last.or(said.back().map(String::as_str)).map(|line| format!("says: {line}"))
    }
}

impl Drop for Supervisor {
    /// Ends all that are left.
    fn drop(&mut self) {
        for process in &mut self.nodes {
            let _ = process.child.kill();
        }
        for process in &mut self.nodes {
            let _ = process.child.wait();
        }
    }
}

/// Keeps the last lines that a process says.
fn listen(stderr: ChildStderr, said: &Mutex<VecDeque<String>>) {
    let mut reader = BufReader::new(stderr);
    loop {
        let mut line = Vec::new();
        match io::Read::take(&mut reader, LINE_BYTES).read_until(b'\n', &mut line) {
            Ok(0) | Err(_) => return,
            Ok(_) => {}
        }
        let mut said = said.lock().unwrap_or_else(PoisonError::into_inner);
        if said.len() == LINES {
            said.pop_front();
        }
        said.push_back(String::from_utf8_lossy(&line).trim_end().to_owned());
    }
}
