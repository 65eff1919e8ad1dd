use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// What can happen. Places are nodes by number, and after them the host.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Event {
    /// A packet has come to the end of a link.
    Arrive {
        /// The link.
        link: u32,
        /// Where the packet lies.
        packet: u32,
    },
    /// A link has sent its packet, and another waits.
    Free {
        /// The link.
        link: u32,
    },
    /// The time for what an actor has done has passed.
    Done {
        /// Where.
        place: u32,
    },
    /// An actor wanted to be called now at the latest.
    Wake {
        /// Where.
        place: u32,
    },
    /// Credit may be overdue.
    Remind {
        /// Where.
        place: u32,
    },
    /// A node dies.
    Crash {
        /// Which.
        place: u32,
    },
}

/// What is to happen, by time, and of one time in the order in which it was entered.
#[derive(Debug, Default)]
pub(crate) struct EventQueue {
    heap: BinaryHeap<Reverse<Entry>>,
    sequence: u64,
}

#[derive(Debug)]
struct Entry {
    time: u64,
    sequence: u64,
    event: Event,
}

impl EventQueue {
    /// Enters what is to happen at a time. O(log n).
    pub(crate) fn push(&mut self, time: u64, event: Event) {
        self.sequence += 1;
        self.heap.push(Reverse(Entry { time, sequence: self.sequence, event }));
    }

    /// What happens next, and when. O(log n).
    pub(crate) fn pop(&mut self) -> Option<(u64, Event)> {
        self.heap.pop().map(|Reverse(entry)| (entry.time, entry.event))
    }
}

impl Ord for Entry {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        (self.time, self.sequence).cmp(&(other.time, other.sequence))
    }
}

impl PartialOrd for Entry {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Entry {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Entry {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_entered_first_happens_first_at_a_time() {
        let mut queue = EventQueue::default();
        for (time, place) in [(5, 0), (3, 1), (5, 2), (3, 3), (4, 4)] {
            queue.push(time, Event::Done { place });
        }
        let order = std::iter::from_fn(|| queue.pop());
        let expected = [(3, 1), (3, 3), (4, 4), (5, 0), (5, 2)];
        assert!(order.eq(expected.map(|(time, place)| (time, Event::Done { place }))));
    }
}
