use super::rules::Rule;
use super::slots::Serve;
use super::work::LIMIT_MAX;
use super::{Node, Time, World};
use crate::network::{Channel, HOST, NodeId};
use crate::protocol::{Items, Message, RayMessage};
use crate::store::Claim;

/// Packets of replies handled in a step.
const REPLIES: usize = 8;

impl<W: World> Node<'_, W> {
    /// Replies are consumed at once: they change a record, or are dropped; what follows is kept there (rule 3).
    pub(super) fn replies(&mut self, now: Time) {
        for _ in 0..REPLIES {
            let Some((from, len)) = self.router.arrived(Channel::Reply).map(|(f, b)| (f, b.len()))
            else {
                break;
            };
            if self.is_reply_stuck() {
                break;
            }
            let mut at = 0;
            while at < len {
                let Some(used) = self.reply(from, at, now) else { break };
                at = at.saturating_add(used);
            }
            self.router.consume(Channel::Reply);
        }
    }

    /// Whether a reply would wait in its link buffer: never, by rules 3, 8 and 11.
    fn is_reply_stuck(&mut self) -> bool {
        if !self.keeps(Rule::ConsumeReplies) && !self.outbox.has_room(&self.router, Channel::Reply)
        {
            return true;
        }
        let home = self.keeps(Rule::HomeSlot) || self.free_len > 0;
        let first = self.keeps(Rule::FrameFirst);
        if home && first {
            return false;
        }
        let Self { router, blocks, fetches, .. } = self;
        match router.arrived(Channel::Reply).and_then(|(_, bytes)| Items::new(bytes).next()) {
            Some(Message::Refusal { .. }) => !home,
            Some(Message::Part { block, .. }) if !first => {
                let waits = fetches.iter().any(|fetch| fetch.is_for(block));
                waits && blocks.cache.reserve(block, Claim::Demand).is_err()
            }
            _ => false,
        }
    }

    /// Handles the reply that begins at byte `at` of the packet that has arrived: its length.
    fn reply(&mut self, from: NodeId, at: usize, now: Time) -> Option<usize> {
        let bytes = self.router.arrived(Channel::Reply)?.1;
        let mut items = Items::new(bytes.get(at..)?);
        let before = items.rest_len();
        let message = items.next();
        let used = before.saturating_sub(items.rest_len());
        let Some(message) = message else {
            self.note_damaged();
            return None;
        };
        self.work.messages = self.work.messages.saturating_add(1);
        self.counts.received.note(&message, used);
        let stops = !self.keeps(Rule::Timer);
        match message {
            Message::Part { block, offset, request, bytes } => {
                let Self { blocks, fetches, piece, .. } = self;
                let placed = super::fetch::place(blocks, fetches, *piece, block, offset, bytes);
                self.on_piece(placed, request, now);
            }
            Message::Answer { to, sum } => match self.away(&to).copied() {
                Some(slot) => {
                    if slot.tries == 0 && slot.refusals == 0 {
                        self.ray_time =
                            super::fetch::smoothed(self.ray_time, now.since(slot.since));
                    }
                    self.add(slot.root, slot.ray.pixel(), sum);
                    self.free_slot(to.slot());
                }
                None => self.note_unasked(),
            },
            Message::Refusal { to } => self.on_refusal(&to, now),
            Message::AtWork { to } => match self.away(&to) {
                // Its time limit begins anew, and is longer: it is never taken away (rule 15).
                Some(slot) => {
                    slot.since = now.ticks();
                    slot.limit = slot.limit.saturating_mul(2).min(LIMIT_MAX);
                    if stops {
                        slot.limit = u32::MAX;
                    }
                }
                None => self.note_unasked(),
            },
            Message::Grant { number, first, count, wait } => {
                self.on_grant(from, number, (first, count), wait, now);
            }
            Message::Accepted { tile } => self.on_accepted(tile),
            Message::Gone => {
                self.on_gone(from, now);
                return Some(used);
            }
            _ => self.note_unasked(),
        }
        self.clear(from);
        Some(used)
    }

    /// Requests are consumed too, each waiting at most for room to answer it (rules 4, 5).
    pub(super) fn requests(&mut self, now: Time, most: u32) {
        for _ in 0..most {
            self.serve(now);
            if self.inbox_at >= self.inbox_len && !self.take_requests() || !self.can_answer() {
                return;
            }
            self.request(now);
        }
    }

    /// Whether there is room for what the next request in the inbox brings: of one for a block a place in the queue of those to be served, else
    /// a reply.
    pub(super) fn can_answer(&self) -> bool {
        let rest = self.inbox.get(self.inbox_at..self.inbox_len).unwrap_or_default();
        match Items::new(rest).next() {
            Some(Message::Fetch { block, offset, .. }) => {
                !self.serves.is_full() || self.is_served(block, offset, self.inbox_from)
            }
            _ => self.outbox.has_room(&self.router, Channel::Reply),
        }
    }

    /// Takes the next packet of requests off the router, so that its link is free.
    fn take_requests(&mut self) -> bool {
        let Some((from, bytes)) = self.router.arrived(Channel::Request) else { return false };
        let len = bytes.len().min(self.inbox.len());
        if let (Some(place), Some(bytes)) = (self.inbox.get_mut(..len), bytes.get(..len)) {
            place.copy_from_slice(bytes);
        }
        (self.inbox_from, self.inbox_at, self.inbox_len) = (from, 0, len);
        self.work.copied = self.work.copied.saturating_add(len as u32);
        self.router.consume(Channel::Request);
        true
    }

    fn request(&mut self, now: Time) {
        let bytes = self.inbox.get(self.inbox_at..self.inbox_len).unwrap_or_default();
        let mut items = Items::new(bytes);
        let message = items.next();
        self.inbox_at = self.inbox_len.saturating_sub(items.rest_len());
        let used = bytes.len().saturating_sub(items.rest_len());
        let Some(message) = message else {
            self.note_damaged();
            return;
        };
        self.work.messages = self.work.messages.saturating_add(1);
        self.counts.received.note(&message, used);
        self.quiet = 0;
        let from = self.inbox_from;
        match message {
            Message::Fetch { block, offset, .. } if self.is_served(block, offset, from) => {}
            Message::Fetch { block, offset, request } => {
                let known = self.blocks.rom.holds(block) && (offset as usize).is_multiple_of(4);
                let serve = Serve { block, offset, to: from.0, request, _zero: 0 };
                // There is room: `requests` looked for it.
                if !known || !self.serves.enqueue(serve) {
                    self.note_unasked();
                }
            }
            Message::Ray(ray) => self.on_ray(&RayMessage::read(ray), now),
            Message::Ask { number, .. } => self.on_ask(from, number, now),
            Message::Idle => self.on_idle(from),
            Message::Tell if from == HOST => self.tell(now),
            _ => self.note_unasked(),
        }
        self.clear(from);
    }
}
