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
//! at a place within that time, a *window*, does not depend on what happens elsewhere in the same window: parts of the mesh go through windows each for itself, on
//! as many threads as there are, and wait for none but their neighbours (conservative synchronisation by windows: Nicol 1993, "The cost of
//! conservative synchronization in parallel discrete event simulations"). So many windows are a *round*; what is noted in one is taken
//! down while the next goes on. Of one time, packets of lower places come first; so neither threads nor their number can be seen in a run.

mod actor;
mod clock;
mod event;
mod fault;
mod journal;
mod link;
mod packets;
mod place;
mod record;
mod round;
mod timeline;

#[cfg(test)]
mod tests;

pub(crate) use actor::Actor;
pub(crate) use place::Place;

use std::sync::Arc;

use journal::Journal;
use kiloray_core::network::{HOST, Mesh, NodeId};
use record::Record;
use round::{Parts, Places, Round, Task};

use crate::{FaultReport, Faults, Link, LinkReport, Profile};

/// A mesh that runs.
pub(crate) struct Run<'m, N, H> {
    /// The nodes, by number.
    pub(crate) nodes: Vec<Place<'m, N>>,
    pub(crate) host: Place<'m, H>,
    /// Now \[ns\].
    pub(crate) now: u64,
    /// Events so far.
    pub(crate) events: u64,
    pub(crate) record: Record,
    /// When the next thing happens, by place; the host is the last.
    due: Vec<u64>,
    /// The length of a window \[ns\].
    window: u64,
    /// Windows of a round.
    windows: u32,
    parts: Parts,
    /// More than this does not come to the host in a round \[bytes\].
    round_bytes: u64,
    /// By part.
    journals: Vec<Journal>,
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

/// Nodes are divided into so many parts for each thread at most: some, as they take unlike time.
const PARTS: usize = 8;
/// Windows of a round, at most.
const WINDOWS: u64 = 16;
/// Longer rounds would let nobody know how far the run is \[ns\].
const ROUND_MAX: u64 = 100_000;

impl<'m, N: Actor<'m> + Send, H: Actor<'m> + Send> Run<'m, N, H> {
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
        let host = Place::new(mesh, HOST, links, host, &settings);
        let links = places.iter().map(|place| (place.here, &place.links));
        let links = links.chain([(HOST, &host.links)]);
        let links = links.flat_map(|(from, all)| all.iter().map(move |link| (from, link.to)));
        let links = links.filter_map(|(from, to)| Some((from, to?)));
        let parts = Parts::new(places.len(), parts, links);
        let RunSettings { link, faults, packet, .. } = &*settings;
        let window = link.least_travel().min(ROUND_MAX);
        let windows = (ROUND_MAX / window.max(1)).clamp(1, WINDOWS);
        // What has departed before the round may come in it as well: a packet on each link, or what was delayed.
        let bytes = link.bytes_in((window * windows).saturating_add(faults.jitter));
        let bytes = bytes.saturating_add(u64::from(*packet));
        Ok(Self {
            now: 0,
            events: 0,
            record: Record::new(parts.len(), settings.block_bytes, settings.trace),
            due: vec![0; places.len() + 1],
            window,
            windows: windows as u32,
            round_bytes: bytes.saturating_mul(host.links.len() as u64),
            journals: (0..parts.len()).map(|_| Journal::default()).collect(),
            parts,
            nodes: places,
            host,
        })
    }

    /// Lets all happen that happens in the next round, or until the host has seen the end; `false` if nothing will.
    pub(crate) fn advance(&mut self) -> bool {
        let begin = self.due.iter().copied().min().unwrap_or(u64::MAX);
        if begin == u64::MAX {
            return false;
        }
        // The host takes no time, and may see the end: a round that it may see it in is a window long.
        let windows = if self.host.actor.may_end(self.round_bytes) { 1 } else { self.windows };
        let Self { nodes, host, due, journals, parts, window, record, .. } = self;
        let (due_of_host, due) = due.split_last_mut().expect("the host has one");
        let (of_host, of_nodes) = journals.split_last_mut().expect("the host has one");
        let size = parts.size();
        let tasks = nodes.chunks_mut(size).zip(due.chunks_mut(size)).zip(of_nodes);
        let tasks = tasks.map(|((nodes, due), journal)| (Places::Nodes(nodes), due, journal));
        let due = std::slice::from_mut(due_of_host);
        let tasks = tasks.chain([(Places::Host(host), due, of_host)]);
        let tasks = tasks.map(|(places, due, journal)| Task { places, due, journal });
        let tasks = tasks.collect();
        let round = Round { parts, begin, window: *window, windows };
        if parts.len() > 2 {
            rayon::join(|| record.take_down(), || round.run(tasks));
        } else {
            record.take_down();
            round.run(tasks);
        }
        self.collect();
        true
    }

    /// Takes over what places have noted.
    fn collect(&mut self) {
        for journal in &mut self.journals {
            self.now = self.now.max(journal.now);
            self.events += std::mem::take(&mut journal.events);
        }
        self.record.take(&mut self.journals);
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
        self.record.take_down();
        self.collect();
        self.record.take_down();
        // Steps that were cut short, by a death or by the end.
        for step in &mut self.record.trace {
            let died = self.nodes[usize::from(step.node)].faults.crashes.first();
            let end = died.map_or(self.now, |crash| crash.at_ns);
            step.duration_ns = step.duration_ns.min(end.saturating_sub(step.start_ns));
        }
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

    /// What the links sent, by the place that they leave, then by port. They are given away with it: there may be very many.
    pub(crate) fn take_links(&mut self) -> Vec<LinkReport> {
        let Self { nodes, host, now, .. } = self;
        let id = |place: NodeId| (place != HOST).then_some(place.0);
        let len = nodes.iter().map(|node| node.links.len()).sum::<usize>() + host.links.len();
        let mut all = Vec::with_capacity(len);
        for from in 0..=nodes.len() {
            let (here, links) = match nodes.get_mut(from) {
                Some(node) => (node.here, std::mem::take(&mut node.links)),
                None => (HOST, std::mem::take(&mut host.links)),
            };
            for (link, port) in links.iter().zip(0..) {
                let Some(to) = link.to else { continue };
                let buffers = match nodes.get_mut(usize::from(to.0)) {
                    Some(node) => node.buffers(link.back),
                    None => host.buffers(link.back),
                };
                all.push(link.report(id(here), id(to), port, buffers, *now));
            }
        }
        all
    }
}
