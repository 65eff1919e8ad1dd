//! The run of a mesh in virtual time.
//!
//! A binary heap of small events by time, and by order of entry where times are equal, is all that is needed: the arrival of a packet
//! over a link, the end of an actor's step, a deadline. `nexosim` was looked at: its models are asynchronous tasks with
//! mailboxes, which allocate for each message and are woken in an order that its executor chooses; here whole arenas are actors
//! that are called in one order, a packet lies in a slab, and the sequence of events is part of what a run promises.
//!
//! * An actor takes one step at a time. What it has put into its router is held there until the step's time has passed.
//! * A link takes the next packet from its router when it has sent the last, and puts it into the far router when it has
//!   travelled; what waits, where, and for whose credit is the routers' doing.
//! * Nothing is entered for what idles: an idle node with nothing to wait for costs nothing.

mod actor;
mod clock;
mod event;
mod fault;
mod link;
mod packets;
mod timeline;
mod watch;

#[cfg(test)]
mod tests;

pub(crate) use actor::Actor;

use clock::{Phase, PlaceState};
use event::{Event, EventQueue};
use kiloray_core::network::{
    Channel, HOST, Lane, Mesh, NodeId, PacketHeader, Port, Received, Router,
};
use kiloray_core::node::{Lack, Next, Time, tell_gone};
use link::Links;
use packets::Packets;
use std::marker::PhantomData;
use timeline::TimelineRecorder;
use watch::Watch;

use crate::{CrashReport, FaultReport, Faults, Link, NodeTime, Profile, TraceEvent};

/// A mesh that runs.
pub(crate) struct Run<'m, N, H> {
    /// The actors.
    pub(crate) nodes: Vec<N>,
    /// The host.
    pub(crate) host: H,
    /// Now \[ns\].
    pub(crate) now: u64,
    /// Events so far.
    pub(crate) events: u64,
    /// What became of packets and nodes.
    pub(crate) faults: FaultReport,
    /// What each node did when.
    pub(crate) trace: Vec<TraceEvent>,
    pub(crate) timeline: TimelineRecorder,
    pub(crate) places: Vec<PlaceState>,
    pub(crate) links: Links,
    pub(crate) watch: Watch,
    settings: RunSettings,
    slow: Vec<f64>,
    queue: EventQueue,
    packets: Packets,
    /// Places that can take a step.
    runnable: Vec<u32>,
    stored: u64,
    hash: u64,
    memory: PhantomData<&'m ()>,
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

/// The time between questions for credit is doubled so often at most, as long as they bring nothing.
const REMINDERS_MAX: u32 = 6;

impl<'m, N: Actor<'m>, H: Actor<'m>> Run<'m, N, H> {
    /// Before the first event.
    pub(crate) fn new(mesh: &Mesh, nodes: Vec<N>, host: H, settings: RunSettings) -> Self {
        let count = nodes.len();
        let mut slow = vec![1.0; count + 1];
        for entry in &settings.faults.slow {
            slow[usize::from(entry.node.0)] = entry.factor;
        }
        let mut queue = EventQueue::default();
        for crash in &settings.faults.crashes {
            queue.push(crash.at, Event::Crash { place: u32::from(crash.node.0) });
        }
        for place in (0..=count as u32).rev() {
            queue.push(0, Event::Wake { place });
        }
        let mut places: Vec<PlaceState> = Vec::with_capacity(count + 1);
        places.resize_with(count + 1, PlaceState::new);
        Self {
            nodes,
            host,
            now: 0,
            events: 0,
            faults: FaultReport::default(),
            trace: Vec::new(),
            timeline: TimelineRecorder::default(),
            places,
            links: Links::new(mesh),
            watch: Watch::new(settings.block_bytes, settings.trace),
            packets: Packets::new(settings.packet),
            settings,
            slow,
            queue,
            runnable: Vec::new(),
            stored: 0,
            hash: 0,
            memory: PhantomData,
        }
    }

    /// Lets the next thing happen; `false` if nothing will.
    pub(crate) fn advance(&mut self) -> bool {
        let Some((time, event)) = self.queue.pop() else { return false };
        debug_assert!(time >= self.now, "time goes on");
        self.now = time;
        self.events += 1;
        match event {
            Event::Arrive { packet } => self.arrive(packet),
            Event::Free { link } => {
                self.links.get(link).awaited = false;
                self.transmit(link);
                let from = self.links.get(link).from;
                self.serve(from);
            }
            Event::Done { place } => self.done(place),
            Event::Wake { place } => self.wake(place),
            Event::Remind { place } => self.remind(place),
            Event::Crash { place } => self.crash(place),
        }
        while let Some(place) = self.runnable.pop() {
            self.step(place);
        }
        true
    }

