use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// What can happen. Places are nodes by number, and after them the host.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Event {
    /// A packet has come to the end of a link.
    Arrive {
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

/// Time, sequence and event in one number, most significant first: a heap of numbers is what it takes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Entry(u128);

/// Bits of a sequence number, of which none is used twice: 10¹² events.
const SEQUENCE: u32 = 40;
/// Bits of an event: its kind, and where.
const EVENT: u32 = 32;
const KIND: u32 = 3;
/// The last moment that is told from others: after two years.
const LAST: u64 = u64::MAX >> (SEQUENCE + EVENT - u64::BITS);

impl EventQueue {
    /// Enters what is to happen at a time. O(log n).
    pub(crate) fn push(&mut self, time: u64, event: Event) {
        self.sequence += 1;
        let time = u128::from(time.min(LAST)) << (SEQUENCE + EVENT);
        let order = u128::from(self.sequence) << EVENT;
        self.heap.push(Reverse(Entry(time | order | u128::from(event.encode()))));
    }

    /// What happens next, and when. O(log n).
    pub(crate) fn pop(&mut self) -> Option<(u64, Event)> {
        let Reverse(Entry(entry)) = self.heap.pop()?;
        Some(((entry >> (SEQUENCE + EVENT)) as u64, Event::decode(entry as u32)))
    }
}

impl Event {
    const fn encode(self) -> u32 {
        let (kind, at) = match self {
            Self::Arrive { packet } => (0, packet),
            Self::Free { link } => (1, link),
            Self::Done { place } => (2, place),
            Self::Wake { place } => (3, place),
            Self::Remind { place } => (4, place),
            Self::Crash { place } => (5, place),
        };
        debug_assert!(at < 1 << (u32::BITS - KIND));
        at << KIND | kind
    }

    const fn decode(event: u32) -> Self {
        let at = event >> KIND;
        match event & ((1 << KIND) - 1) {
            0 => Self::Arrive { packet: at },
            1 => Self::Free { link: at },
            2 => Self::Done { place: at },
            3 => Self::Wake { place: at },
            4 => Self::Remind { place: at },
            _ => Self::Crash { place: at },
        }
    }
}

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

    #[test]
    fn what_is_entered_comes_out() {
        let at = (1 << (u32::BITS - KIND)) - 1;
        let (packet, link, place) = (at, at, at);
        let events = [
            Event::Arrive { packet },
            Event::Free { link },
            Event::Done { place },
            Event::Wake { place: 0 },
            Event::Remind { place },
            Event::Crash { place },
        ];
        let mut queue = EventQueue::default();
        events.iter().for_each(|&event| queue.push(LAST, event));
        assert!(events.iter().all(|&event| queue.pop() == Some((LAST, event))));
        // A time limit may be as far away as there are numbers.
        queue.push(u64::MAX, events[3]);
        queue.push(7, events[0]);
        assert_eq!(queue.pop(), Some((7, events[0])));
        assert_eq!(queue.pop(), Some((LAST, events[3])));
    }
}
