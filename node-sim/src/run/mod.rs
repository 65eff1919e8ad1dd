//! The run of a mesh in virtual time.
//!
//! A binary heap of small events by time, and by order of entry where times are equal, is all that a place needs: the arrival of a packet
//! over a link, the end of its actor's step, a deadline. `nexosim` was looked at: its models are asynchronous tasks with
//! mailboxes, which allocate for each message and are woken in an order that its executor chooses; here whole arenas are actors
//! that are called in one order, a packet is moved, and the sequence of events is part of what a run promises.
//!
//! * An actor takes one step at a time. What it has put into its router is held there until the step's time has passed.
//! * A link takes the next packet from its router when it has sent the last, and puts it into the far router when it has
//!   travelled; what waits, where, and for whose credit is the routers' doing.
//! * Nothing is entered for what idles: an idle node with nothing to wait for costs nothing.
//!
//! # Windows
//!
//! Places hear of each other by packets alone, and no packet takes less than the latency of a link and its header's time on it. So what happens
//! anywhere within that time from the next event on is known to be apart from what happens elsewhere: places go through such a *window* each for itself, on
//! as many threads as there are, and packets change hands when it is over (conservative synchronisation by windows: Nicol 1993, "The cost of
//! conservative synchronization in parallel discrete event simulations"). Of one time, packets of lower places come first; so neither
//! threads nor their number can be seen in a run.

mod actor;
mod clock;
mod event;
mod fault;
mod journal;
mod link;
mod packets;
mod place;
mod timeline;

#[cfg(test)]
mod tests;

pub(crate) use actor::Actor;
pub(crate) use place::Place;

use std::sync::Arc;

use journal::{Journal, Moment, Span};
use kiloray_core::network::{HOST, Mesh, NodeId, Port};
use kiloray_render::watch::Watch;
use link::LinkState;
use rayon::prelude::*;
use timeline::TimelineRecorder;

use crate::{FaultReport, Faults, Link, LinkReport, Profile, TraceEvent};

/// A mesh that runs.
pub(crate) struct Run<'m, N, H> {
    /// The nodes, by number.
    pub(crate) nodes: Vec<Place<'m, N>>,
    pub(crate) host: Place<'m, H>,
    /// Now \[ns\].
    pub(crate) now: u64,
    /// Events so far.
    pub(crate) events: u64,
    /// What each node did when.
    pub(crate) trace: Vec<TraceEvent>,
    pub(crate) timeline: TimelineRecorder,
    pub(crate) watch: Watch,
    /// When the next thing happens, by place; the host is the last.
    due: Vec<u64>,
    /// The length of a window \[ns\].
    window: u64,
    /// Rays that all nodes hold.
    stored: i64,
    /// Most events of the trace.
    trace_max: usize,
    /// Of runs of nodes, in their order, and of the host: what each thread writes in a window.
    journals: Vec<Journal>,
    /// Of all, when the window is over.
    journal: Journal,
}

/// What a run is told.
#[derive(Debug, Clone)]
pub(crate) struct RunSettings {
    pub(crate) link: Link,
    pub(crate) profile: Profile,
    pub(crate) faults: Faults,
    pub(crate) seed: u64,
    /// Greatest packet \[bytes\].
    pub(crate) packet: u16,
    /// Bytes of a block.
    pub(crate) block_bytes: usize,
    /// Most events of a trace.
    pub(crate) trace: usize,
}

/// Nodes go through a window in so many parts for each thread at most: some, as they take unlike time.
const PARTS: usize = 8;
/// Longer windows would let nobody know how far the run is \[ns\].
const WINDOW_MAX: u64 = 100_000;

impl<'m, N: Actor<'m> + Send, H: Actor<'m>> Run<'m, N, H> {
    /// Before the first event. It will run on so many threads: those of the pool that it is called in.
    ///
    /// # Errors
    /// That of the first node that cannot be.
    pub(crate) fn new<E>(
        mesh: &Mesh,
        nodes: impl Iterator<Item = Result<N, E>>,
        host: H,
        settings: RunSettings,
        threads: usize,
    ) -> Result<Self, E> {
        let settings = Arc::new(settings);
        let parts = if threads > 1 { threads * PARTS } else { 1 };
        let mut links = 0;
        // Each where it stays: there may be thousands.
        let mut places = Vec::with_capacity(usize::from(mesh.nodes()));
        for (node, id) in nodes.zip((0..).map(NodeId)) {
            let place = Place::new(mesh, id, links, node?, &settings);
            links += place.links.len() as u32;
            places.push(place);
        }
        Ok(Self {
            host: Place::new(mesh, HOST, links, host, &settings),
            now: 0,
            events: 0,
            trace: Vec::new(),
            timeline: TimelineRecorder::default(),
            watch: Watch::new(settings.block_bytes, settings.trace),
            due: vec![0; places.len() + 1],
            window: settings.link.least_travel().min(WINDOW_MAX),
            stored: 0,
            trace_max: settings.trace,
            journals: (0..=parts).map(|_| Journal::default()).collect(),
            journal: Journal::default(),
            nodes: places,
        })
    }

