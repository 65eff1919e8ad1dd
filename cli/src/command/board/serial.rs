//! Serial ports of this machine, with real boards at their other ends.

use std::{io, os::fd::OwnedFd, path::Path, path::PathBuf, time::Duration};

use kiloray_core::network::{HOST, Mesh};
use rustix::{
    fs::{Mode, OFlags},
    termios::{
        ControlModes, OptionalActions, QueueSelector, ioctl_tiocexcl, tcflush, tcgetattr, tcsetattr,
    },
};

use super::host::Heard;
use crate::failure::{Failure, Outcome};

/// Boards that are on ask for their setup some times a second: after so long without a sound frame something is wrong.
const PATIENCE: Duration = Duration::from_secs(30);

/// The host's ends of the lines of a mesh, in the order of its links.
pub(super) fn open_all(ports: &[PathBuf], baud: u32, mesh: &Mesh) -> Outcome<Vec<OwnedFd>> {
    let ends: Vec<_> = mesh
        .joined(HOST)
        .filter_map(|port| mesh.neighbour(HOST, port))
        .map(|node| node.0.to_string())
        .collect();
    if ports.len() != ends.len() {
        return Err(Failure::usage(format_args!(
            "--serial: the host is at board {}, by a port each: give {}",
            ends.join(" and at board "),
            ends.len()
        )));
    }
    ports.iter().map(|port| open(port, baud).map_err(|error| failure(port, baud, &error))).collect()
}

/// Opens a port for bytes as they are: eight bits, no parity, one stop bit, no handshake, and nobody else at it.
fn open(path: &Path, baud: u32) -> io::Result<OwnedFd> {
    let flags = OFlags::RDWR | OFlags::NOCTTY | OFlags::NONBLOCK | OFlags::CLOEXEC;
    let port = rustix::fs::open(path, flags, Mode::empty())?;
    let mut modes = tcgetattr(&port)?;
    modes.make_raw();
    modes.control_modes.remove(ControlModes::CSTOPB | ControlModes::CRTSCTS);
    modes.control_modes.insert(ControlModes::CREAD | ControlModes::CLOCAL);
    modes.set_speed(baud)?;
    tcsetattr(&port, OptionalActions::Now, &modes)?;
    ioctl_tiocexcl(&port)?;
    tcflush(&port, QueueSelector::IOFlush)?;
    Ok(port)
}

fn failure(port: &Path, baud: u32, error: &io::Error) -> Failure {
    use rustix::io::Errno;
    let is = |errno: Errno| error.raw_os_error() == Some(errno.raw_os_error());
    if is(Errno::NOTTY) {
        Failure::file(port, "this is no serial port")
    } else if is(Errno::INVAL) {
        Failure::file(port, format_args!("the port does not do {baud} baud"))
    } else if is(Errno::BUSY) {
        Failure::file(port, "another program has the port")
    } else {
        Failure::io(port, error)
    }
}

/// Whether lines carry what boards say.
///
/// # Errors
/// One that has ended, or all are silent.
pub(super) fn look(ports: &[PathBuf], baud: u32, heard: &Heard, since: Duration) -> Outcome {
    if let Some(port) = heard.broken.and_then(|line| ports.get(line)) {
        return Err(Failure::file(port, "the line has ended: was the board unplugged?"));
    }
    if heard.frames == 0 && since > PATIENCE {
        let names: Vec<_> = ports.iter().map(|port| port.display().to_string()).collect();
        return Err(Failure::new(format_args!(
            "nobody answers at {}: is the board on and reset, its firmware 'kiloray-node' with its share of the scene, and the line at {baud} baud?",
            names.join(" or ")
        )));
    }
    Ok(())
}
