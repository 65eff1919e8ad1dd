//! The nodes of a mesh: boards that are emulated, and processes.

use std::{
    fs, io,
    io::{BufRead, BufReader},
    os::unix::{net::UnixStream, process::ExitStatusExt},
    path::{Path, PathBuf},
    process::{Child, ExitStatus},
    sync::{Arc, Mutex},
    thread,
};

use kiloray_core::network::{HOST, Mesh, NodeId};

use super::{emulator, firmware::Board, lines::Lines, process};
use crate::failure::{Failure, Outcome};

/// A shell says of what a signal has ended that its status is this and the signal's number.
const SIGNALLED: i32 = 128;
/// The signal of those who want the end of something.
const KILLED: i32 = 9;

/// All nodes of a mesh. They end with it.
#[derive(Debug)]
pub(super) struct Nodes {
    mesh: Mesh,
    replicas: u16,
    all: Vec<Running>,
    dead: Vec<NodeId>,
}

#[derive(Debug)]
struct Running {
    child: Child,
    /// It ends when this is closed, or its standard input.
    tie: Option<UnixStream>,
    said: Arc<Mutex<Vec<String>>>,
}

/// What a node is made of.
#[derive(Debug)]
pub(super) struct Parts {
    pub(super) kind: Kind,
    /// The node's share of the scene.
    pub(super) share: Vec<u8>,
}

/// What a node is.
#[derive(Debug)]
pub(super) enum Kind {
    /// A board with its firmware.
    Board(Board, PathBuf),
    /// A process with so much memory for its node \[bytes\].
    Process(usize),
}

impl Nodes {
    /// Starts them, each with its share and its lines. The shares are written into `folder`.
    pub(super) fn start(
        mesh: &Mesh,
        replicas: u16,
        parts: &[Parts],
        lines: &mut Lines,
        folder: &Path,
    ) -> Outcome<Self> {
        let mut nodes = Self { mesh: *mesh, replicas, all: Vec::new(), dead: Vec::new() };
        for (parts, node) in parts.iter().zip(0..) {
            let share = folder.join(format!("node{node}.bin"));
            fs::write(&share, &parts.share).map_err(|error| Failure::io(&share, &error))?;
            let lines = lines.take(NodeId(node));
            let (mut child, tie) = match &parts.kind {
                Kind::Board(board, firmware) => {
                    (emulator::start(board, firmware, &share, &lines)?, None)
                }
                Kind::Process(memory) => {
                    let started = process::start(*memory, &share, &lines);
                    let (child, tie) = started
                        .map_err(|error| Failure::new(format_args!("a process: {error}")))?;
                    (child, Some(tie))
                }
            };
            let said = Arc::default();
            if let Some(out) = child.stdout.take() {
                listen(out, &said);
            }
            if let Some(err) = child.stderr.take() {
                listen(err, &said);
            }
            nodes.all.push(Running { child, tie, said });
        }
        Ok(nodes)
    }

    /// Those that died, while the run goes on.
    pub(super) fn dead(&self) -> &[NodeId] {
        &self.dead
    }

    /// What each has said, by node.
    pub(super) fn said(&self) -> Vec<Vec<String>> {
        let said = |node: &Running| node.said.lock().map(|said| said.clone()).unwrap_or_default();
        self.all.iter().map(said).collect()
    }

    /// Looks who has ended; `are_heard` says that the mesh has begun to work.
    ///
    /// # Errors
    /// One that has said why, or without which the picture may never be complete.
    pub(super) fn look(&mut self, are_heard: bool) -> Outcome {
        for (running, node) in self.all.iter_mut().zip((0..).map(NodeId)) {
            if self.dead.contains(&node) {
                continue;
            }
            let Some(status) = running.child.try_wait().ok().flatten() else { continue };
            self.dead.push(node);
            let cause = match signal(status) {
                None => Some(running.last_words()),
                // It was not fit to run, and with copies of its blocks would not be either.
                Some(signal) if !are_heard && signal != KILLED => Some(running.last_words()),
                Some(_) if self.dead.len() >= usize::from(self.replicas) => Some(format!(
                    "with it the last copy of some blocks may be lost: --block-replicas {}",
                    self.dead.len() + 1
                )),
                Some(_) => cut(&self.mesh, &self.dead)
                    .map(|(a, b)| format!("the way from {} to {} led over it", name(a), name(b))),
            };
            if let Some(cause) = cause {
                let status = match signal(status) {
                    Some(signal) => format!("signal {signal}"),
                    None => status.to_string(),
                };
                let cause = if cause.is_empty() { cause } else { format!(": {cause}") };
                return Err(Failure::new(format_args!(
                    "node {} has ended ({status}){cause}",
                    node.0
                )));
            }
        }
        Ok(())
    }
}

