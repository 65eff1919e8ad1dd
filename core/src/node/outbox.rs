use super::{Counts, Time, Work};
use crate::network::{Channel, NodeId, Router};
use crate::protocol::{Item, Items, Message, write};
use bytemuck::{Pod, Zeroable};

/// Open bundles of messages: those of one destination, channel and priority leave in one packet.
///
/// One leaves when it is full, when it is too old, when the table is full, and all leave when the node has nothing to run (rule 6).
/// Each channel always has a place of its own (rule 1).
#[derive(Debug)]
pub(super) struct Outbox<'a> {
    open: &'a mut [Open],
    bytes: &'a mut [u8],
    payload: usize,
    /// Most bundles that were open at once.
    peak: usize,
}

/// A bundle that may still grow.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(super) struct Open {
    since: u64,
    to: u16,
    len: u16,
    priority: u8,
    /// 0 free, else the channel plus one.
    state: u8,
    _zero: [u8; 2],
}

impl Open {
    fn is(&self, channel: Channel) -> bool {
        self.state == channel as u8 + 1
    }

    fn channel(&self) -> Channel {
        if self.is(Channel::Request) { Channel::Request } else { Channel::Reply }
    }
}

impl<'a> Outbox<'a> {
    /// Bundles of `payload` bytes; at least one for each channel.
    pub(super) fn new(open: &'a mut [Open], bytes: &'a mut [u8], payload: usize) -> Self {
        Self { open, bytes, payload, peak: 0 }
    }

    /// Most bundles that were open at once.
    pub(super) const fn peak(&self) -> usize {
        self.peak
    }

    /// Whether one more message of a channel finds room, whatever its size and wherever it goes.
    pub(super) fn has_room(&self, router: &Router<'_>, channel: Channel) -> bool {
        self.place(channel).is_some() || router.room(channel) > 0
    }

    /// Adds a message. `false` if there is no room for it now.
    pub(super) fn push(
        &mut self,
        router: &mut Router<'_>,
        to: NodeId,
        message: &Message<'_>,
        now: Time,
        counts: &mut Counts,
        work: &mut Work,
    ) -> bool {
        let alone = self.push_alone(router, to, message, counts);
        let pushed = alone.or_else(|| self.push_among(router, to, message, now, counts, work));
        let Some(bytes) = pushed else { return false };
        counts.sent.note(message, bytes);
        work.messages = work.messages.saturating_add(1);
        work.copied = work.copied.saturating_add(bytes as u32);
        true
    }

    /// Adds a message to the bundle for where it goes: its length, if there is room.
    fn push_among(
        &mut self,
        router: &mut Router<'_>,
        to: NodeId,
        message: &Message<'_>,
        now: Time,
        counts: &mut Counts,
        work: &mut Work,
    ) -> Option<usize> {
        let (channel, priority) = (message.channel(), message.priority());
        let fits = |open: &Open| open.is(channel) && open.to == to.0 && open.priority == priority;
        let payload = router.payload_of(channel);
        let mut found = None;
        for at in 0..self.open.len() {
            let Some(open) = self.open.get(at).copied().filter(fits) else { continue };
            found = self.append(at, open, message, payload);
            if found.is_none() && router.room(channel) > 0 {
                // Full: it leaves, and makes place.
                self.send(router, at, counts, work);
            }
            if found.is_some() {
                break;
            }
        }
        if found.is_none() {
            let at = match self.place(channel) {
                Some(at) => at,
                None => {
                    let oldest = self.oldest(channel).filter(|_| router.room(channel) > 0);
                    let at = oldest?;
                    self.send(router, at, counts, work);
                    at
                }
            };
            let state = channel as u8 + 1;
            let open = Open { since: now.0, to: to.0, len: 0, priority, state, _zero: [0; 2] };
            found = self.append(at, open, message, payload);
            let open = self.open.iter().filter(|open| open.state != 0).count();
            self.peak = self.peak.max(open);
        }
        found
    }