    /// Lets all happen that happens in the next window, or until the host has seen the end; `false` if nothing will.
    pub(crate) fn advance(&mut self) -> bool {
        let begin = self.due.iter().copied().min().unwrap_or(u64::MAX);
        if begin == u64::MAX {
            return false;
        }
        let mut end = begin.saturating_add(self.window);
        // The host takes no time, and may see the end.
        let Self { nodes, host, due, journals, .. } = self;
        let (of_host, of_nodes) = journals.split_last_mut().expect("the host has one");
        host.advance(end, of_host);
        if host.actor.has_ended() {
            end = host.now.saturating_add(1);
        }
        let awake = nodes.iter_mut().zip(due.iter()).filter(|(_, due)| **due < end);
        if of_nodes.len() > 1 {
            let mut awake: Vec<_> = awake.map(|(place, _)| place).collect();
            let run = awake.len().div_ceil(of_nodes.len()).max(1);
            let runs = awake.par_chunks_mut(run).zip(of_nodes).with_max_len(1);
            runs.for_each(|(run, journal)| run.iter_mut().for_each(|p| p.advance(end, journal)));
        } else {
            let [journal, ..] = of_nodes else { return false };
            awake.for_each(|(place, _)| place.advance(end, journal));
        }
        for (due, node) in due.iter_mut().zip(nodes).filter(|(due, _)| **due < end) {
            *due = node.due();
        }
        if let Some(due) = due.last_mut() {
            *due = host.due();
        }
        self.take_down();
        self.deliver();
        true
    }

    /// Takes down what was collected.
    fn take_down(&mut self) {
        let Self { journals, journal, watch, timeline, stored, .. } = self;
        journals.iter_mut().for_each(|part| journal.append(part));
        self.now = self.now.max(journal.now);
        self.events += std::mem::take(&mut journal.events);
        journal.moments.sort_by_key(|(at, _)| *at);
        for (at, moment) in journal.moments.drain(..) {
            match moment {
                Moment::Stored(more) => {
                    *stored += more;
                    timeline.stored(at, *stored as u64);
                }
                Moment::Pixels(pixels) => timeline.pixels(at, pixels),
                Moment::Seen(sight) => watch.see(at, sight),
            }
        }
        // Behind what holds from a moment on: where the line grows, it goes on with that.
        for span in journal.spans.drain(..) {
            match span {
                Span::Busy { from, to, useful } => timeline.busy(from, to, useful),
                Span::Waiting { from, to } => timeline.waiting(from, to),
                Span::Sent { at, bytes } => timeline.bytes(at, bytes),
            }
        }
        journal.trace.sort_by_key(|event| event.start_ns);
        let room = self.trace_max - self.trace.len();
        self.trace.extend(journal.trace.drain(..).take(room));
    }

    /// Gives packets to the places that they go to.
    fn deliver(&mut self) {
        for departure in self.journal.departures.drain(..) {
            let at = usize::from(departure.to.0).min(self.nodes.len());
            let due = &mut self.due[at];
            *due = departure.arrival.min(*due);
            match self.nodes.get_mut(at) {
                Some(node) => node.receive(departure),
                None => self.host.receive(departure),
            }
        }
    }

    /// A hash of all that has happened.
    pub(crate) fn fingerprint(&self) -> u64 {
        let hashes = self.nodes.iter().map(|node| node.hash).chain([self.host.hash]);
        hashes.fold(0, |all: u64, hash| {
            (all ^ hash).wrapping_mul(0x9e37_79b9_7f4a_7c15).rotate_left(29)
        })
    }

    /// Closes the accounts of all places.
    pub(crate) fn settle(&mut self) {
        let [journal, ..] = &mut *self.journals else { return };
        self.nodes.iter_mut().for_each(|node| node.settle(self.now, journal));
        self.host.settle(self.now, journal);
        self.take_down();
    }

    /// What became of packets and nodes.
    pub(crate) fn faults(&self) -> FaultReport {
        let mut all = FaultReport::default();
        for faults in self.nodes.iter().map(|node| &node.faults).chain([&self.host.faults]) {
            all.lost += faults.lost;
            all.doubled += faults.doubled;
            all.delayed += faults.delayed;
            all.stale += faults.stale;
            all.for_the_dead += faults.for_the_dead;
            all.crashes.extend(&faults.crashes);
        }
        all.crashes.sort_by_key(|crash| crash.at_ns);
        all
    }

    /// What the links sent, by the place that they leave, then by port.
    pub(crate) fn links(&mut self) -> Vec<LinkReport> {
        let Self { nodes, host, .. } = self;
        let ports = |links: &[LinkState]| (0..links.len() as u16).map(Port);
        let mut buffers: Vec<Vec<(u32, u32)>> = Vec::with_capacity(nodes.len() + 1);
        for node in nodes.iter_mut() {
            buffers.push(ports(&node.links).map(|port| node.buffers(port)).collect());
        }
        buffers.push(ports(&host.links).map(|port| host.buffers(port)).collect());
        let id = |place: NodeId| (place != HOST).then_some(place.0);
        let leaving = nodes.iter().map(|node| &node.links).chain([&host.links]);
        let links = leaving.zip((0..nodes.len() as u16).map(NodeId).chain([HOST]));
        let mut all = Vec::with_capacity(buffers.iter().map(Vec::len).sum());
        for (links, from) in links {
            for (link, port) in links.iter().zip(0..) {
                let Some(to) = link.to else { continue };
                let end = usize::from(to.0).min(nodes.len());
                let buffers = buffers[end][usize::from(link.back.0)];
                all.push(link.report(id(from), id(to), port, buffers));
            }
        }
        all
    }
}