/// The signal that has ended it.
fn signal(status: ExitStatus) -> Option<i32> {
    let by_shell = |code: i32| code.checked_sub(SIGNALLED).filter(|&signal| signal > 0);
    status.signal().or_else(|| status.code().and_then(by_shell))
}

/// Two that live, with a dead one on the way from the one to the other.
fn cut(mesh: &Mesh, dead: &[NodeId]) -> Option<(NodeId, NodeId)> {
    let living: Vec<_> =
        (0..mesh.nodes()).map(NodeId).chain([HOST]).filter(|node| !dead.contains(node)).collect();
    let is_cut = |from, to| {
        let mut at = from;
        while let Some(next) = mesh.route(at, to).and_then(|hop| mesh.neighbour(at, hop.port)) {
            if dead.contains(&next) {
                return true;
            }
            at = next;
        }
        false
    };
    let mut ways = living.iter().flat_map(|&from| living.iter().map(move |&to| (from, to)));
    ways.find(|&(from, to)| is_cut(from, to))
}

fn name(node: NodeId) -> String {
    if node == HOST { "the host".into() } else { format!("node {}", node.0) }
}

impl Running {
    fn last_words(&self) -> String {
        let Ok(said) = self.said.lock() else { return String::new() };
        // Registers come behind what is fatal to QEMU, and a word of the shell.
        let fatal = said.iter().rev().find(|line| line.contains("fatal: "));
        let last = fatal.or(said.last()).map_or("", String::as_str);
        last.strip_prefix("error: ").unwrap_or(last).to_owned()
    }
}

/// Keeps what a node says.
fn listen(from: impl io::Read + Send + 'static, said: &Arc<Mutex<Vec<String>>>) {
    let said = Arc::clone(said);
    thread::spawn(move || {
        for line in BufReader::new(from).lines().map_while(Result::ok) {
            if let Ok(mut said) = said.lock() {
                said.push(line);
            }
        }
    });
}

impl Drop for Nodes {
    fn drop(&mut self) {
        for node in &mut self.all {
            drop((node.child.stdin.take(), node.tie.take()));
        }
        for node in &mut self.all {
            let _ = node.child.wait();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use kiloray_core::network::Topology;
    use std::process::{Command, Stdio};

    /// A mesh of one that says something, and is ended by a signal.
    fn dying(signal: &str) -> Nodes {
        let script =
            format!("echo qemu: fatal: no such instruction >&2; echo R00=0 >&2; kill -{signal} $$");
        let mut command = Command::new("sh");
        let mut child =
            command.args(["-c", &script]).stderr(Stdio::piped()).spawn().expect("it starts");
        let said = Arc::default();
        listen(child.stderr.take().expect("a pipe"), &said);
        child.wait().expect("it ends");
        while said.lock().expect("it is whole").len() < 2 {
            thread::yield_now();
        }
        let mesh = Mesh::new(Topology::parse("line", 1).expect("a topology"));
        Nodes { mesh, replicas: 1, all: vec![Running { child, tie: None, said }], dead: Vec::new() }
    }

    #[test]
    fn one_that_dies_unheard_has_its_last_words_told() {
        let told = |signal, are_heard| match dying(signal).look(are_heard) {
            Err(Failure::Failed(message)) => message,
            other => panic!("{other:?}"),
        };
        assert_eq!(
            told("ABRT", false),
            "node 0 has ended (signal 6): qemu: fatal: no such instruction"
        );
        // One that has worked, and one that somebody has ended.
        for (signal, are_heard) in [("ABRT", true), ("KILL", false)] {
            assert!(told(signal, are_heard).contains("--block-replicas 2"), "{signal}");
        }
    }

    #[test]
    fn a_ring_is_cut_by_any_death_and_a_full_mesh_by_that_of_the_first() {
        let cut = |name, nodes, dead| {
            let mesh = Mesh::new(Topology::parse(name, nodes).expect("a topology"));
            cut(&mesh, &[NodeId(dead)]).is_some()
        };
        assert_eq!([0, 1, 2, 3].map(|dead| cut("ring", 4, dead)), [true; 4]);
        // The last is joined to the host too, and nobody else uses that way.
        assert_eq!([0, 1, 2].map(|dead| cut("full", 3, dead)), [true, false, false]);
        assert!(!cut("line", 2, 1), "its only neighbour has a line to the host");
    }
}
