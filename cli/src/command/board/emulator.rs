//! Boards that QEMU emulates, linked by pairs of sockets.
//!
//! They are of TCP: QEMU writes byte by byte, and waits with all that it does where a socket takes no more, which one of the system's own does after
//! some hundred bytes; two boards would wait for each other.

use std::{
    fs,
    io::{self, BufRead, BufReader},
    net::{Ipv4Addr, TcpListener, TcpStream},
    os::fd::{AsRawFd, OwnedFd},
    path::{Path, PathBuf},
    process::{Child, Command, ExitStatus, Stdio},
    sync::{Arc, Mutex},
    thread,
};

use kiloray_core::network::{HOST, Mesh, NodeId};
use rustix::io::{FdFlags, fcntl_dupfd_cloexec, fcntl_setfd};

use super::firmware::{Board, LINKS};
use crate::failure::{Failure, Outcome};

const QEMU: &str = "qemu-system-arm";

/// A shell that runs a command, and ends it when the other end of its standard input closes: whatever becomes of this process, no board stays behind.
const GUARD: &str = r#"
exec 3<&0
"$@" 3<&- </dev/null & board=$!
{ read -r _ <&3; kill -9 $board; } 2>/dev/null & guard=$!
exec 3<&-
wait $board; status=$?
kill $guard 2>/dev/null
exit $status
"#;

/// Descriptors below this one are the shell's own.
const SHELL_FDS: i32 = 10;

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

/// Whether there is an emulator.
pub(super) fn is_there() -> Outcome {
    let version = Command::new(QEMU).arg("--version").stdout(Stdio::null()).status();
    match version {
        Ok(status) if status.success() => Ok(()),
        Ok(status) => Err(Failure::new(format_args!("{QEMU} --version: {status}"))),
        Err(error) if error.kind() == io::ErrorKind::NotFound => Err(Failure::new(format_args!(
            "{QEMU} is not installed: 'apt install qemu-system-arm', or 'brew install qemu'"
        ))),
        Err(error) => Err(Failure::new(format_args!("{QEMU}: {error}"))),
    }
}

/// Starts the boards, each with its share in flash: they, and the host's ends of its links, port by port.
///
/// The shares are written into `folder`.
pub(super) fn start(
    mesh: &Mesh,
    parts: &[Parts],
    folder: &Path,
) -> Outcome<(Boards, Vec<TcpStream>)> {
    let mut ends = links(mesh).map_err(|error| Failure::new(format_args!("sockets: {error}")))?;
    let mut boards = Boards(Vec::new());
    for (parts, node) in parts.iter().zip(0..) {
        let share = folder.join(format!("node{node}.bin"));
        fs::write(&share, &parts.share).map_err(|error| Failure::io(&share, &error))?;
        let own: Vec<TcpStream> = take(&mut ends, NodeId(node));
        boards.0.push(Emulated::start(parts, &share, own)?);
    }
    Ok((boards, take(&mut ends, HOST)))
}

/// An end of a link: whose it is, and at which of its ports.
type End = (NodeId, u16, TcpStream);

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
                let (near, far_end) = pair()?;
                ends.push((node, port.0, near));
                ends.push((far, back.0, far_end));
            }
        }
    }
    Ok(ends)
}

/// Two sockets that are linked to each other.
fn pair() -> io::Result<(TcpStream, TcpStream)> {
    let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, 0))?;
    let near = TcpStream::connect(listener.local_addr()?)?;
    let far = loop {
        let (far, who) = listener.accept()?;
        // Another process may have been faster.
        if who == near.local_addr()? {
            break far;
        }
    };
    near.set_nodelay(true)?;
    far.set_nodelay(true)?;
    Ok((near, far))
}

/// The ends of a node, by port.
fn take(ends: &mut Vec<End>, node: NodeId) -> Vec<TcpStream> {
    let (mut own, others): (Vec<_>, Vec<_>) = ends.drain(..).partition(|end| end.0 == node);
    *ends = others;
    own.sort_by_key(|end| end.1);
    own.into_iter().map(|end| end.2).collect()
}

impl Emulated {
    fn start(parts: &Parts, share: &Path, links: Vec<TcpStream>) -> Outcome<Self> {
        let Board { name, skipped, share_at, .. } = parts.board;
        let mut command = Command::new("sh");
        command.args(["-c", GUARD, "sh", QEMU, "-M", name, "-display", "none", "-monitor", "none"]);
        command.args(["-semihosting-config", "enable=on,target=native"]);
        command.arg("-kernel").arg(&parts.firmware);
        let share = share.display().to_string().replace(',', ",,");
        command.arg("-device").arg(format!("loader,file={share},addr={share_at:#x},force-raw=on"));
        (0..skipped).for_each(|_| {
            command.args(["-serial", "null"]);
        });
        let links: Vec<OwnedFd> = links
            .iter()
            .map(|link| {
                let link = fcntl_dupfd_cloexec(link, SHELL_FDS)?;
                // For QEMU alone: it closes with this function in this process.
                fcntl_setfd(&link, FdFlags::empty())?;
                Ok(link)
            })
            .collect::<io::Result<_>>()
            .map_err(|error| Failure::new(format_args!("sockets: {error}")))?;
        for (link, index) in links.iter().zip(0..) {
            command.args(["-chardev", &format!("socket,id=link{index},fd={}", link.as_raw_fd())]);
            command.args(["-serial", &format!("chardev:link{index}")]);
        }
        for _ in links.len()..LINKS {
            command.args(["-serial", "null"]);
        }
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut child =
            command.spawn().map_err(|error| Failure::new(format_args!("{QEMU}: {error}")))?;
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
            drop(board.child.stdin.take());
        }
        for board in &mut self.0 {
            let _ = board.child.wait();
        }
    }
}
