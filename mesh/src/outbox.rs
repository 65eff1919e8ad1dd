use kiloray_core::network::{Channel, HOST_REPLY_MAX, NodeId, Router};
use kiloray_core::protocol::{Message, write};
use std::collections::VecDeque;

/// Replies that have not left yet.
#[derive(Debug, Default)]
pub(super) struct Outbox {
    packets: VecDeque<Packet>,
}

#[derive(Debug)]
struct Packet {
    to: NodeId,
    priority: u8,
    payload: Vec<u8>,
}

/// So many packets that wait are enough.
const PACKETS_MAX: usize = 256;

impl Outbox {
    /// Adds a reply behind the others to this node, in packets of at most `room` bytes where more than one is in a packet.
    pub(super) fn push(&mut self, to: NodeId, message: &Message<'_>, room: usize) {
        let mut bytes = [0; HOST_REPLY_MAX];
        let Some(reply) = write(&mut bytes, 0, message).and_then(|len| bytes.get(..len)) else {
            return;
        };
        let priority = message.priority();
        let is_like = |packet: &&mut Packet| (packet.to, packet.priority) == (to, priority);
        match self.packets.iter_mut().rev().find(is_like) {
            Some(last) if last.payload.len() + reply.len() <= room => {
                last.payload.extend_from_slice(reply);
            }
            _ => self.packets.push_back(Packet { to, priority, payload: reply.to_vec() }),
        }
    }

    /// Whether so many wait that no more should be added.
    pub(super) fn is_full(&self) -> bool {
        self.packets.len() >= PACKETS_MAX
    }

    /// Sends what the router takes: whether that is all.
    pub(super) fn send(&mut self, router: &mut Router<'_>) -> bool {
        while let Some(Packet { to, priority, payload }) = self.packets.front() {
            // What is refused though there is room is for a node that does not exist: nobody waits for it.
            let refused = router.inject(*to, Channel::Reply, *priority, payload).is_err();
            if refused && router.room(Channel::Reply) == 0 {
                return false;
            }
            let _ = self.packets.pop_front();
        }
        true
    }
}
