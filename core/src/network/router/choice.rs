//! Which packet goes next.

use super::super::buffers::{ARRIVED, Fifo};
use super::{Channel, Lane, Port, Router};

/// What leaves next by a port.
pub(super) struct Sent {
    pub(super) queue: usize,
    /// The lane that it takes there.
    pub(super) lane: Lane,
}

impl Router<'_> {
    /// The queue whose head leaves by this port next, and the lane it takes there.
    pub(super) fn next_for(&self, port: Port) -> Option<Sent> {
        let state = self.memory.ports.get(usize::from(port.0)).filter(|state| state.waiting > 0)?;
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
        if self.arrived == 0 {
            return None;
        }
        let turn = self.turns.get(channel as usize).copied().unwrap_or_default();
        let heads = (ARRIVED, self.arrived);
        self.most_urgent(heads, turn, |queue, _| self.carries(queue, channel))
    }

    /// Of the queues whose heads go there, so many in all, the one with the most urgent head; among equals the first from that whose turn it is.
    fn most_urgent(
        &self,
        (port, mut heads): (u16, u16),
        turn: u16,
        is_one: impl Fn(usize, &Fifo) -> bool,
    ) -> Option<usize> {
        let queues = self.memory.fifos.get(..self.size.queues())?;
        let mut best: Option<(u8, bool, usize)> = None;
        for (queue, fifo) in queues.iter().enumerate() {
            if fifo.port != port {
                continue;
            }
            let order = (fifo.priority, queue < usize::from(turn), queue);
            if best.is_none_or(|best| order < best) && is_one(queue, fifo) {
                best = Some(order);
            }
            heads = heads.saturating_sub(1);
            if heads == 0 {
                break;
            }
        }
        best.map(|(.., queue)| queue)
    }

    /// Another packet went before the heads of these queues.
    pub(super) fn pass_over(&mut self, is_one: impl Fn(usize, &Fifo) -> bool) {
        for queue in 0..self.size.queues() {
            let Some(fifo) = self.memory.fifos.get(queue) else { break };
            if fifo.len == 0 || !is_one(queue, fifo) {
                continue;
            }
            let head = self.slot(queue, usize::from(fifo.first));
            if let (Some(fifo), Some(slot)) =
                (self.memory.fifos.get_mut(queue), self.memory.slots.get_mut(head))
            {
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
