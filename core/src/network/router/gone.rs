//! What becomes of packets and credit when nodes or links are gone.

use super::super::buffers::Slot;
use super::super::packet::Lane;
use super::super::port::PortState;
use super::super::{NodeId, Port};
use super::{Router, port_bit};

impl Router<'_> {
    /// Drops all packets for a node that is known to be dead, and gives their credit back (rule 16).
    pub fn forget(&mut self, dead: NodeId) -> u32 {
        self.changed = u64::MAX;
        self.drop_where(|slot| slot.to == dead.0)
    }

    /// The link of a port carries nothing any more: drops all packets that were to leave by it, and gives their credit back. To be
    /// called again whenever something [may leave](Self::take_changed) by it, until there is a link again.
    pub fn cut(&mut self, port: Port) -> u32 {
        self.drop_where(|slot| slot.port == port.0)
    }

    /// The link of a port leads to a router that has just begun: all buffers and credit of the link are as at the beginning. Packets that came by
    /// it and are still here are dropped, as their credit is no more.
    pub fn renew(&mut self, port: Port) {
        let far = self.mesh.neighbour(self.here, port);
        let Some(state) = self.memory.ports.get_mut(usize::from(port.0)) else { return };
        let waiting = state.waiting;
        *state = PortState::new(&self.size, port, far);
        state.waiting = waiting;
        for lane in Lane::ALL {
            let queue = self.queue(usize::from(port.0), lane);
            if let Some(fifo) = self.memory.fifos.get_mut(queue) {
                (fifo.first, fifo.len) = (0, 0);
            }
            self.note_head(queue);
        }
        self.changed |= port_bit(port.0);
    }

    /// Drops packets, and gives their credit back: how many.
    fn drop_where(&mut self, is_doomed: impl Fn(&Slot) -> bool) -> u32 {
        let mut dropped = 0_u32;
        for queue in 0..self.size.queues() {
            let len = self.memory.fifos.get(queue).map_or(0, |fifo| fifo.len);
            if !self.packets(queue).any(&is_doomed) {
                continue;
            }
            for _ in 0..len {
                let Some(slot) = self.slot_at_head(queue) else { break };
                if is_doomed(slot) {
                    self.pop(queue);
                    dropped = dropped.saturating_add(1);
                } else {
                    self.rotate(queue);
                }
            }
        }
        dropped
    }

    /// The packets of a queue, the oldest first.
    fn packets(&self, queue: usize) -> impl Iterator<Item = &Slot> {
        let (lies, fifo) = (self.place(queue), self.memory.fifos.get(queue));
        let depth = usize::from(lies.depth);
        let (first, len) = fifo.map_or((0, 0), |f| (usize::from(f.first), usize::from(f.len)));
        let place = move |at: usize| first.saturating_add(at).checked_rem(depth);
        let slot = move |at| self.memory.slots.get(lies.slot(place(at)?));
        (0..len).filter_map(slot)
    }

    /// Puts the head of a queue at its end.
    fn rotate(&mut self, queue: usize) {
        let place = self.place(queue);
        let depth = usize::from(place.depth);
        let Some(fifo) = self.memory.fifos.get(queue).copied().filter(|f| f.len > 0) else {
            return;
        };
        let (first, len) = (usize::from(fifo.first), usize::from(fifo.len));
        let Some(last) = (first + len).checked_rem(depth) else { return };
        if last != first {
            let (from, to) = (place.slot(first), place.slot(last));
            let slot = self.memory.slots.get(from).copied();
            if let (Some(slot), Some(place)) = (slot, self.memory.slots.get_mut(to)) {
                *place = slot;
            }
            // Byte by byte: this is rare, and `copy_within` can panic where an index has 32 bits.
            let (from, to) = (place.byte(first), place.byte(last));
            for i in 0..usize::from(place.payload) {
                let byte = self.memory.bytes.get(from.saturating_add(i)).copied();
                let place = self.memory.bytes.get_mut(to.saturating_add(i));
                if let (Some(byte), Some(place)) = (byte, place) {
                    *place = byte;
                }
            }
        }
        if let Some(fifo) = self.memory.fifos.get_mut(queue) {
            fifo.first = (first + 1).checked_rem(depth).unwrap_or(0) as u8;
        }
        self.note_head(queue);
    }
}
