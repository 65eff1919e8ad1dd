mod claims;
mod session;

use std::collections::{BTreeMap, VecDeque};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::Duration;

use kiloray_core::network::{NodeId, Port};
use zenoh::liveliness::LivelinessToken;
use zenoh::pubsub::{Publisher, Subscriber};
use zenoh::qos::{CongestionControl, Priority};
use zenoh::sample::{Sample, SampleKind};
use zenoh::{Session, Wait};

use claims::Claims;

use crate::{Config, Error, Event, Frame, Identity, Job, NodeReport, Place, Transport};

/// A place's end of a network of Zenoh sessions: a session for each process, which listens at the node's address and has a connection to each
/// neighbour and to the host.
///
/// A link is a topic for each direction, over one connection and with one priority, so that packets keep their order: routers take one that was overtaken
/// for lost. The credits of routers bound what is under way on a link, so that the engine never has to hold back or to drop anything; if it had to, it would drop it at once,
/// and it would be sent again. What is urgent overtakes in the routers.
///
/// Who is there shows by liveliness tokens: a process subscribes to its links, then to tokens, then declares its own. So whoever sees it can
/// send to it, and is known to it.
#[derive(Debug)]
pub struct Network {
    session: Session,
    name: String,
    place: Place,
    inbox: Receiver<Item>,
    /// The message that packets are taken from: by which port it came, and where the next one begins.
    open: Option<(Port, Vec<u8>, usize)>,
    /// What was found there by whoever waited for something else.
    waiting: VecDeque<Item>,
    links: Vec<Option<Link>>,
    /// The neighbour by each port, as in [`Shared`], as far as the one that drives has been told: its links know the numbers of no other.
    told: Vec<u64>,
    shared: Arc<Shared>,
    /// Those that are there, as far as they are connected to this one.
    there: BTreeMap<Place, Identity>,
    changes: Vec<(Identity, bool)>,
    is_over: bool,
    _subscribers: Vec<Subscriber<()>>,
    _token: LivelinessToken,
}

/// The sending half of a link.
#[derive(Debug)]
struct Link {
    publisher: Publisher<'static>,
    /// Packets that leave together, behind their frame; empty if there is none.
    message: Vec<u8>,
}

/// What the engine's threads and the one that drives know.
#[derive(Debug)]
struct Shared {
    own: Identity,
    /// The incarnation of the neighbour by each port, and [`THERE`]; 0 if nobody is there.
    neighbours: Vec<AtomicU64>,
    /// Messages that were no packets, or for or from another process.
    foreign: AtomicU64,
    /// Packets that found no room.
    overflows: AtomicU64,
    claims: Mutex<Claims>,
    /// Of each node the first that has come, for the host.
    reports: Mutex<BTreeMap<u16, NodeReport>>,
}

const THERE: u64 = 1 << 32;

#[derive(Debug)]
enum Item {
    /// A message that came over a link: whole packets behind their frame.
    Packets(Port, Vec<u8>),
    Change(Identity, bool),
    /// Of a link, and who is there now.
    Event(Event, u64),
    Over,
    Report,
}

/// Messages that can wait for this process. Credit allows some tens; beyond are those of somebody who does not keep to it.
const ROOM: usize = 4096;
/// Longest message of packets, if a packet is not longer: it is one batch of the engine, which sends it in one piece.
const MESSAGE_BYTES: usize = 60 << 10;
/// How long it takes at most to leave.
const CLOSE_LIMIT: Duration = Duration::from_millis(500);

