//! This machine as the host: the picture and its tiles, over the serial lines to the mesh.

use std::{
    cell::Cell,
    future::{Future, poll_fn},
    os::fd::OwnedFd,
    pin::pin,
    task::Poll,
    time::Duration,
};

use async_io::Timer;
use kiloray_core::{
    network::{HOST, Mesh, Port, Router, RouterSize},
    node::{Actor, Next, Setup, Time, run},
    store::{Arena, CHUNK_BYTES, Chunk},
};
use kiloray_link::{LinkCounts, Tally};
use kiloray_mesh::Ledger;

use super::{
    inquiry::Inquiry,
    link::{Wall, links, open},
};
use crate::failure::{Failure, Outcome};

/// How often the rest of the world is looked at.
const LOOK_EVERY: Duration = Duration::from_millis(50);

/// How the host's work ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum End {
    Complete,
    /// No node has this block.
    Lost(u32),
    /// Somebody has asked for it.
    Stopped,
}

/// What the host has heard over its lines.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Heard {
    /// Sound frames.
    pub(super) frames: u32,
    /// A line over which nothing comes any more.
    pub(super) broken: Option<usize>,
}

/// Asked from time to time: pixels that are there, and what was heard. `false` stops the run.
pub(super) type Look<'l> = &'l mut dyn FnMut(u64, Heard) -> Outcome<bool>;

/// A host, and what its links carried.
#[derive(Debug)]
pub(super) struct Done {
    pub(super) ledger: Ledger,
    pub(super) end: End,
    pub(super) links: Vec<LinkCounts>,
}

/// Takes the picture over these links, the host's ports in order, until it is complete or `look` says so.
pub(super) fn host(
    mesh: Mesh,
    setup: &Setup,
    ledger: Ledger,
    lines: Vec<impl Into<OwnedFd>>,
    look: Look<'_>,
) -> Outcome<Done> {
    match lines.len() {
        1 => with_links::<1>(mesh, setup, ledger, lines, look),
        _ => with_links::<2>(mesh, setup, ledger, lines, look),
    }
}

fn with_links<const N: usize>(
    mesh: Mesh,
    setup: &Setup,
    ledger: Ledger,
    lines: Vec<impl Into<OwnedFd>>,
    look: Look<'_>,
) -> Outcome<Done> {
    let size = RouterSize::new(&mesh, HOST, setup.depth, setup.payload);
    let mut memory = vec![Chunk::ZERO; size.arena_bytes() / CHUNK_BYTES];
    let router = Router::new(&mut Arena::new(&mut memory), mesh, HOST, size);
    let router = router.map_err(Failure::new)?;
    let state = Cell::new((0, None));
    let inquiry = Inquiry::new(mesh.nodes(), Time(setup.patience.0 / 2));
    let mut host = Host { router, ledger, inquiry, state: &state };

    let lines = open::<N>(lines)?;
    let tallies = [const { Tally::new() }; N];
    let mut joined = links(&lines, &tallies);
    let mut ports = mesh.joined(HOST);
    let joints =
        joined.each_mut().map(|link| link.joint(ports.next().unwrap_or(Port(u16::MAX)), setup));

    let clock = Wall::new();
    let end = {
        let mut work = pin!(run(&mut host, joints, &clock, setup.reminder));
        let mut tick = Timer::interval(LOOK_EVERY);
        async_io::block_on(poll_fn(|cx| {
            if let Poll::Ready(never) = work.as_mut().poll(cx) {
                match never {}
            }
            let (pixels, end) = state.get();
            if let Some(end) = end {
                return Poll::Ready(Ok(end));
            }
            while pin!(&mut tick).poll(cx).is_ready() {
                if let Some(version) = tallies.iter().find_map(|tally| tally.get().other_version) {
                    return Poll::Ready(Err(other_version(version)));
                }
                let heard = Heard {
                    frames: tallies.iter().map(|tally| tally.get().received).sum(),
                    broken: tallies.iter().position(|tally| tally.get().broken),
                };
                match look(pixels, heard) {
                    Ok(true) => {}
                    Ok(false) => return Poll::Ready(Ok(End::Stopped)),
                    Err(failure) => return Poll::Ready(Err(failure)),
                }
            }
            Poll::Pending
        }))?
    };
    let links = tallies.iter().map(Tally::get).collect();
    Ok(Done { ledger: host.ledger, end, links })
}

/// A node that is older or newer than this command.
fn other_version(version: u32) -> Failure {
    Failure::new(format_args!(
        "a board's firmware wants version {version} of the run's setup, and this command has version {}: build the firmware from the same sources ('bash node-board/firmware MACHINE')",
        Setup::VERSION
    ))
}

struct Host<'m, 's> {
    router: Router<'m>,
    ledger: Ledger,
    inquiry: Inquiry,
    /// Pixels that are there, and how it has ended, once all nodes were asked what they have done.
    state: &'s Cell<(u64, Option<End>)>,
}

impl<'m> Actor<'m> for Host<'m, '_> {
    fn poll(&mut self, now: Time) -> Next {
        let Self { router, ledger, inquiry, state } = self;
        let mut next = ledger.poll(now, router);
        let lost = ledger.lost().map(End::Lost);
        let end = if ledger.is_complete() { Some(End::Complete) } else { lost };
        let asks = end.and_then(|_| inquiry.poll(now, ledger, router));
        state.set((ledger.pixels_done(), end.filter(|_| asks.is_none())));
        if let (Some(asks), Next::Wait { until, .. }) = (asks, &mut next) {
            *until = asks.min(*until);
        }
        next
    }

    fn router(&mut self) -> &mut Router<'m> {
        &mut self.router
    }
}
