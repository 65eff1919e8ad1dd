//! One place of the mesh: an actor, and all that happens to it.

use std::marker::PhantomData;
use std::sync::Arc;

use kiloray_core::network::{
    Channel, HOST, Lane, Mesh, NodeId, PacketHeader, Port, Received, Router,
};
use kiloray_core::node::{Lack, Next, Time, signal};
use kiloray_core::protocol::Message;

use super::clock::{Phase, PlaceState};
use super::event::{Event, EventQueue};
use super::fault;
use super::journal::{Departure, Journal, Moment, Span};
use super::link::LinkState;
use super::packets::{Packet, Packets};
use super::{Actor, RunSettings};
use crate::{CrashReport, FaultReport, NodeTime, TraceEvent};
use kiloray_mesh::watch::Sight;

/// A place of the mesh. It knows nothing of the others but what packets bring.
pub(crate) struct Place<'m, A> {
    /// What runs here.
    pub(crate) actor: A,
    pub(crate) state: PlaceState,
    /// The links that leave it, by port.
    pub(crate) links: Vec<LinkState>,
    /// The number of the first among all links: by the place that they leave, then by port.
    first: u32,
    /// Now \[ns\].
    pub(crate) now: u64,
    /// What became of packets and of the node.
    pub(crate) faults: FaultReport,
    /// A hash of all that has happened.
    pub(crate) hash: u64,
    pub(crate) here: NodeId,
    settings: Arc<RunSettings>,
    slow: f64,
    queue: EventQueue,
    packets: Packets,
    /// It can take a step.
    runnable: bool,
    /// Pixels complete when last told.
    pixels: u64,
    memory: PhantomData<&'m ()>,
}

/// The time between questions for credit is doubled so often, as long as they bring nothing.
const REMINDERS_MAX: u32 = 6;
/// From there on it is one in so many of the time that they have brought nothing for: what a node holds that is slower than all others is asked for
/// seldom, and what is lost again and again costs little more than it has already.
const REMINDERS_PART: u64 = 64;