impl Network {
    /// Takes a place in the network of a job.
    ///
    /// # Errors
    /// [`Error::Network`]: the address is in use, or cannot be.
    pub fn open(config: &Config, job: &Job, own: Identity) -> Result<Self, Error> {
        let place = own.place;
        let neighbours = job.neighbours(place);
        let session = session::open(config, job, place)?;
        let failed = |error: zenoh::Error| Error::Network(error.to_string());
        let (sender, inbox) = sync_channel(ROOM);
        let ports = usize::from(job.mesh.ports(place.id()));
        let shared = Arc::new(Shared {
            own: own.clone(),
            neighbours: (0..ports).map(|_| AtomicU64::new(0)).collect(),
            foreign: AtomicU64::new(0),
            overflows: AtomicU64::new(0),
            claims: Mutex::new(Claims::new(job.mesh.nodes())),
            reports: Mutex::default(),
        });
        let prefix = format!("kiloray/{}", config.name);
        let mut subscribers = Vec::new();
        let mut links: Vec<Option<Link>> = (0..ports).map(|_| None).collect();
        for &(port, far) in &neighbours {
            let (shared, sender) = (Arc::clone(&shared), sender.clone());
            let most = usize::from(job.layout.packet());
            let subscriber = session
                .declare_subscriber(format!("{prefix}/link/{far}/{place}"))
                .callback(move |sample| shared.packet(&sender, port, most, &sample));
            subscribers.push(subscriber.wait().map_err(failed)?);
            let publisher = session
                .declare_publisher(format!("{prefix}/link/{place}/{far}"))
                .congestion_control(CongestionControl::Drop)
                .priority(Priority::DataHigh)
                .express(true)
                .wait()
                .map_err(failed)?;
            if let Some(link) = links.get_mut(usize::from(port.0)) {
                *link = Some(Link { publisher, message: Vec::new() });
            }
        }
        let topic = if place == Place::HOST { "report/*" } else { "over" };
        let subscriber = session.declare_subscriber(format!("{prefix}/{topic}")).callback({
            let sender = sender.clone();
            let shared = Arc::clone(&shared);
            move |sample| {
                let item = match place {
                    Place::HOST => shared.report(&sample).then_some(Item::Report),
                    _ => shared.is_over(&sample).then_some(Item::Over),
                };
                shared.count(item.is_some());
                // Whoever does not take what lies there finds it later.
                item.map(|item| sender.try_send(item));
            }
        });
        subscribers.push(subscriber.wait().map_err(failed)?);
        let tokens = format!("{prefix}/there");
        let watch = Watch { shared: Arc::clone(&shared), neighbours, last: Mutex::default() };
        let subscriber =
            session.liveliness().declare_subscriber(format!("{tokens}/**")).history(true).callback(
                {
                    let tokens = format!("{tokens}/");
                    move |sample: Sample| {
                        let key = sample.key_expr().as_str().strip_prefix(&tokens);
                        let identity = key.and_then(Identity::from_key);
                        watch.hear(&sender, identity, sample.kind() == SampleKind::Put);
                    }
                },
            );
        subscribers.push(subscriber.wait().map_err(failed)?);
        let token = session.liveliness().declare_token(format!("{tokens}/{}", own.to_key()));
        let token = token.wait().map_err(failed)?;
        Ok(Self {
            session,
            name: config.name.clone(),
            place,
            inbox,
            open: None,
            waiting: VecDeque::new(),
            links,
            told: vec![0; ports],
            shared,
            there: BTreeMap::new(),
            changes: Vec::new(),
            is_over: false,
            _subscribers: subscribers,
            _token: token,
        })
    }

    /// Waits for news of the others, so long at most. For those that do not look at packets yet, or any more.
    pub fn wait_for_news(&mut self, most: Duration) {
        let first = self.inbox.recv_timeout(most).ok();
        let mut item = first;
        while let Some(found) = item {
            let rest = self.sort(found);
            self.waiting.extend(rest);
            item = self.inbox.try_recv().ok();
        }
    }

    /// Who has come or gone since the last call, the oldest first: what it says of itself, and whether it is there now.
    pub fn take_changes(&mut self) -> Vec<(Identity, bool)> {
        std::mem::take(&mut self.changes)
    }

    /// What a place says of itself, if it is there.
    #[must_use]
    pub fn there(&self, place: Place) -> Option<&Identity> {
        self.there.get(&place)
    }

    /// Whether the host has said that the picture is complete, or that nobody waits for it any more.
    #[must_use]
    pub const fn is_over(&self) -> bool {
        self.is_over
    }

    /// The host says so.
    ///
    /// # Errors
    /// [`Error::Network`].
    pub fn say_over(&self) -> Result<(), Error> {
        self.say("over".into(), self.shared.own.incarnation.to_le_bytes().into())
    }

    /// A node sends its report to the host.
    ///
    /// # Errors
    /// [`Error::Network`].
    pub fn report(&self, report: Vec<u8>) -> Result<(), Error> {
        self.say(format!("report/{}", self.place), report)
    }

    /// Reports that have come since the last call, by node.
    pub fn take_reports(&mut self) -> BTreeMap<u16, NodeReport> {
        std::mem::take(&mut *lock(&self.shared.reports))
    }

    /// Messages that were no packets, reports or other news, or were for or from a process that is not there, or not any more.
    #[must_use]
    pub fn foreign(&self) -> u64 {
        self.shared.foreign.load(Ordering::Relaxed) + self.shared.overflows.load(Ordering::Relaxed)
    }

    /// Leaves the network when all that was said has left, or has had the time for it.
    pub fn close(self) {
        let (done, is_done) = sync_channel(1);
        // The engine waits for up to ten seconds for the last word of neighbours that are no more.
        thread::spawn(move || {
            let _ = self.session.close().wait();
            let _ = done.send(());
        });
        let _ = is_done.recv_timeout(CLOSE_LIMIT);
    }

