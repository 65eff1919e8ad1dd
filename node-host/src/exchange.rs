use std::collections::VecDeque;
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use kiloray_core::network::{Mesh, NodeId, Port};

use crate::{Event, Place, Transport};

/// What can wait for a place; more is lost.
const ROOM: usize = 4096;

/// A network within a process, for tests of what is driven by a [`Transport`]: what its places send lies in channels between them.
#[derive(Debug, Clone)]
pub struct Exchange {
    mesh: Mesh,
    /// Those that are there, by place; the host is the last.
    ends: Arc<Mutex<Vec<Option<End>>>>,
}

/// The channel to whoever is at a place.
#[derive(Debug)]
struct End {
    /// How many were there before.
    number: u32,
    sender: SyncSender<Sent>,
}

/// What lies in a channel.
#[derive(Debug)]
enum Sent {
    Packet(Port, Vec<u8>),
    Change(Event),
}

impl Exchange {
    /// Of the nodes of a mesh and its host; nobody is there yet.
    #[must_use]
    pub fn new(mesh: Mesh) -> Self {
        let ends = (0..=mesh.nodes()).map(|_| None).collect();
        Self { mesh, ends: Arc::new(Mutex::new(ends)) }
    }

    /// Joins a place to its neighbours. Whoever was there before is cut off.
    #[must_use]
    pub fn join(&self, place: Place) -> Wire {
        let mut ends = self.lock();
        let at = self.index(place.id());
        let number = ends[at].as_ref().map_or(0, |end| end.number + 1);
        let (sender, receiver) = sync_channel(ROOM);
        let mut news = VecDeque::new();
        for (port, far, back) in self.links(place.id()) {
            if let Some(end) = &ends[far] {
                let _ = end.sender.try_send(Sent::Change(Event::Up { port: back, is_new: true }));
                news.push_back(Sent::Change(Event::Up { port, is_new: true }));
            }
        }
        ends[at] = Some(End { number, sender });
        drop(ends);
        Wire { exchange: self.clone(), place, number, receiver, news }
    }

    /// The ports of a place that lead somewhere: to which place, and which of its ports leads back.
    fn links(&self, id: NodeId) -> impl Iterator<Item = (Port, usize, Port)> {
        (0..self.mesh.ports(id)).map(Port).filter_map(move |port| {
            let far = self.mesh.neighbour(id, port)?;
            Some((port, self.index(far), self.mesh.reverse(id, port)?))
        })
    }

    fn index(&self, id: NodeId) -> usize {
        usize::from(id.0.min(self.mesh.nodes()))
    }

    fn lock(&self) -> MutexGuard<'_, Vec<Option<End>>> {
        self.ends.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// The end of an [`Exchange`] at a place. When it is dropped, its neighbours see that it is gone.
#[derive(Debug)]
pub struct Wire {
    exchange: Exchange,
    place: Place,
    number: u32,
    receiver: Receiver<Sent>,
    news: VecDeque<Sent>,
}

impl Wire {
    /// Whether it is still the one of its place.
    fn is_current(&self, ends: &[Option<End>]) -> bool {
        let end = ends.get(self.exchange.index(self.place.id())).and_then(Option::as_ref);
        end.is_some_and(|end| end.number == self.number)
    }
}

impl Transport for Wire {
    fn next(&mut self, packet: &mut [u8]) -> Option<Event> {
        loop {
            match self.news.pop_front().or_else(|| self.receiver.try_recv().ok())? {
                Sent::Change(event) => return Some(event),
                Sent::Packet(port, bytes) => {
                    if let Some(packet) = packet.get_mut(..bytes.len()) {
                        packet.copy_from_slice(&bytes);
                        return Some(Event::Packet { port, len: bytes.len() });
                    }
                }
            }
        }
    }

    fn send(&mut self, port: Port, packet: &[u8]) {
        let ends = self.exchange.lock();
        if !self.is_current(&ends) {
            return;
        }
        let to = self.exchange.links(self.place.id()).find(|link| link.0 == port);
        if let Some((_, far, back)) = to
            && let Some(end) = &ends[far]
        {
            let _ = end.sender.try_send(Sent::Packet(back, packet.to_vec()));
        }
    }

    fn flush(&mut self) {}

    fn wait(&mut self, most: Duration) {
        if self.news.is_empty()
            && let Ok(sent) = self.receiver.recv_timeout(most)
        {
            self.news.push_back(sent);
        }
    }
}

impl Drop for Wire {
    fn drop(&mut self) {
        let mut ends = self.exchange.lock();
        if !self.is_current(&ends) {
            return;
        }
        for (_, far, back) in self.exchange.links(self.place.id()) {
            if let Some(end) = &ends[far] {
                let _ = end.sender.try_send(Sent::Change(Event::Down { port: back }));
            }
        }
        ends[self.exchange.index(self.place.id())] = None;
    }
}