    /// Writes a piece of a block that leaves no room for others straight into the router, unless others wait to go there: its length.
    fn push_alone(
        &self,
        router: &mut Router<'_>,
        to: NodeId,
        message: &Message<'_>,
        counts: &mut Counts,
    ) -> Option<usize> {
        // A board's packets are short: it would take more flash than it saves time.
        if !cfg!(feature = "bundles") {
            return None;
        }
        let Message::Part { bytes, .. } = message else { return None };
        let len = bytes.len().checked_add(Item::PART_BYTES)?;
        let channel = message.channel();
        if len <= router.payload_of(channel) / 2 || self.open.iter().any(|open| open.is(channel)) {
            return None;
        }
        let room = router.inject_room(to, channel, message.priority(), len).ok()?;
        counts.packets = counts.packets.saturating_add(1);
        write(room, 0, message)
    }

    /// Sends what may not wait longer: all that is urgent or too old, or all.
    pub(super) fn flush(
        &mut self,
        router: &mut Router<'_>,
        now: Time,
        age: Time,
        all: bool,
        counts: &mut Counts,
        work: &mut Work,
    ) {
        for at in 0..self.open.len() {
            let Some(open) = self.open.get(at).copied().filter(|open| open.state != 0) else {
                continue;
            };
            let due = open.priority < PATIENT || now.0.saturating_sub(open.since) >= age.0;
            let channel = open.channel();
            if (all || due) && router.room(channel) > 0 {
                self.send(router, at, counts, work);
            }
        }
    }

    /// Whether a request for a block to this node waits here still.
    pub(super) fn asks_for(&self, block: u32, to: NodeId) -> bool {
        let asks =
            |message| matches!(message, Message::Fetch { block: asked, .. } if asked == block);
        self.open.iter().enumerate().any(|(at, open)| {
            open.is(Channel::Request)
                && open.to == to.0
                && Items::new(self.bundle(at).unwrap_or_default()).any(asks)
        })
    }

    pub(super) fn is_empty(&self) -> bool {
        self.open.iter().all(|open| open.state == 0)
    }

    /// All of it, every bundle begun now.
    #[cfg(test)]
    pub(super) fn snapshot(&mut self, s: &mut crate::tests::snapshot::Snapshot, now: Time) {
        for (at, open) in self.open.iter_mut().enumerate() {
            open.since = if open.state == 0 { 0 } else { now.0 };
            s.pod(open);
            let begin = at * self.payload;
            s.bytes(&mut self.bytes[begin..begin + usize::from(open.len)]);
        }
    }

    /// A free place that this channel may take: one stays for the other channel.
    fn place(&self, channel: Channel) -> Option<usize> {
        let mine = self.open.iter().filter(|open| open.is(channel)).count();
        let free = self.open.iter().position(|open| open.state == 0)?;
        (mine.saturating_add(1) < self.open.len()).then_some(free)
    }

    fn oldest(&self, channel: Channel) -> Option<usize> {
        let mine = self.open.iter().enumerate().filter(|(_, open)| open.is(channel));
        mine.min_by_key(|(_, open)| (open.since, open.priority)).map(|(at, _)| at)
    }

    /// Writes a message behind those of a bundle: its length, if there is room.
    fn append(
        &mut self,
        at: usize,
        mut open: Open,
        message: &Message<'_>,
        payload: usize,
    ) -> Option<usize> {
        let begin = at.checked_mul(self.payload)?;
        let room = self.bytes.get_mut(begin..)?.get_mut(..self.payload.min(payload))?;
        let before = usize::from(open.len);
        let len = write(room, before, message)?;
        open.len = len as u16;
        *self.open.get_mut(at)? = open;
        Some(len.saturating_sub(before))
    }

    fn send(&mut self, router: &mut Router<'_>, at: usize, counts: &mut Counts, work: &mut Work) {
        let Some((&open, bytes)) = self.open.get(at).zip(self.bundle(at)) else { return };
        let channel = open.channel();
        if router.inject(NodeId(open.to), channel, open.priority, bytes).is_ok() {
            counts.packets = counts.packets.saturating_add(1);
            work.copied = work.copied.saturating_add(bytes.len() as u32);
            if let Some(open) = self.open.get_mut(at) {
                *open = Open::zeroed();
            }
        }
    }

    /// The messages of a bundle.
    fn bundle(&self, at: usize) -> Option<&[u8]> {
        let len = usize::from(self.open.get(at)?.len);
        self.bytes.get(at.checked_mul(self.payload)?..)?.get(..len)
    }
}

/// Priorities below this one do not wait for company.
const PATIENT: u8 = 4;