    fn say(&self, topic: String, bytes: Vec<u8>) -> Result<(), Error> {
        let said = self
            .session
            .put(format!("kiloray/{}/{topic}", self.name), bytes)
            .congestion_control(CongestionControl::Block)
            .express(true)
            .wait();
        said.map_err(|error| Error::Network(error.to_string()))
    }

    /// Notes what does not concern links; gives what does.
    fn sort(&mut self, item: Item) -> Option<Item> {
        match item {
            Item::Change(identity, is_there) => {
                if is_there {
                    self.there.insert(identity.place, identity.clone());
                } else if self.there.get(&identity.place) == Some(&identity) {
                    self.there.remove(&identity.place);
                }
                self.changes.push((identity, is_there));
            }
            Item::Over => self.is_over = true,
            Item::Report => {}
            Item::Packets(..) | Item::Event(..) => return Some(item),
        }
        None
    }
}

impl Transport for Network {
    fn next(&mut self, packet: &mut [u8]) -> Option<Event> {
        loop {
            if let Some((port, message, at)) = &mut self.open {
                let rest = message.get(*at..).and_then(Frame::next);
                if let Some((body, rest)) = rest {
                    *at = message.len() - rest.len();
                    // Its length was looked at when it came.
                    if let Some(packet) = packet.get_mut(..body.len()) {
                        packet.copy_from_slice(body);
                        return Some(Event::Packet { port: *port, len: body.len() });
                    }
                    continue;
                }
                self.open = None;
            }
            let item = self.waiting.pop_front().or_else(|| self.inbox.try_recv().ok())?;
            match self.sort(item) {
                Some(Item::Event(event, neighbour)) => {
                    if let Event::Up { port, .. } | Event::Down { port } = event
                        && let Some(told) = self.told.get_mut(usize::from(port.0))
                    {
                        *told = neighbour;
                    }
                    return Some(event);
                }
                Some(Item::Packets(port, message)) => {
                    self.open = Some((port, message, Frame::BYTES));
                }
                _ => {}
            }
        }
    }

    fn send(&mut self, port: Port, packet: &[u8]) {
        let at = usize::from(port.0);
        let (Some(Some(link)), Some(&neighbour)) = (self.links.get_mut(at), self.told.get(at))
        else {
            return;
        };
        if neighbour & THERE == 0 {
            return;
        }
        let frame = Frame { from: self.shared.own.incarnation, to: neighbour as u32 }.bytes();
        // Whoever is there now may have come since the packets before.
        let is_full = link.message.len() + packet.len() > MESSAGE_BYTES;
        if is_full || !link.message.starts_with(&frame) {
            link.flush();
            link.message.extend_from_slice(&frame);
        }
        Frame::add(&mut link.message, packet);
    }

    fn flush(&mut self) {
        self.links.iter_mut().flatten().for_each(Link::flush);
    }

    fn wait(&mut self, most: Duration) {
        if self.waiting.is_empty() {
            self.waiting.extend(self.inbox.recv_timeout(most).ok());
        }
    }
}

impl Link {
    fn flush(&mut self) {
        if !self.message.is_empty() {
            // What cannot be sent is lost.
            let _ = self.publisher.put(std::mem::take(&mut self.message)).wait();
        }
    }
}

impl Shared {
    /// Counts what nobody in the mesh has sent.
    fn count(&self, is_ours: bool) {
        self.foreign.fetch_add(u64::from(!is_ours), Ordering::Relaxed);
    }

    /// Whether the host that is there says that it is over.
    fn is_over(&self, sample: &Sample) -> bool {
        let claims = lock(&self.claims);
        let host = claims.holder(Place::HOST).map(|host| host.incarnation.to_le_bytes());
        let payload = sample.payload();
        host.is_some_and(|host| payload.len() == host.len() && *payload.to_bytes() == host)
    }

    /// Keeps a report, if it is the first of a node that is there.
    fn report(&self, sample: &Sample) -> bool {
        let payload = sample.payload();
        let read = || NodeReport::parse(&payload.to_bytes());
        let Some(report) = (payload.len() <= NodeReport::BYTES_MAX).then(read).flatten() else {
            return false;
        };
        let place = Place::new(NodeId(report.node));
        let is_its = lock(&self.claims)
            .holder(place)
            .is_some_and(|node| node.incarnation == report.incarnation);
        if is_its {
            lock(&self.reports).entry(report.node).or_insert(report);
        }
        is_its
    }

