//! Credits of one channel of a link, one credit for each packet buffer at the far end.
//!
//! Counts are cumulative and 16 bits wide (they wrap): the sender numbers its packets, the receiver tells
//! up to which number it has room. A lost or repeated credit therefore heals with the next, and a
//! lost packet gives its buffer back as soon as the receiver learns of a later number: from the next
//! packet, or from a *probe* that a sender without credit repeats on a timer.
//!
//! # Invariants
//! * What is on the way and what is held together never exceed the capacity, whatever is lost,
//!   doubled or delayed: a packet that arrives finds a buffer.
//! * A packet is accepted once at most. One that a later one has overtaken is dropped, like a lost one.
//! * From every state the sender gets credit again, if a probe and its answer pass and buffers are released.

use bytemuck::{Pod, Zeroable};

/// The number of a packet on its channel; wraps.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Pod, Zeroable)]
#[repr(transparent)]
pub struct Sequence(pub u16);

impl Sequence {
    /// How far `self` is ahead of `other`: negative if behind.
    pub(super) fn ahead_of(self, other: Self) -> i16 {
        self.0.wrapping_sub(other.0) as i16
    }
}

/// The sending end.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Pod, Zeroable)]
#[repr(C)]
pub struct CreditSender {
    /// Number of the last packet sent.
    sent: Sequence,
    /// Number of the last packet for which there is room.
    limit: Sequence,
    /// Buffers at the far end.
    capacity: u16,
}

impl CreditSender {
    /// Both ends begin with the far end's buffers free. `capacity` is at most 2¹⁴.
    #[must_use]
    pub const fn new(capacity: u16) -> Self {
        debug_assert!(capacity <= 1 << 14);
        Self { sent: Sequence(0), limit: Sequence(capacity), capacity }
    }

    /// Packets that may leave now.
    #[must_use]
    pub fn available(&self) -> u16 {
        self.limit.ahead_of(self.sent).max(0) as u16
    }

    /// Whether the far end's buffers are all free, as far as it is known.
    pub(super) fn is_full(&self) -> bool {
        self.available() >= self.capacity
    }

    /// Takes a credit; the packet carries the number. `None` without credit.
    #[must_use]
    pub fn take(&mut self) -> Option<Sequence> {
        if self.available() == 0 {
            return None;
        }
        self.sent = Sequence(self.sent.0.wrapping_add(1));
        Some(self.sent)
    }

    /// What a probe carries: the number of the last packet sent.
    #[must_use]
    pub const fn probe(&self) -> Sequence {
        self.sent
    }

    /// A credit has come. An older one than what is known changes nothing, nor one for more packets than the far end has buffers: no end of this
    /// link has sent that.
    pub fn grant(&mut self, limit: Sequence) {
        let is_newer = limit.ahead_of(self.limit) > 0;
        if is_newer && limit.0.wrapping_sub(self.sent.0) <= self.capacity {
            self.limit = limit;
        }
    }
}

#[cfg(test)]
impl CreditSender {
    /// Takes so much off all numbers.
    pub(super) fn rebase(&mut self, by: u16) {
        self.sent.0 = self.sent.0.wrapping_sub(by);
        self.limit.0 = self.limit.0.wrapping_sub(by);
    }
}

#[cfg(test)]
impl CreditReceiver {
    /// Takes so much off all numbers.
    pub(super) fn rebase(&mut self, by: u16) {
        self.seen.0 = self.seen.0.wrapping_sub(by);
    }

    /// Number of the last packet accounted for.
    pub(super) fn seen(&self) -> u16 {
        self.seen.0
    }
}

/// What an arriving packet is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Arrival {
    /// New: it takes a buffer. So many before it were lost.
    Accepted {
        /// Packets that will not come any more.
        lost: u16,
    },
    /// Seen before, or overtaken, or from no sender of ours: drop it.
    Stale,
}

/// The receiving end.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Pod, Zeroable)]
#[repr(C)]
pub struct CreditReceiver {
    /// Number of the last packet accounted for.
    seen: Sequence,
    /// Buffers in use.
    held: u16,
    capacity: u16,
}