    /// A hash of all that has happened.
    pub(crate) fn fingerprint(&self) -> u64 {
        self.hash
    }

    /// Closes the accounts of all places.
    pub(crate) fn settle(&mut self) {
        for place in 0..self.places.len() as u32 {
            self.cut_step(place);
            self.close_rest(place);
        }
    }

    /// The router at a place.
    pub(crate) fn router(&mut self, place: u32) -> &mut Router<'m> {
        match self.nodes.get_mut(place as usize) {
            Some(node) => node.router(),
            None => self.host.router(),
        }
    }

    /// What the buffers at a place and port held at most, and what they can hold.
    pub(crate) fn buffers(&mut self) -> impl Fn(u32, Port) -> (u32, u32) + use<N, H> {
        let mut buffers = Vec::new();
        for place in 0..self.places.len() as u32 {
            let ports = self.links.of(place).len() as u16;
            let router = self.router(place);
            let of = |port| (router.peak(Port(port)), router.buffers());
            buffers.push((0..ports).map(of).collect::<Vec<_>>());
        }
        move |place, port| buffers[place as usize][usize::from(port.0)]
    }

    fn id(&self, place: u32) -> NodeId {
        if (place as usize) < self.nodes.len() { NodeId(place as u16) } else { HOST }
    }

    fn arrive(&mut self, packet: u32) {
        let link = self.packets.link(packet);
        let (place, port) = {
            let link = self.links.get(link);
            (link.to, link.back)
        };
        let here = self.id(place);
        let dead = self.places[place as usize].phase == Phase::Dead;
        let Self { nodes, host, packets, .. } = self;
        let router = match nodes.get_mut(place as usize) {
            Some(node) => node.router(),
            None => host.router(),
        };
        let bytes = packets.get(packet);
        let (header, payload) = PacketHeader::split(bytes).expect("routers send good packets");
        let passes = header.kind == PacketHeader::DATA && header.to() != here;
        let asks = Lane::from_u8(header.lane).is_some_and(|l| l.channel() == Channel::Request);
        let sender = header.from();
        let received = if passes {
            router.receive(port, &packets.ticket(packet), |_| false)
        } else {
            router.receive(port, bytes, |node| dead && node == here)
        };
        if received == Received::Buffered && !passes {
            self.watch.arrives(self.now, header.from(), here, payload);
        }
        if received != Received::Buffered || !passes {
            self.packets.free(packet);
        }
        self.note(1, u64::from(link), received as u64);
        match received {
            Received::Control | Received::Buffered => {}
            Received::Stale => self.faults.stale += 1,
            Received::Dead => {
                self.faults.for_the_dead += 1;
                if asks {
                    tell_gone(self.router(place), sender);
                }
            }
            Received::Bad => debug_assert!(false, "routers send good packets"),
        }
        self.serve(place);
    }

    /// Sends what can leave a place, and tells its actor of what it can consume.
    fn serve(&mut self, place: u32) {
        let links = self.links.of(place);
        loop {
            let mut changed = self.router(place).take_changed();
            if changed == 0 {
                break;
            }
            while changed != 0 {
                let first = links.start + changed.trailing_zeros();
                changed &= changed - 1;
                for link in (first..links.end).step_by(64) {
                    if self.links.get(link).to != u32::MAX {
                        self.transmit(link);
                    }
                }
            }
        }
        if self.router(place).take_news() {
            self.places[place as usize].news = true;
            self.wake_idle(place);
        }
    }

    /// Sends a packet if the link is free and there is one.
    fn transmit(&mut self, index: u32) {
        let now = self.now;
        let link = self.links.get(index);
        if link.awaited {
            return;
        }
        let (place, port, busy_until) = (link.from, link.port, link.busy_until);
        if busy_until <= now {
            let here = self.id(place);
            let Self { nodes, host, packets, .. } = self;
            let router = match nodes.get_mut(place as usize) {
                Some(node) => node.router(),
                None => host.router(),
            };
            let is_maker = |header: &PacketHeader| header.from() == here;
            let packet = packets.make(index, is_maker, |out| router.transmit(port, out));
            if let Some(packet) = packet {
                self.depart(index, packet);
            }
        }
        // It is called again when it is free, if there is something to send by then.
        let busy_until = self.links.get(index).busy_until;
        if busy_until > now && self.router(place).is_ready(port) {
            self.links.get(index).awaited = true;
            self.queue.push(busy_until, Event::Free { link: index });
        }
    }

    fn depart(&mut self, index: u32, packet: u32) {
        let bytes = self.packets.get(packet);
        let len = bytes.len();
        let (header, payload) = PacketHeader::split(bytes).expect("routers send good packets");
        let data = header.kind == PacketHeader::DATA;
        let place = self.links.get(index).from;
        let starts = data && header.from() == self.id(place);
        if starts {
            let state = &self.places[place as usize];
            let idle = matches!(state.phase, Phase::Idle(_));
            let step = if idle { state.since.saturating_sub(1) } else { self.now };
            self.watch.departs((self.now, step), header.from(), header.to(), payload);
        }
        let duration = self.settings.link.duration(len);
        let link = self.links.get(index);
        let (to, number) = (link.to, link.packets + link.control_packets);
        link.busy_until = self.now + duration;
        link.busy += duration;
        link.bytes += len as u64;
        link.packets += u64::from(data);
        link.control_packets += u64::from(!data);
        self.timeline.bytes(self.now, len as u64);
        let ends = self.id(to) == header.to();
        let arrival = self.now + self.settings.link.travel(&header, len, ends);
        if starts {
            self.has_room(place);
        }
        if !self.settings.faults.of_links() {
            self.queue.push(arrival, Event::Arrive { packet });
            return;
        }
        if data {
            self.places[place as usize].reminders = 0;
        }
        self.plan_reminder(place);
        let fate = fault::fate(&self.settings.faults, self.settings.seed, index, number);
        self.faults.delayed += u64::from(fate.delay > 0 && !fate.lost);
        if fate.doubled
            && let Some(copy) = self.packets.copy(packet)
        {
            self.faults.doubled += 1;
            let event = Event::Arrive { packet: copy };
            self.queue.push(arrival + fate.delay + duration, event);
        }
        if fate.lost {
            self.faults.lost += 1;
            self.packets.free(packet);
            return;
        }
        let mut arrival = arrival + fate.delay;
        if !fate.strays {
            let link = self.links.get(index);
            arrival = arrival.max(link.last_arrival);
            link.last_arrival = arrival;
        }
        self.queue.push(arrival, Event::Arrive { packet });
    }

    /// A packet of an actor has left.
    fn has_room(&mut self, place: u32) {
        match self.places[place as usize].phase {
            Phase::Busy { .. } => self.places[place as usize].news = true,
            Phase::Idle(_) => self.wake_idle(place),
            Phase::Dead => {}
        }
    }

    fn wake_idle(&mut self, place: u32) {
        let idle = matches!(self.places[place as usize].phase, Phase::Idle(_));
        if idle && !self.runnable.contains(&place) {
            self.runnable.push(place);
        }
    }

    fn wake(&mut self, place: u32) {
        let state = &mut self.places[place as usize];
        state.wake = u64::MAX;
        match state.phase {
            Phase::Idle(_) if state.until <= self.now => {
                self.runnable.push(place);
            }
            Phase::Idle(_) => self.plan_wake(place),
            Phase::Busy { .. } | Phase::Dead => {}
        }
    }

    /// Enters a call for an idle actor's deadline, unless an earlier one is entered: that one will look again.
    fn plan_wake(&mut self, place: u32) {
        let state = &mut self.places[place as usize];
        if state.until < state.wake {
            state.wake = state.until;
            self.queue.push(state.until.max(self.now), Event::Wake { place });
        }
    }

    /// An idle actor takes a step.
    fn step(&mut self, place: u32) {
        if !matches!(self.places[place as usize].phase, Phase::Idle(_)) {
            return;
        }
        self.close_rest(place);
        self.router(place).hold();
        let now = Time(self.now);
        let (progress, stored) = match self.nodes.get_mut(place as usize) {
            Some(node) => (node.poll(now), node.stored()),
            None => (self.host.poll(now), 0),
        };
        // What came to the front while it was at it, it has seen.
        self.router(place).take_news();
        let mut time = self.settings.profile.time(&progress.work, self.slow[place as usize]);
        let (then, until) = match progress.next {
            Next::Now => (None, Time::NEVER),
            Next::Wait { until, lack } => (Some(lack), until),
        };
        // What can go on without having taken time would go on for ever.
        if then.is_none() && time.busy() == 0 {
            time.messages = 1;
        }
        let busy = time.busy();
        self.note(2, u64::from(place), busy);
        let state = &mut self.places[place as usize];
        state.news = false;
        state.until = until.0;
        state.step = time;
        state.work += progress.work;
        state.steps += 1;
        self.stored = self.stored + u64::from(stored) - u64::from(state.stored);
        if state.stored != stored {
            state.stored = stored;
            self.timeline.stored(self.now, self.stored);
        }
        state.since = self.now;
        state.phase = Phase::Busy { then };
        if busy == 0 {
            self.done(place);
        } else {
            self.trace_step(place, &time);
            self.queue.push(self.now + busy, Event::Done { place });
            self.serve(place);
        }
    }

    /// The time for a step has passed.
    fn done(&mut self, place: u32) {
        let state = &mut self.places[place as usize];
        let Phase::Busy { then } = state.phase else { return };
        let since = state.since;
        state.since = self.now;
        state.time += state.step;
        // Until something is found to go on with.
        state.phase = Phase::Idle(then.unwrap_or(Lack::Tiles));
        if (place as usize) < self.nodes.len() {
            self.timeline.busy(since, self.now);
        }
        self.router(place).release();
        self.serve(place);
        let state = &self.places[place as usize];
        if then.is_none() || state.news || state.until <= self.now {
            self.wake_idle(place);
        } else {
            self.plan_wake(place);
        }
    }

    /// Enters the time that a place has not worked.
    fn close_rest(&mut self, place: u32) {
        let now = self.now;
        let state = &mut self.places[place as usize];
        state.add_rest(now - state.since);
        let waits = matches!(state.phase, Phase::Idle(lack) if lack != Lack::Tiles);
        if waits && (place as usize) < self.nodes.len() {
            self.timeline.waiting(state.since, now);
        }
        state.since = now;
    }

    /// Ends a step before its time has passed.
    fn cut_step(&mut self, place: u32) {
        let now = self.now;
        let state = &mut self.places[place as usize];
        if let Phase::Busy { .. } = state.phase {
            state.time += state.step.first(now - state.since);
            if (place as usize) < self.nodes.len() {
                self.timeline.busy(state.since, now);
            }
            state.since = now;
            state.phase = Phase::Idle(Lack::Tiles);
        }
    }

    fn crash(&mut self, place: u32) {
        if self.places[place as usize].phase == Phase::Dead {
            return;
        }
        self.cut_step(place);
        self.close_rest(place);
        let here = self.id(place);
        let state = &mut self.places[place as usize];
        state.phase = Phase::Dead;
        state.since = self.now;
        self.stored -= u64::from(state.stored);
        state.stored = 0;
        self.faults.crashes.push(CrashReport { node: here.0, at_ns: self.now });
        let router = self.router(place);
        router.discard();
        let dropped = router.forget(here);
        self.faults.for_the_dead += u64::from(dropped);
        self.serve(place);
    }

    fn plan_reminder(&mut self, place: u32) {
        let state = &mut self.places[place as usize];
        if !state.reminded {
            state.reminded = true;
            let link = &self.settings.link;
            let trip = link.latency + link.duration(usize::from(self.settings.packet));
            // What is out after many questions is held by a node that takes its time, not lost.
            let after = (8 * trip + 2 * self.settings.faults.jitter) << state.reminders;
            self.queue.push(self.now + after, Event::Remind { place });
        }
    }

    fn remind(&mut self, place: u32) {
        let state = &mut self.places[place as usize];
        state.reminded = false;
        state.reminders = (state.reminders + 1).min(REMINDERS_MAX);
        if self.router(place).remind() {
            self.plan_reminder(place);
            self.serve(place);
        }
    }

    fn trace_step(&mut self, place: u32, time: &NodeTime) {
        if self.trace.len() < self.settings.trace && (place as usize) < self.nodes.len() {
            let parts = time.parts();
            let most = parts.iter().max_by_key(|part| part.1);
            self.trace.push(TraceEvent {
                name: most.map_or("", |part| part.0),
                node: place as u16,
                start_ns: self.now,
                duration_ns: time.busy(),
            });
        }
    }

    /// Adds what happens to the hash of all that has happened.
    fn note(&mut self, what: u64, a: u64, b: u64) {
        let word = self.now ^ what << 60 ^ a << 40 ^ b.rotate_right(8);
        self.hash = (self.hash ^ word).wrapping_mul(0x9e37_79b9_7f4a_7c15).rotate_left(29);
    }
}