impl<'m, A: Actor<'m>> Place<'m, A> {
    /// Before the first event. Its links are numbered from `first`.
    pub(crate) fn new(
        mesh: &Mesh,
        here: NodeId,
        first: u32,
        actor: A,
        settings: &Arc<RunSettings>,
    ) -> Self {
        let faults = &settings.faults;
        let mut queue = EventQueue::default();
        for crash in faults.crashes.iter().filter(|crash| crash.node == here) {
            queue.push(crash.at, Event::Crash);
        }
        queue.push(0, Event::Wake);
        Self {
            actor,
            state: PlaceState::new(),
            links: LinkState::of(mesh, here),
            first,
            now: 0,
            faults: FaultReport::default(),
            hash: 0,
            here,
            slow: faults.slow.iter().find(|s| s.node == here).map_or(1.0, |s| s.factor),
            queue,
            packets: Packets::new(settings.packet),
            settings: Arc::clone(settings),
            runnable: false,
            pixels: 0,
            memory: PhantomData,
        }
    }

    /// When the next thing happens here, unless a packet comes before; [`u64::MAX`] if nothing will.
    pub(crate) fn due(&self) -> u64 {
        self.queue.due()
    }

    /// Lets all happen that happens before `end`, unless the actor sees the end of the run, and tells it.
    pub(crate) fn advance(&mut self, end: u64, journal: &mut Journal) {
        while self.queue.due() < end && !self.actor.has_ended() {
            let Some((time, event)) = self.queue.pop() else { break };
            debug_assert!(time >= self.now, "time goes on");
            self.now = time;
            journal.now = journal.now.max(time);
            journal.events += 1;
            match event {
                Event::Arrive { packet } if self.settings.profile.forward > 0.0 => {
                    self.forward(packet);
                }
                Event::Arrive { packet } | Event::Enter { packet } => self.arrive(journal, packet),
                Event::Free { port } => {
                    self.links[usize::from(port)].awaited = false;
                    self.transmit(journal, Port(port));
                    self.serve(journal);
                }
                Event::Done => self.done(journal),
                Event::Wake => self.wake(),
                Event::Remind => self.remind(journal),
                Event::Crash => self.crash(journal),
            }
            while std::mem::take(&mut self.runnable) {
                self.step(journal);
            }
        }
    }

    /// A packet comes by a port.
    pub(crate) fn receive(&mut self, departure: Departure) {
        let Departure { port, arrival, packet, .. } = departure;
        let packet = self.packets.enter(packet, port);
        self.queue.push(arrival, Event::Arrive { packet });
    }

    /// Closes its accounts.
    pub(crate) fn settle(&mut self, now: u64, journal: &mut Journal) {
        self.now = now;
        self.cut_step(journal);
        self.close_rest(journal);
    }

    /// What the buffers of a port held at most, and what they can hold.
    pub(crate) fn buffers(&mut self, port: Port) -> (u32, u32) {
        let router = self.actor.router();
        (router.peak(port), router.buffers(port))
    }

    const fn is_host(&self) -> bool {
        self.here.0 == HOST.0
    }

    fn router(&mut self) -> &mut Router<'m> {
        self.actor.router()
    }

    /// A packet has come to a node that passes packets on itself. Each takes its time, one after the other, and what comes by the same link behind it waits.
    fn forward(&mut self, packet: u32) {
        let (bytes, port) = self.packets.get(packet);
        let (header, _) = PacketHeader::split(bytes).expect("routers send good packets");
        let link = &mut self.links[usize::from(port.0)];
        if header.kind == PacketHeader::DATA && header.to() != self.here {
            let time = self.settings.profile.forwarding(bytes.len(), self.slow);
            self.state.keep(self.now, time);
            self.state.forwards_until =
                self.state.forwards_until.max(self.now).saturating_add(time);
            link.enters = self.state.forwards_until;
        }
        self.queue.push(link.enters.max(self.now), Event::Enter { packet });
    }

    fn arrive(&mut self, journal: &mut Journal, packet: u32) {
        let here = self.here;
        let dead = self.state.phase == Phase::Dead;
        let router = self.actor.router();
        let (bytes, port) = self.packets.get(packet);
        let (header, payload) = PacketHeader::split(bytes).expect("routers send good packets");
        let passes = header.kind == PacketHeader::DATA && header.to() != here;
        let asks = Lane::from_u8(header.lane).is_some_and(|l| l.channel() == Channel::Request);
        let sender = header.from();
        let received = if passes {
            router.receive(port, &self.packets.ticket(packet), |_| false)
        } else {
            router.receive(port, bytes, |node| dead && node == here)
        };
        if received == Received::Buffered && !passes {
            let seen = Sight::arriving(sender, here, payload);
            journal.notes.moments.extend(seen.map(|sight| (self.now, Moment::Seen(sight))));
        }
        if received != Received::Buffered || !passes {
            let packet = self.packets.take(packet);
            journal.buffers.recycle(packet);
        }
        self.note(1, u64::from(port.0), received as u64);
        match received {
            Received::Control | Received::Buffered => {}
            Received::Stale => self.faults.stale += 1,
            Received::Dead => {
                self.faults.for_the_dead += 1;
                if asks {
                    // Where there is no room, nothing: who hears nothing asks again.
                    signal(self.router(), sender, &Message::Gone);
                }
            }
            Received::Bad => debug_assert!(false, "routers send good packets"),
        }
        self.serve(journal);
    }

    /// Sends what can leave, and tells the actor of what it can consume.
    fn serve(&mut self, journal: &mut Journal) {
        loop {
            let mut changed = self.router().take_changed();
            if changed == 0 {
                break;
            }
            while changed != 0 {
                let first = changed.trailing_zeros() as usize;
                changed &= changed - 1;
                for port in (first..self.links.len()).step_by(64) {
                    self.transmit(journal, Port(port as u16));
                }
            }
        }
        if self.router().take_news() {
            self.state.news = true;
            self.wake_idle();
        }
    }

    /// Sends a packet if the link is free and there is one.
    #[inline(always)]
    fn transmit(&mut self, journal: &mut Journal, port: Port) {
        // Most calls end here.
        let link = &self.links[usize::from(port.0)];
        if !link.awaited && link.to.is_some() && self.router().may_send(port) {
            self.send(journal, port);
        }
    }

    fn send(&mut self, journal: &mut Journal, port: Port) {
        let Self { links, actor, packets, now, here, .. } = self;
        if links[usize::from(port.0)].busy_until <= *now {
            let is_maker = |header: &PacketHeader| header.from() == *here;
            let packet = packets
                .make(&mut journal.buffers, is_maker, |out| actor.router().transmit(port, out));
            if let Some(packet) = packet {
                self.depart(journal, port, packet);
            }
        }
        // It is called again when it is free, if there is something to send by then, be it without credit yet: to ask for that takes longer than an event.
        let busy_until = self.links[usize::from(port.0)].busy_until;
        if busy_until > self.now && self.router().may_send(port) {
            self.links[usize::from(port.0)].awaited = true;
            self.queue.push(busy_until, Event::Free { port: port.0 });
        }
    }

    fn depart(&mut self, journal: &mut Journal, port: Port, packet: Packet) {
        let bytes = packet.bytes();
        let len = bytes.len();
        let (header, payload) = PacketHeader::split(bytes).expect("routers send good packets");
        let data = header.kind == PacketHeader::DATA;
        let starts = data && header.from() == self.here;
        if starts {
            let idle = matches!(self.state.phase, Phase::Idle(_));
            let step = if idle { self.state.since.saturating_sub(1) } else { self.now };
            let seen = Sight::leaving(header.from(), header.to(), step, payload);
            journal.notes.moments.extend(seen.map(|sight| (self.now, Moment::Seen(sight))));
        }
        if starts {
            self.has_room();
        }
        let faulty = self.settings.faults.of_links();
        if faulty {
            if data {
                (self.state.reminders, self.state.left) = (0, self.now);
            }
            self.plan_reminder();
        }
        let settings = &*self.settings;
        let duration = settings.link.duration(len);
        let link = &mut self.links[usize::from(port.0)];
        let Some(to) = link.to else { return };
        let (back, of_link) = (link.back, link.packets + link.control_packets);
        let number = self.first + u32::from(port.0);
        let fate = faulty.then(|| fault::fate(&settings.faults, settings.seed, number, of_link));
        // The copy goes behind it over the same link.
        let times = 1 + u64::from(fate.is_some_and(|fate| fate.doubled));
        let (busy, bytes) = (duration * times, len as u64 * times);
        link.busy_until = self.now + busy;
        link.busy += busy;
        link.bytes += bytes;
        link.packets += u64::from(data);
        link.control_packets += u64::from(!data);
        journal.notes.sends(self.now, bytes);
        let arrival = self.now + settings.link.travel(&header, len, to == header.to());
        let from = self.here;
        let departs = |arrival, packet| Departure { from, to, port: back, arrival, packet };
        let Some(fate) = fate else {
            journal.departures.push(departs(arrival, packet));
            return;
        };
        self.faults.delayed += u64::from(fate.delay > 0 && !fate.lost);
        let mut arrival = arrival + fate.delay;
        if !fate.strays {
            arrival = arrival.max(link.last_arrival);
        }
        let last = arrival + busy - duration;
        if fate.doubled {
            self.faults.doubled += 1;
            self.faults.lost += u64::from(fate.copy_lost);
            if !fate.copy_lost {
                journal.departures.push(departs(last, packet.clone()));
            }
        }
        if !fate.strays {
            link.last_arrival = last;
        }
        self.faults.lost += u64::from(fate.lost);
        if !fate.lost {
            journal.departures.push(departs(arrival, packet));
        }
    }

    /// A packet of the actor has left.
    fn has_room(&mut self) {
        match self.state.phase {
            Phase::Busy { .. } => self.state.news = true,
            Phase::Idle(_) => self.wake_idle(),
            Phase::Dead => {}
        }
    }

    fn wake_idle(&mut self) {
        self.runnable |= matches!(self.state.phase, Phase::Idle(_));
    }

    fn wake(&mut self) {
        self.state.wake = u64::MAX;
        match self.state.phase {
            Phase::Idle(_) if self.state.until <= self.now => self.runnable = true,
            Phase::Idle(_) => self.plan_wake(),
            Phase::Busy { .. } | Phase::Dead => {}
        }
    }

    /// Enters a call for an idle actor's deadline, unless an earlier one is entered: that one will look again.
    fn plan_wake(&mut self) {
        let state = &mut self.state;
        if state.until < state.wake {
            state.wake = state.until;
            self.queue.push(state.until.max(self.now), Event::Wake);
        }
    }

    /// An idle actor takes a step.
    fn step(&mut self, journal: &mut Journal) {
        if !matches!(self.state.phase, Phase::Idle(_)) {
            return;
        }
        self.close_rest(journal);
        self.router().hold();
        let progress = self.actor.poll(Time(self.now));
        // What came to the front while it was at it, it has seen.
        self.router().take_news();
        let mut time = self.settings.profile.time(&progress.work, self.slow);
        time.forwards = self.state.kept_until.saturating_sub(self.now);
        let (then, until) = match progress.next {
            Next::Now => (None, Time::NEVER),
            Next::Wait { until, lack } => (Some(lack), until),
        };
        // What can go on without having taken time would go on for ever.
        if then.is_none() && time.busy() == 0 {
            time.messages = 1;
        }
        let busy = time.busy();
        self.note(2, 0, busy);
        let (stored, pixels) = (self.actor.stored(), self.actor.pixels());
        self.holds(journal, stored);
        if self.pixels != pixels {
            self.pixels = pixels;
            journal.notes.moments.push((self.now, Moment::Pixels(pixels)));
        }
        let state = &mut self.state;
        state.news = false;
        state.until = until.0;
        state.step = time;
        state.work += progress.work;
        state.steps += 1;
        state.since = self.now;
        state.phase = Phase::Busy { then };
        if busy == 0 {
            self.done(journal);
        } else {
            self.trace_step(journal, &time);
            self.queue.push(self.now.saturating_add(busy), Event::Done);
            self.serve(journal);
        }
    }

    /// It holds so many rays from now on.
    fn holds(&mut self, journal: &mut Journal, rays: u32) {
        let more = i64::from(rays) - i64::from(self.state.stored);
        if more != 0 {
            self.state.stored = rays;
            journal.notes.moments.push((self.now, Moment::Stored(more)));
        }
    }

    /// The time for a step has passed.
    fn done(&mut self, journal: &mut Journal) {
        let state = &mut self.state;
        let Phase::Busy { then } = state.phase else { return };
        let (since, useful) = (state.since, state.step.useful());
        state.since = self.now;
        state.time += state.step;
        // Until something is found to go on with.
        state.phase = Phase::Idle(then.unwrap_or(Lack::Tiles));
        self.was(journal, Span::Busy { from: since, to: self.now, useful });
        self.router().release();
        self.serve(journal);
        if then.is_none() || self.state.news || self.state.until <= self.now {
            self.wake_idle();
        } else {
            self.plan_wake();
        }
    }

    /// Takes down what a node did; the host takes no time.
    fn was(&mut self, journal: &mut Journal, span: Span) {
        if !self.is_host() {
            journal.notes.spans.push(span);
        }
    }

    /// Enters the time that it has not worked.
    fn close_rest(&mut self, journal: &mut Journal) {
        let (since, now) = (self.state.since, self.now);
        self.state.add_rest(now - since);
        if matches!(self.state.phase, Phase::Idle(lack) if lack != Lack::Tiles) {
            self.was(journal, Span::Waiting { from: since, to: now });
        }
        self.state.since = now;
    }

    /// Ends a step before its time has passed.
    fn cut_step(&mut self, journal: &mut Journal) {
        let (since, now) = (self.state.since, self.now);
        if let Phase::Busy { .. } = self.state.phase {
            self.state.time += self.state.step.first(now - since);
            let useful = self.state.step.useful();
            self.was(journal, Span::Busy { from: since, to: now, useful });
            self.state.since = now;
            self.state.phase = Phase::Idle(Lack::Tiles);
        }
    }

    fn crash(&mut self, journal: &mut Journal) {
        if self.state.phase == Phase::Dead {
            return;
        }
        self.cut_step(journal);
        self.close_rest(journal);
        self.state.phase = Phase::Dead;
        self.state.since = self.now;
        self.holds(journal, 0);
        let here = self.here;
        self.faults.crashes.push(CrashReport { node: here.0, at_ns: self.now });
        let router = self.router();
        router.discard();
        let dropped = router.forget(here);
        self.faults.for_the_dead += u64::from(dropped);
        self.serve(journal);
    }

    /// Enters a look at overdue credit, unless one is entered that comes in good time.
    fn plan_reminder(&mut self) {
        let RunSettings { link, faults, packet, .. } = &*self.settings;
        let trip = link.latency.saturating_add(link.duration(usize::from(*packet)));
        let first = trip.saturating_mul(8).saturating_add(faults.jitter.saturating_mul(2));
        // What is out after many questions is held by a node that takes its time, not lost.
        let state = &mut self.state;
        let vain = (self.now - state.left) / REMINDERS_PART;
        let most = first.saturating_mul(1 << REMINDERS_MAX);
        let after = first.saturating_mul(1 << state.reminders).max(vain);
        if state.remind > self.now.saturating_add(after.max(most)) {
            state.remind = self.now.saturating_add(after);
            self.queue.push(state.remind, Event::Remind);
        }
    }

    fn remind(&mut self, journal: &mut Journal) {
        // An earlier one has taken the place of this.
        if self.state.remind != self.now {
            return;
        }
        self.state.remind = u64::MAX;
        self.state.reminders = (self.state.reminders + 1).min(REMINDERS_MAX);
        if self.router().remind() {
            self.plan_reminder();
            self.serve(journal);
        }
    }

    fn trace_step(&mut self, journal: &mut Journal, time: &NodeTime) {
        if self.settings.trace > 0 && !self.is_host() {
            let parts = time.parts();
            let most = parts.iter().max_by_key(|part| part.1);
            journal.notes.trace.push(TraceEvent {
                name: most.map_or("", |part| part.0),
                node: self.here.0,
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