impl CreditReceiver {
    /// With all of `capacity` buffers free; at most 2¹⁴.
    #[must_use]
    pub const fn new(capacity: u16) -> Self {
        debug_assert!(capacity <= 1 << 14);
        Self { seen: Sequence(0), held: 0, capacity }
    }

    /// A packet has come.
    pub fn receive(&mut self, number: Sequence) -> Arrival {
        let Some(lost) = self.skipped(number) else { return Arrival::Stale };
        self.seen = number;
        self.held += 1;
        Arrival::Accepted { lost }
    }

    /// A probe has come: all up to its number that are not here are lost, and their buffers free. Answer with
    /// [`limit`](Self::limit). Gives the number of packets found lost.
    pub fn probe(&mut self, sent: Sequence) -> u16 {
        let Some(lost) = self.skipped(sent) else { return 0 };
        self.seen = sent;
        lost + 1
    }

    /// A buffer is free again.
    pub fn release(&mut self) {
        debug_assert!(self.held > 0, "a buffer is released once");
        self.held = self.held.saturating_sub(1);
    }

    /// Up to which number there is room: sent with every packet of the other direction, and on a timer.
    #[must_use]
    pub fn limit(&self) -> Sequence {
        Sequence(self.seen.0.wrapping_add(self.capacity).wrapping_sub(self.held))
    }

    /// Buffers in all.
    pub(super) const fn capacity(&self) -> u16 {
        self.capacity
    }

    /// Buffers in use.
    #[must_use]
    pub const fn held(&self) -> u16 {
        self.held
    }

    /// How many numbers lie between what was seen and this one; `None` if it is not new, or beyond the room
    /// that was granted (a forged or corrupt number).
    fn skipped(&self, number: Sequence) -> Option<u16> {
        let ahead = u16::try_from(number.ahead_of(self.seen)).ok()?;
        let room = self.capacity.saturating_sub(self.held);
        (1..=room).contains(&ahead).then(|| ahead - 1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lost_packet_gives_its_credit_back() {
        let (mut sender, mut receiver) = (CreditSender::new(2), CreditReceiver::new(2));
        let lost = sender.take();
        assert_eq!(lost, Some(Sequence(1)));
        let Some(second) = sender.take() else { panic!() };
        assert_eq!(sender.take(), None);
        assert_eq!(receiver.receive(second), Arrival::Accepted { lost: 1 });
        sender.grant(receiver.limit());
        assert_eq!(sender.available(), 1);
        receiver.release();
        sender.grant(receiver.limit());
        assert_eq!(sender.available(), 2);
    }

    #[test]
    fn numbers_wrap() {
        let (mut sender, mut receiver) = (CreditSender::new(3), CreditReceiver::new(3));
        for _ in 0..200_000 {
            let number = sender.take().unwrap();
            assert_eq!(receiver.receive(number), Arrival::Accepted { lost: 0 });
            assert_eq!(receiver.receive(number), Arrival::Stale);
            receiver.release();
            sender.grant(receiver.limit());
        }
    }

    #[test]
    fn a_forged_number_is_stale() {
        let mut receiver = CreditReceiver::new(3);
        for number in [0, 4, 5, 0x7fff, 0x8000, 0xffff] {
            assert_eq!(receiver.receive(Sequence(number)), Arrival::Stale);
            assert_eq!(receiver.probe(Sequence(number)), 0);
        }
        assert_eq!(receiver.limit(), Sequence(3));
    }

    #[test]
    fn a_forged_credit_changes_nothing() {
        let mut sender = CreditSender::new(3);
        assert_eq!(sender.take(), Some(Sequence(1)));
        for limit in [5, 6, 0x7fff, 0x8000, 0x8003, 0xffff, 0, 2] {
            sender.grant(Sequence(limit));
            assert_eq!(sender.available(), 2);
        }
        sender.grant(Sequence(4));
        assert_eq!(sender.available(), 3);
    }
}
