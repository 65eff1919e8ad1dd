//! Frames over lines, which are serial ports or the sockets that stand for them, and the clock of this machine: what the host and the nodes that are processes share.

use std::{
    array,
    fs::File,
    future::pending,
    os::fd::OwnedFd,
    time::{Duration, Instant},
};

use async_io::{Async, Timer};
use embedded_io_adapters::futures_03::FromFutures;
use kiloray_core::{
    network::PacketHeader,
    node::{Clock, Setup, Time},
};
use kiloray_link::{Link, Tally, frame::frame_bytes};

use super::PAYLOAD;
use crate::failure::{Failure, Outcome};

/// Room for the frame of a packet, or of a setup.
const ROOM: usize = {
    let payload = PAYLOAD as usize;
    frame_bytes(PacketHeader::BYTES + if payload > Setup::BYTES { payload } else { Setup::BYTES })
};

/// One direction of a line.
type Half<'l> = FromFutures<&'l Async<File>>;

/// The lines, by port, for waiting on.
pub(super) fn open<const N: usize>(lines: Vec<impl Into<OwnedFd>>) -> Outcome<[Async<File>; N]> {
    let lines = lines.into_iter().map(|line| Async::new(File::from(line.into())));
    let lines = lines.collect::<Result<Vec<_>, _>>();
    let lines = lines.map_err(|error| Failure::new(format_args!("lines: {error}")))?;
    lines.try_into().map_err(|_| Failure::new("there are too many lines"))
}

/// Links over them.
pub(super) fn links<'t, 'l, const N: usize>(
    lines: &'l [Async<File>; N],
    tallies: &'t [Tally; N],
) -> [Link<'t, Half<'l>, Half<'l>, Vec<u8>>; N] {
    array::from_fn(|k| {
        let rooms = [(); 3].map(|()| vec![0; ROOM]);
        Link::new(FromFutures::new(&lines[k]), FromFutures::new(&lines[k]), rooms, &tallies[k])
    })
}

/// Time since it was made.
pub(super) struct Wall(Instant);

impl Wall {
    /// It begins now.
    pub(super) fn new() -> Self {
        Self(Instant::now())
    }
}

impl Clock for Wall {
    fn now(&self) -> Time {
        Time(u64::try_from(self.0.elapsed().as_nanos()).unwrap_or(u64::MAX))
    }

    async fn wait(&self, until: Time) {
        match self.0.checked_add(Duration::from_nanos(until.0)) {
            Some(at) if until != Time::NEVER => drop(Timer::at(at).await),
            _ => pending().await,
        }
    }
}
