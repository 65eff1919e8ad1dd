//! The state of a router, for checkers of the mesh.

use super::super::packet::LANES;
use super::{Channel, Port, Router};
use crate::protocol::Items;
use crate::tests::snapshot::Snapshot;

impl Router<'_> {
    /// All packets and credit. The packets lie at the front of their queues afterwards.
    pub(crate) fn snapshot(&mut self, snapshot: &mut Snapshot) {
        assert!(!self.holds && self.held == [0; 2]);
        for queue in 0..self.size.queues() {
            while !snapshot.reads() && self.memory.fifos[queue].first > 0 {
                self.turn_round(queue);
            }
            let fifo = &mut self.memory.fifos[queue];
            (fifo.first, fifo.peak) = (0, 0);
            snapshot.pod(&mut fifo.len);
            for place in 0..usize::from(fifo.len) {
                let (at, begin) = (self.place(queue).slot(place), self.place(queue).byte(place));
                let slot = &mut self.memory.slots[at];
                snapshot.pod(slot);
                snapshot.bytes(&mut self.memory.bytes[begin..begin + usize::from(slot.len)]);
            }
            self.note_head(queue);
        }
        (self.changed, self.news) = (0, false);
        self.turns.iter_mut().for_each(|turn| snapshot.pod(turn));
        snapshot.all(self.memory.ports);
    }

    /// Puts the places of a queue one further.
    fn turn_round(&mut self, queue: usize) {
        let place = self.place(queue);
        let (slots, bytes) = (place.slot(0), place.byte(0));
        let [depth, payload] = [place.depth, place.payload].map(usize::from);
        self.memory.slots[slots..slots + depth].rotate_left(1);
        self.memory.bytes[bytes..bytes + depth * payload].rotate_left(payload);
        self.memory.fifos[queue].first -= 1;
    }

    /// By how much each lane of a port has counted what came.
    pub(crate) fn seen(&self, port: Port) -> [u16; LANES] {
        self.memory.ports[usize::from(port.0)].receivers.map(|receiver| receiver.seen())
    }

    /// Takes so much off the numbers of packets that leave by a port, and come by it.
    pub(crate) fn rebase(&mut self, port: Port, leave: [u16; LANES], come: [u16; LANES]) {
        for lane in 0..LANES {
            self.memory.ports[usize::from(port.0)].rebase(lane, leave[lane], come[lane]);
        }
    }

    /// Panics where a head is not noted by where it is to go, or one that is not there is.
    pub(crate) fn check_heads(&self) {
        let queues = self.size.queues();
        let is_noted = |heads: super::Heads, port| {
            let goes = |&at: &usize| self.memory.fifos[at].port == port;
            let all = (0..queues).filter(goes).count();
            let noted = heads.queues(queues).filter(goes).count();
            let is_exact = queues <= 32 || cfg!(feature = "bundles");
            noted == all
                && (queues > 32 || heads.queues(queues).count() == all)
                && (!is_exact || heads.is_empty() == (all == 0))
        };
        let mut ports = self.memory.ports.iter().zip(0..);
        assert!(ports.all(|(state, port)| is_noted(state.waiting, port)));
        assert!(is_noted(self.arrived, super::ARRIVED));
    }

    /// Whether no packet is here and all credit is.
    pub(crate) fn is_idle(&self) -> bool {
        self.buffered() == 0 && !self.is_credit_out()
    }

    /// Whether credit has not come back, apart from that of buffers at ports without a link.
    pub(crate) fn is_credit_out(&self) -> bool {
        let mut ports = self.memory.ports.iter().take(self.size.ports.into());
        ports.any(super::PortState::is_credit_out)
    }

    /// Whether what leaves by a port next is credit without data.
    pub(crate) fn would_tell(&self, port: Port) -> bool {
        self.is_ready(port) && self.next_for(port).is_none()
    }

    /// The channel of the messages at the head of a queue.
    pub(super) fn kind_at_head(&self, queue: usize) -> Option<Channel> {
        Some(Items::new(self.head(queue)?.1).next()?.channel())
    }

    /// Breaks the second rule: all packets take lanes of class 1.
    pub(crate) fn flatten(&mut self) {
        self.memory.slots.iter_mut().for_each(|slot| slot.class = self.size.classes - 1);
        (0..self.size.queues()).for_each(|queue| self.note_head(queue));
    }
}
