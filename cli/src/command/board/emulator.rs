//! Boards that QEMU emulates, linked by pairs of sockets.

use std::{
    fs,
    io::{self, BufRead, BufReader},
    os::{fd::AsRawFd, unix::net::UnixStream},
    path::{Path, PathBuf},
    process::{Child, Command, ExitStatus, Stdio},
    sync::{Arc, Mutex},
    thread,
};

use kiloray_core::network::{HOST, Mesh, NodeId};
use rustix::io::{FdFlags, fcntl_setfd};

use super::firmware::{Board, LINKS};
use crate::failure::{Failure, Outcome};

const QEMU: &str = "qemu-system-arm";

/// All boards of a mesh. They end with it.
#[derive(Debug)]
pub(super) struct Boards(Vec<Emulated>);

#[derive(Debug)]
struct Emulated {
    child: Child,
    said: Arc<Mutex<Vec<String>>>,
}

/// What a board is made of.
#[derive(Debug)]
pub(super) struct Parts {
    pub(super) board: Board,
    pub(super) firmware: PathBuf,
    /// The node's share of the scene.
    pub(super) share: Vec<u8>,
}

/// Starts the boards, each with its share in flash: they, and the host's ends of its links, port by port.
///
/// The shares are written into `folder`.
pub(super) fn start(
    mesh: &Mesh,
    parts: &[Parts],
    folder: &Path,
) -> Outcome<(Boards, Vec<UnixStream>)> {
    let mut ends = links(mesh).map_err(|error| Failure::new(format_args!("sockets: {error}")))?;
    let mut boards = Boards(Vec::new());
    for (parts, node) in parts.iter().zip(0..) {
        let share = folder.join(format!("node{node}.bin"));
        fs::write(&share, &parts.share).map_err(|error| Failure::io(&share, &error))?;
        let own: Vec<UnixStream> = take(&mut ends, NodeId(node));
        boards.0.push(Emulated::start(parts, &share, own)?);
    }
    Ok((boards, take(&mut ends, HOST)))
}

/// An end of a link: whose it is, and at which of its ports.
type End = (NodeId, u16, UnixStream);

/// Both ends of all links.
fn links(mesh: &Mesh) -> io::Result<Vec<End>> {
    let mut ends = Vec::new();
    for node in (0..mesh.nodes()).map(NodeId) {
        for port in mesh.joined(node) {
            let (Some(far), Some(back)) = (mesh.neighbour(node, port), mesh.reverse(node, port))
            else {
                continue;
            };
            // Once for both of them.
            if (node, port) < (far, back) {
                let (near, far_end) = UnixStream::pair()?;
                ends.push((node, port.0, near));
                ends.push((far, back.0, far_end));
            }
        }
    }
    Ok(ends)
}

/// The ends of a node, by port.
fn take(ends: &mut Vec<End>, node: NodeId) -> Vec<UnixStream> {
    let (mut own, others): (Vec<_>, Vec<_>) = ends.drain(..).partition(|end| end.0 == node);
    *ends = others;
    own.sort_by_key(|end| end.1);
    own.into_iter().map(|end| end.2).collect()
}

impl Emulated {
    fn start(parts: &Parts, share: &Path, links: Vec<UnixStream>) -> Outcome<Self> {
        let Board { name, skipped, share_at, .. } = parts.board;
        let mut command = Command::new(QEMU);
        command.args(["-M", name, "-display", "none", "-monitor", "none"]);
        command.args(["-semihosting-config", "enable=on,target=native"]);
        command.arg("-kernel").arg(&parts.firmware);
        let share = share.display().to_string().replace(',', ",,");
        command.arg("-device").arg(format!("loader,file={share},addr={share_at:#x},force-raw=on"));
        (0..skipped).for_each(|_| {
            command.args(["-serial", "null"]);
        });
        for (link, index) in links.iter().zip(0..) {
            // For QEMU alone: it closes with this function in this process.
            fcntl_setfd(link, FdFlags::empty())
                .map_err(|error| Failure::new(format_args!("sockets: {error}")))?;
            command.args(["-chardev", &format!("socket,id=link{index},fd={}", link.as_raw_fd())]);
            command.args(["-serial", &format!("chardev:link{index}")]);
        }
        for _ in links.len()..LINKS {
            command.args(["-serial", "null"]);
        }
        command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut child = command.spawn().map_err(|error| match error.kind() {
            io::ErrorKind::NotFound => Failure::new(format_args!(
                "{QEMU} is not installed: 'apt install qemu-system-arm', or 'brew install qemu'"
            )),
            _ => Failure::new(format_args!("{QEMU}: {error}")),
        })?;
        let said = Arc::new(Mutex::new(Vec::new()));
        if let (Some(out), Some(err)) = (child.stdout.take(), child.stderr.take()) {
            listen(out, &said);
            listen(err, &said);
        }
        Ok(Self { child, said })
    }
}

/// Keeps what a board says.
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

impl Boards {
    /// A board that has ended, which none does by itself, and its last word.
    pub(super) fn ended(&mut self) -> Option<(usize, ExitStatus, String)> {
        self.0.iter_mut().enumerate().find_map(|(node, board)| {
            let status = board.child.try_wait().ok().flatten()?;
            let said = board.said.lock().ok()?;
            Some((node, status, said.last().cloned().unwrap_or_default()))
        })
    }
}

impl Drop for Boards {
    fn drop(&mut self) {
        for board in &mut self.0 {
            let _ = board.child.kill();
        }
        for board in &mut self.0 {
            let _ = board.child.wait();
        }
    }
}
