//! Boards that QEMU emulates.

use std::{
    io,
    net::TcpStream,
    os::{
        fd::{AsRawFd, OwnedFd},
        unix::process::CommandExt,
    },
    path::Path,
    process::{Child, Command, Stdio},
};

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

/// Starts a board with its share in flash, and its lines by port. It ends when its standard input is closed.
pub(super) fn start(
    board: &Board,
    firmware: &Path,
    share: &Path,
    lines: &[TcpStream],
) -> Outcome<Child> {
    let Board { name, skipped, share_at, .. } = *board;
    let mut command = Command::new("sh");
    command.args(["-c", GUARD, "sh", QEMU, "-M", name, "-display", "none", "-monitor", "none"]);
    command.args(["-semihosting-config", "enable=on,target=native"]);
    command.arg("-kernel").arg(firmware);
    let share = share.display().to_string().replace(',', ",,");
    command.arg("-device").arg(format!("loader,file={share},addr={share_at:#x},force-raw=on"));
    (0..skipped).for_each(|_| {
        command.args(["-serial", "null"]);
    });
    let lines: Vec<OwnedFd> = lines
        .iter()
        .map(|line| {
            let line = fcntl_dupfd_cloexec(line, SHELL_FDS)?;
            // For QEMU alone: it closes with this function in this process.
            fcntl_setfd(&line, FdFlags::empty())?;
            Ok(line)
        })
        .collect::<io::Result<_>>()
        .map_err(|error| Failure::new(format_args!("sockets: {error}")))?;
    for (line, index) in lines.iter().zip(0..) {
        command.args(["-chardev", &format!("socket,id=link{index},fd={}", line.as_raw_fd())]);
        command.args(["-serial", &format!("chardev:link{index}")]);
    }
    for _ in lines.len()..LINKS {
        command.args(["-serial", "null"]);
    }
    command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
    // What is typed to end this process is for this one alone.
    command.process_group(0);
    command.spawn().map_err(|error| Failure::new(format_args!("{QEMU}: {error}")))
}
