use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// What can happen at a place.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Event {
    /// A packet has come to the end of a link.
    Arrive {
        /// Which of those here.
        packet: u32,
    },
    /// A node that passes packets on itself has come to one: it lies in a buffer from now on.
    Enter {
        /// Which of those here.
        packet: u32,
    },
    /// A link from here has sent its packet, and another waits.
    Free {
        /// The link, by its port.
        port: u16,
    },
    /// The time for what the actor has done has passed.
    Done,
    /// The actor wanted to be called now at the latest.
    Wake,
    /// Credit may be overdue.
    Remind,
    /// The node dies.
    Crash,
}

/// What is to happen at a place, by time, and of one time in the order in which it was entered.
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
/// The last moment there is, after two years: nothing happens behind it.
const LAST: u64 = u64::MAX >> (SEQUENCE + EVENT - u64::BITS);

impl EventQueue {
    /// Enters what is to happen at a time, if time goes so far: a call for a later deadline would be too early for ever. O(log n).
    pub(crate) fn push(&mut self, time: u64, event: Event) {
        if time > LAST {
            return;
        }
        self.sequence += 1;
        let time = u128::from(time) << (SEQUENCE + EVENT);
        let order = u128::from(self.sequence) << EVENT;
        self.heap.push(Reverse(Entry(time | order | u128::from(event.encode()))));
    }

    /// When the next thing happens; [`u64::MAX`] if nothing will.
    pub(crate) fn due(&self) -> u64 {
        self.heap.peek().map_or(u64::MAX, |Reverse(entry)| entry.time())
    }

    /// What happens next, and when. O(log n).
    pub(crate) fn pop(&mut self) -> Option<(u64, Event)> {
        let Reverse(entry) = self.heap.pop()?;
        Some((entry.time(), Event::decode(entry.0 as u32)))
    }
}

impl Entry {
    const fn time(self) -> u64 {
        (self.0 >> (SEQUENCE + EVENT)) as u64
    }
}

impl Event {
    const fn encode(self) -> u32 {
        let (kind, at) = match self {
            Self::Arrive { packet } => (0, packet),
            Self::Free { port } => (1, port as u32),
            Self::Done => (2, 0),
            Self::Wake => (3, 0),
            Self::Remind => (4, 0),
            Self::Crash => (5, 0),
            Self::Enter { packet } => (6, packet),
        };
        debug_assert!(at < 1 << (u32::BITS - KIND));
        at << KIND | kind
    }

    const fn decode(event: u32) -> Self {
        let at = event >> KIND;
        match event & ((1 << KIND) - 1) {
            0 => Self::Arrive { packet: at },
            1 => Self::Free { port: at as u16 },
            2 => Self::Done,
            3 => Self::Wake,
            4 => Self::Remind,
            5 => Self::Crash,
            _ => Self::Enter { packet: at },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_entered_first_happens_first_at_a_time() {
        let mut queue = EventQueue::default();
        for (time, packet) in [(5, 0), (3, 1), (5, 2), (3, 3), (4, 4)] {
            queue.push(time, Event::Arrive { packet });
        }
        assert_eq!(queue.due(), 3);
        let order = std::iter::from_fn(|| queue.pop());
        let expected = [(3, 1), (3, 3), (4, 4), (5, 0), (5, 2)];
        assert!(order.eq(expected.map(|(time, packet)| (time, Event::Arrive { packet }))));
        assert_eq!(queue.due(), u64::MAX);
    }

    #[test]
    fn what_is_entered_comes_out() {
        let events = [
            Event::Arrive { packet: (1 << (u32::BITS - KIND)) - 1 },
            Event::Free { port: u16::MAX },
            Event::Done,
            Event::Wake,
            Event::Remind,
            Event::Crash,
        ];
        let mut queue = EventQueue::default();
        events.iter().for_each(|&event| queue.push(LAST, event));
        assert!(events.iter().all(|&event| queue.pop() == Some((LAST, event))));
        // A time limit may be as far away as there are numbers.
        queue.push(LAST + 1, Event::Wake);
        queue.push(u64::MAX, Event::Wake);
        queue.push(7, Event::Done);
        assert_eq!(queue.pop(), Some((7, Event::Done)));
        assert_eq!(queue.pop(), None);
    }
}
