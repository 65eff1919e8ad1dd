//! A node that is a process: the actor over the same lines as a board's, which it gets from `kiloray board` over its standard input.

use std::{
    env,
    io::{self, IoSlice, IoSliceMut},
    mem::MaybeUninit,
    net::TcpStream,
    os::{
        fd::{AsFd, OwnedFd},
        unix::{net::UnixStream, process::CommandExt},
    },
    path::Path,
    process::{self, Child, Command, Stdio},
    thread,
};

use async_io::block_on;
use kiloray_core::{
    network::Port,
    node::{Share, Time, run},
    store::{CHUNK_BYTES, Chunk},
    trace::Scalar,
};
use kiloray_link::{Tally, ask};
use rustix::net::{
    RecvAncillaryBuffer, RecvAncillaryMessage, RecvFlags, SendAncillaryBuffer,
    SendAncillaryMessage, SendFlags, recvmsg, sendmsg,
};

use super::{
    PAYLOAD,
    firmware::LINKS,
    link::{Wall, links, open},
};
use crate::{
    args,
    failure::{Failure, Outcome},
    input,
};

/// How often a node that has no setup asks for one.
const ASK_EVERY: Time = Time(50_000_000);
/// A port that no node has.
const NOWHERE: Port = Port(u16::MAX);

/// Starts one with these lines, by port. It ends when the socket is closed.
pub(super) fn start(
    memory: usize,
    share: &Path,
    lines: &[TcpStream],
) -> io::Result<(Child, UnixStream)> {
    let (near, far) = UnixStream::pair()?;
    let mut command = Command::new(env::current_exe()?);
    command.args(["line-node", "--memory", &memory.to_string(), "--share"]).arg(share);
    command.stdin(OwnedFd::from(far)).stdout(Stdio::null()).stderr(Stdio::piped());
    // What is typed to end the command is for the command alone.
    let child = command.process_group(0).spawn()?;
    let lines: Vec<_> = lines.iter().map(AsFd::as_fd).collect();
    let mut space = [MaybeUninit::uninit(); rustix::cmsg_space!(ScmRights(LINKS))];
    let mut control = SendAncillaryBuffer::new(&mut space);
    control.push(SendAncillaryMessage::ScmRights(&lines));
    sendmsg(&near, &[IoSlice::new(&[0])], &mut control, SendFlags::empty())?;
    Ok((child, near))
}

/// The lines that `start` has sent.
fn receive() -> io::Result<Vec<TcpStream>> {
    let mut space = [MaybeUninit::uninit(); rustix::cmsg_space!(ScmRights(LINKS))];
    let mut control = RecvAncillaryBuffer::new(&mut space);
    let mut byte = [0];
    recvmsg(io::stdin(), &mut [IoSliceMut::new(&mut byte)], &mut control, RecvFlags::CMSG_CLOEXEC)?;
    let mut lines = Vec::new();
    for message in control.drain() {
        if let RecvAncillaryMessage::ScmRights(given) = message {
            lines.extend(given.map(TcpStream::from));
        }
    }
    Ok(lines)
}

/// Such a node: works until whoever has started it is gone.
pub(in crate::command) fn line_node(node: &args::LineNode) -> Outcome {
    let lines = receive()
        .map_err(|error| Failure::new(format_args!("'kiloray board' starts this: {error}")))?;
    thread::spawn(|| {
        let _ = io::copy(&mut io::stdin(), &mut io::sink());
        process::exit(0);
    });
    let share = input::read(&node.share, u32::MAX.into())?;
    let mut chunks = vec![Chunk::ZERO; share.len().div_ceil(CHUNK_BYTES)];
    let bytes = &mut bytemuck::cast_slice_mut::<_, u8>(&mut chunks)[..share.len()];
    bytes.copy_from_slice(&share);
    let share = Share::parse(bytes).map_err(|error| Failure::file(&node.share, error))?;
    share.check_blocks().map_err(|error| Failure::file(&node.share, error))?;
    match lines.len() {
        1 => work::<1>(&share, node.memory, lines),
        2 => work::<2>(&share, node.memory, lines),
        _ => work::<LINKS>(&share, node.memory, lines),
    }
}

fn work<const N: usize>(share: &Share<'_>, memory: usize, lines: Vec<TcpStream>) -> Outcome {
    let lines = open::<N>(lines)?;
    let (tallies, clock) = ([const { Tally::new() }; N], Wall::new());
    let mut links = links(&lines, &tallies);
    let setup = block_on(ask(links.each_mut(), &clock, ASK_EVERY));
    let setup = setup.map_err(|error| Failure::new(format_args!("setup: {error}")))?;
    if setup.payload > PAYLOAD {
        return Err(Failure::new("setup: packets are longer than those of boards"));
    }
    let mut memory = vec![Chunk::ZERO; memory / CHUNK_BYTES];
    let mut node = setup
        .node(share, Scalar, &mut memory)
        .map_err(|error| Failure::new(format_args!("setup: {error}")))?;
    let mesh = *node.router().mesh();
    let mut ports = mesh.joined(share.here());
    let joints = links.each_mut().map(|link| link.joint(ports.next().unwrap_or(NOWHERE), &setup));
    block_on(async { match run(&mut node, joints, &clock, setup.reminder).await {} })
}
