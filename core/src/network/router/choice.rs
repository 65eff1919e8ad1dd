//! Which packet goes next.

use super::super::buffers::{ARRIVED, Fifo};
use super::super::heads::Heads;
use super::{Channel, Lane, Port, Router, is_of};

/// What leaves next by a port.
pub(super) struct Sent {
    pub(super) queue: usize,
    /// The lane that it takes there.
    pub(super) lane: Lane,
}

impl Router<'_> {
    /// The queue whose head leaves by this port next, and the lane it takes there.
    pub(super) fn next_for(&self, port: Port) -> Option<Sent> {
        let state =
            self.memory.ports.get(usize::from(port.0)).filter(|state| !state.waiting.is_empty())?;
        let lane = |queue, fifo: &Fifo| Lane::new(self.channel_of(queue), fifo.class);
        let has_credit = |queue, fifo: &Fifo| {
            state.senders.get(lane(queue, fifo).index()).is_some_and(|s| s.available() > 0)
        };
        let queue = self.most_urgent((port.0, state.waiting), state.turn, |queue, fifo| {
            has_credit(queue, fifo) && !self.is_held(queue)
        })?;
        Some(Sent { queue, lane: lane(queue, self.memory.fifos.get(queue)?) })
    }

    pub(super) fn arrived_queue(&self, channel: Channel) -> Option<usize> {
        if self.arrived.is_empty() {
            return None;
        }
        let turn = self.turns.get(channel as usize).copied().unwrap_or_default();
        let heads = (ARRIVED, self.arrived);
        self.most_urgent(heads, turn, |queue, _| self.carries(queue, channel))
    }

    /// Of the queues whose heads go there, the one with the most urgent head; among equals the first from that whose turn it is.
    fn most_urgent(
        &self,
        (port, heads): (u16, Heads),
        turn: u16,
        is_one: impl Fn(usize, &Fifo) -> bool,
    ) -> Option<usize> {
        let mut best: Option<(u8, bool, usize)> = None;
        for queue in heads.queues(self.size.queues()) {
            let fifo = self.memory.fifos.get(queue)?;
            if fifo.port != port {
                continue;
            }
            let order = (fifo.priority, queue < usize::from(turn), queue);
            if best.is_none_or(|best| order < best) && is_one(queue, fifo) {
                best = Some(order);
            }
        }
        best.map(|(.., queue)| queue)
    }

    /// The head of a queue goes before the others that go the same way, of its channel alone if there is one.
    pub(super) fn pass_over(
        &mut self,
        heads: Heads,
        (port, channel): (u16, Option<Channel>),
        first: usize,
    ) {
        for queue in heads.queues(self.size.queues()) {
            let place = self.place(queue);
            let Some(fifo) = self.memory.fifos.get_mut(queue) else { break };
            let is_one = fifo.port == port && channel.is_none_or(|of| is_of(queue, of));
            if queue == first || !is_one {
                continue;
            }
            if let Some(slot) = self.memory.slots.get_mut(place.slot(fifo.first.into())) {
                slot.priority = slot.priority.saturating_sub(1);
                fifo.priority = slot.priority;
            }
        }
    }
}

/// Of a packet that nothing went before.
pub(super) const fn fresh(priority: u8) -> u8 {
    const LEAST: u8 = 7;
    if priority < LEAST { u8::MAX - LEAST + priority } else { u8::MAX }
}
