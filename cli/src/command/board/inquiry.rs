//! The host asks all nodes what they have done, one after the other.

use kiloray_core::{
    network::{NodeId, Router},
    node::{Time, signal},
    protocol::Message,
};
use kiloray_mesh::Ledger;

/// How often a node is asked.
const TRIES: u8 = 3;

/// Who is asked, and until when its answer is awaited.
#[derive(Debug)]
pub(super) struct Inquiry {
    nodes: u16,
    /// How long an answer may take \[ns\].
    patience: Time,
    node: u16,
    tries: u8,
    until: Time,
}

impl Inquiry {
    pub(super) fn new(nodes: u16, patience: Time) -> Self {
        Self { nodes, patience, node: 0, tries: 0, until: Time(0) }
    }

    /// Goes on: when to come back at the latest, or `None` when all have told or let it wait too often. A node that is dead lets it wait.
    pub(super) fn poll(
        &mut self,
        now: Time,
        ledger: &Ledger,
        router: &mut Router<'_>,
    ) -> Option<Time> {
        while self.node < self.nodes {
            let has_told = ledger.told().contains_key(&self.node);
            if !has_told && now < self.until {
                return Some(self.until);
            }
            if has_told || self.tries == TRIES {
                (self.node, self.tries, self.until) = (self.node + 1, 0, Time(0));
                continue;
            }
            // Where there is no room it is asked again later.
            signal(router, NodeId(self.node), &Message::Tell);
            self.tries += 1;
            self.until = now.after(self.patience);
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use kiloray_core::{
        network::{HOST, Mesh, RouterSize, Topology},
        node::Figures,
        shade::Unit,
        store::{Arena, CHUNK_BYTES, Chunk},
    };

    use super::*;

    /// The second of three is dead: the others tell at once, it is asked three times.
    #[test]
    fn who_is_silent_is_asked_again_and_left() {
        let mesh = Mesh::new(Topology::parse("ring", 3).expect("a topology"));
        let size = RouterSize::new(&mesh, HOST, 8, 256);
        let mut memory = vec![Chunk::ZERO; size.arena_bytes() / CHUNK_BYTES];
        let router = Router::new(&mut Arena::new(&mut memory), mesh, HOST, size);
        let mut router = router.expect("there is room");
        let mut ledger = Ledger::new(8, 8, 4, 0, Unit::new(1.0), 1).expect("a picture");
        let mut inquiry = Inquiry::new(3, Time(1_000));
        let (mut now, mut asked) = (Time(0), Vec::new());
        while let Some(until) = inquiry.poll(now, &ledger, &mut router) {
            asked.push((inquiry.node, now.0));
            if inquiry.node == 1 {
                now = until;
            } else {
                let told = Message::Told { figures: &[0; Figures::BYTES] };
                ledger.on_message(now, NodeId(inquiry.node), &told, &mut |_, _| {});
            }
        }
        assert_eq!(asked, [(0, 0), (1, 0), (1, 1_000), (1, 2_000), (2, 3_000)]);
        assert_eq!(ledger.told().keys().copied().collect::<Vec<_>>(), [0, 2]);
    }
}