    /// A message has come over a link, which holds packets of at most so many bytes.
    fn packet(&self, sender: &SyncSender<Item>, port: Port, most: usize, sample: &Sample) {
        let payload = sample.payload();
        let known = self.neighbours.get(usize::from(port.0)).map(|n| n.load(Ordering::Acquire));
        let longest = Frame::BYTES + MESSAGE_BYTES.max(most) + size_of::<u16>();
        let bytes = (payload.len() <= longest).then(|| payload.to_bytes());
        let is_ours = bytes.as_deref().and_then(Frame::split).is_some_and(|(frame, packets)| {
            frame.to == self.own.incarnation
                && known == Some(THERE | u64::from(frame.from))
                && Frame::is_whole(packets, most)
        });
        self.count(is_ours);
        if let Some(bytes) = bytes.filter(|_| is_ours)
            && sender.try_send(Item::Packets(port, bytes.into_owned())).is_err()
        {
            self.overflows.fetch_add(1, Ordering::Relaxed);
        }
    }
}

/// Sees who comes and goes.
struct Watch {
    shared: Arc<Shared>,
    neighbours: Vec<(Port, Place)>,
    /// The last incarnation at each place.
    last: Mutex<BTreeMap<Place, u32>>,
}

impl Watch {
    /// Somebody says that it is there, or is gone.
    fn hear(&self, sender: &SyncSender<Item>, identity: Option<Identity>, is_there: bool) {
        // Held until it has been passed on: who is found there by what comes meanwhile, as the word that the run is over, was heard of before that.
        let mut claims = lock(&self.shared.claims);
        let changes = identity.and_then(|identity| claims.change(identity, is_there));
        self.shared.count(changes.is_some());
        for (identity, is_there) in changes.into_iter().flatten() {
            self.change(sender, identity, is_there);
        }
    }

    fn change(&self, sender: &SyncSender<Item>, identity: Identity, is_there: bool) {
        let mut last = lock(&self.last);
        let (place, incarnation) = (identity.place, identity.incarnation);
        let works_with_us = identity.differs(&self.shared.own).is_none();
        let ports = self.neighbours.iter().filter(|(_, far)| *far == place && works_with_us);
        for &(port, _) in ports {
            let Some(state) = self.shared.neighbours.get(usize::from(port.0)) else { continue };
            let value = THERE | u64::from(incarnation);
            let event = if is_there {
                let is_new = last.insert(place, incarnation) != Some(incarnation);
                Event::Up { port, is_new }
            } else if state.load(Ordering::Acquire) == value {
                Event::Down { port }
            } else {
                continue;
            };
            // First the word, then the packets: they find a link that has begun anew.
            let now = if is_there { value } else { 0 };
            let _ = sender.send(Item::Event(event, now));
            state.store(now, Ordering::Release);
        }
        let _ = sender.send(Item::Change(identity, is_there));
    }
}

/// What a thread that panicked has left is whole: all changes are one call long.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use std::sync::TryLockError;

    use super::*;

    /// What a node is told by a host that it finds there lies behind the news of the host: it is received by another thread, perhaps at once.
    #[test]
    fn nobody_is_found_that_was_not_heard_of() {
        let at = |place, incarnation| Identity {
            place,
            incarnation,
            version: Identity::version(),
            scene: 0,
            share: 0,
            job: 0,
        };
        let shared = Arc::new(Shared {
            own: at(Place::new(NodeId(0)), 1),
            neighbours: Vec::new(),
            foreign: AtomicU64::new(0),
            overflows: AtomicU64::new(0),
            claims: Mutex::new(Claims::new(1)),
            reports: Mutex::default(),
        });
        let watch =
            Watch { shared: Arc::clone(&shared), neighbours: Vec::new(), last: Mutex::default() };
        let host = at(Place::HOST, 2);
        thread::scope(|scope| {
            // It holds nothing: whoever sends waits until it is taken.
            let (sender, inbox) = sync_channel(0);
            let (watch, heard) = (&watch, Some(host.clone()));
            scope.spawn(move || watch.hear(&sender, heard, true));
            loop {
                match shared.claims.try_lock() {
                    Ok(claims) => assert_eq!(claims.holder(Place::HOST), None),
                    Err(TryLockError::WouldBlock) => break,
                    Err(error) => panic!("{error}"),
                }
                thread::yield_now();
            }
            let Ok(Item::Change(heard, true)) = inbox.recv() else { panic!("it is there") };
            assert_eq!(heard, host);
        });
        assert_eq!(lock(&shared.claims).holder(Place::HOST), Some(&host));
    }
}
