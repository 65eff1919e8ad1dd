//! `kiloray board --serial`: the nodes are processes, and pseudo-terminals the serial ports that lead to them.

use std::{
    fs::File,
    io::IoSlice,
    mem::MaybeUninit,
    os::{
        fd::{AsFd, BorrowedFd, OwnedFd},
        unix::{ffi::OsStringExt, net::UnixStream},
    },
    path::{Path, PathBuf},
    process::{Child, Stdio},
};

use rustix::{
    io::{FdFlags, fcntl_setfd},
    net::{SendAncillaryBuffer, SendAncillaryMessage, SendFlags, sendmsg},
    pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt},
    termios::{LocalModes, tcgetattr},
};

use crate::support::{Folder, until};

/// A port, and what is at its other end.
struct Port {
    name: PathBuf,
    /// Without anybody at it the port would be gone.
    _held: File,
    far: OwnedFd,
}

impl Port {
    fn new() -> Self {
        let far = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY).expect("a pseudo-terminal");
        // The command must not keep its own line open.
        fcntl_setfd(&far, FdFlags::CLOEXEC).expect("it can be kept to ourselves");
        grantpt(&far).and_then(|()| unlockpt(&far)).expect("it is ours");
        let name = ptsname(&far, Vec::new()).expect("it has a name").into_bytes();
        let name = PathBuf::from(std::ffi::OsString::from_vec(name));
        let held = File::options().read(true).write(true).open(&name).expect("it opens");
        Self { name, _held: held, far }
    }
}

/// What `kiloray board` starts for a node that is a process. It ends with the socket.
fn node(folder: &Folder, share: &Path, lines: &[BorrowedFd<'_>]) -> (Child, UnixStream) {
    let (near, far) = UnixStream::pair().expect("sockets");
    let mut command = folder.command();
    command.args(["line-node", "--memory", "65536", "--share"]).arg(share);
    let child = command.stdin(OwnedFd::from(far)).stderr(Stdio::inherit()).spawn();
    let mut space = [MaybeUninit::uninit(); rustix::cmsg_space!(ScmRights(3))];
    let mut control = SendAncillaryBuffer::new(&mut space);
    assert!(control.push(SendAncillaryMessage::ScmRights(lines)));
    sendmsg(&near, &[IoSlice::new(&[0])], &mut control, SendFlags::empty()).expect("it is sent");
    (child.expect("it starts"), near)
}

#[test]
fn boards_at_serial_ports_give_the_bits_of_one_machine() {
    let folder = Folder::new();
    let picture = "--block 1KiB --width 16 --height 12 --samples 1";
    let expected = folder.counted(&format!("render glass {picture}"))["image_hash"].clone();

    let (left, right) = UnixStream::pair().expect("sockets");
    let ports = [Port::new(), Port::new()];
    let mut nodes = Vec::new();
    for (own, line) in [left.as_fd(), right.as_fd()].into_iter().enumerate() {
        let share = folder.path().join(format!("node{own}.bin"));
        let compile = "compile glass --block 1KiB --nodes 2 --quiet";
        folder.run(&format!("{compile} --for-node {own} -o {}", share.display())).done();
        nodes.push(node(&folder, &share, &[line, ports[own].far.as_fd()]));
    }
    let names = ports.each_ref().map(|port| port.name.display().to_string()).join(",");
    let boards = format!("--serial {names} --boards 2 --topology line");
    let run = folder.counted(&format!("board glass {picture} {boards}"));
    assert_eq!((&run["image_hash"], &run["nodes"]), (&expected, &2.into()));
    assert_eq!(run["differing"], 0);
    for (mut child, tie) in nodes {
        drop(tie);
        let _ = child.wait();
    }
}

#[test]
fn a_port_that_leads_nowhere_is_refused() {
    let folder = Folder::new();
    folder.file("file", "");
    folder.run("board cornell --serial nowhere").refused(1, &["nowhere", "no such file"]);
    folder.run("board cornell --serial file").refused(1, &["file", "no serial port"]);
    folder
        .run("board cornell --serial a --boards 4")
        .refused(2, &["--serial", "board 0 and at board 2", "give 2"]);
    folder.run("board cornell --serial a --qemu 2").refused(2, &["--serial", "--qemu"]);
    folder.run("board cornell --boards 2").refused(2, &["--serial"]);
    folder.run("board cornell --serial a --baud 7").refused(2, &["--baud", "300"]);
}

#[test]
fn a_port_whose_board_is_unplugged_says_so() {
    let folder = Folder::new();
    let Port { name, _held: held, far } = Port::new();
    let mut command = folder.command();
    command.args(["board", "cornell", "--quiet", "--serial"]).arg(&name);
    let run = command.stderr(Stdio::piped()).spawn().expect("it starts");
    // Whoever opens the port wants its bytes as they are.
    until(|| tcgetattr(&held).is_ok_and(|modes| !modes.local_modes.contains(LocalModes::ICANON)));
    drop(held);
    drop(far);
    let ended = run.wait_with_output().expect("it ends");
    let said = String::from_utf8_lossy(&ended.stderr).into_owned();
    assert_eq!(ended.status.code(), Some(1), "{said}");
    assert!(said.contains(&format!("{}: the line has ended", name.display())), "{said}");
}
