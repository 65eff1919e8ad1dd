use super::actor::SUSPECTS;
use super::help::put_first;
use super::rom::Blocks;
use super::rules::Rule;
use super::slots::{FetchSlot, RaySlot, Serve, Stage};
use super::tell::tell;
use super::{Node, Settings, Time, World};
use crate::network::{NodeId, Router};
use crate::protocol::{Item, Message, write};
use crate::store::{Claim, Residency};
use bytemuck::Zeroable;

/// Requests without an answer, for each holder, after which a block counts as lost where nobody tells of deaths.
const FETCH_TRIES: u16 = 16;
/// Holders beyond this many hops have two requests more for each hop: where each link loses one packet in 100, the other side of a ring of 256 nodes answers
/// one request in thirteen, and none of 256 with a chance of 2e-9.
const NEAR: u16 = 8;
/// The first time limit of a fetch is halved at most this often.
const HASTE: u8 = 6;

impl<W: World> Node<'_, W> {
    /// A ray waits for a block.
    pub(super) fn await_block(&mut self, block: u32, now: Time) {
        self.blocks.cache.note_miss();
        self.want(block, now);
    }

    /// Sees to it that a block comes: reserves its frame, and asks for it. A request joins one that is under way.
    ///
    /// The frame is taken before the request leaves, and kept until the block was used once (rule 11); where none can be had
    /// the ray waits without holding anything (rule 13), and is asked for again when one may be free.
    pub(super) fn want(&mut self, block: u32, now: Time) {
        match self.blocks.cache.residency(block) {
            Residency::OnItsWay => return,
            Residency::Cached => {
                self.wake(block);
                return;
            }
            Residency::Remote => {}
        }
        let free = self.free_fetch();
        let first = self.keeps(Rule::FrameFirst);
        if !first && self.fetches.iter().any(|fetch| fetch.is_for(block)) {
            return;
        }
        let cache = &mut self.blocks.cache;
        let Some(at) = free.filter(|_| !first || cache.reserve(block, Claim::Demand).is_ok())
        else {
            self.starved = true;
            self.counts.stalls = self.counts.stalls.saturating_add(1);
            return;
        };
        self.begin_fetch(at, block, now);
    }

    /// Asks for a block that may be of use: only while another request and another frame are left to what a ray needs (rule 11).
    pub(super) fn prefetch(&mut self, block: u32, now: Time) {
        if self.fetches.len().saturating_sub(usize::from(self.fetching)) < 2 {
            return;
        }
        let Some(at) = self.free_fetch() else { return };
        if self.blocks.rom.holds(block)
            || self.blocks.cache.reserve(block, Claim::Prefetch) != Ok(true)
        {
            return;
        }
        self.begin_fetch(at, block, now);
    }

    /// Whether another block can be asked for.
    pub(super) fn can_fetch(&self) -> bool {
        usize::from(self.fetching) < self.fetches.len()
    }

    fn free_fetch(&self) -> Option<usize> {
        let free = || self.fetches.iter().position(FetchSlot::is_free);
        if self.can_fetch() { free() } else { None }
    }

    fn begin_fetch(&mut self, at: usize, block: u32, now: Time) {
        if let Some(fetch) = self.fetches.get_mut(at) {
            self.fetching = self.fetching.saturating_add(1);
            let begun = now.ticks();
            *fetch =
                FetchSlot { block, begun, state: FetchSlot::TO_BE_SENT, ..FetchSlot::zeroed() };
            self.unsent = true;
        }
    }

    /// Sends the requests for blocks that have not left.
    pub(super) fn send_fetches(&mut self, now: Time) {
        if !core::mem::take(&mut self.unsent) {
            return;
        }
        for at in 0..self.fetches.len() {
            let Some(&(mut fetch)) = self.fetches.get(at) else { break };
            if fetch.state != FetchSlot::TO_BE_SENT {
                continue;
            }
            let offset = fetch.first_missing().saturating_mul(self.piece) as u32;
            let block = fetch.block;
            let asked = (fetch.tries > 0).then(|| fetch.asked());
            let Some(to) = self.owner_for(block, asked, fetch.gone) else {
                tell!(error, "node {}: all who had block {} are gone", self.here.0, block);
                self.lost = Some(block);
                self.unsent = true;
                continue;
            };
            if !self.push(to, &Message::Fetch { block, offset, request: fetch.request }, now) {
                self.unsent = true;
                break;
            }
            fetch.asked = to.0;
            fetch.state = FetchSlot::SENT;
            if let Some(place) = self.fetches.get_mut(at) {
                *place = fetch;
            }
            self.put_off(at, now);
        }
    }

    /// Gives a request that was sent its time limit from now on.
    fn put_off(&mut self, at: usize, now: Time) {
        let Some(tries) = self.fetches.get(at).map(|fetch| fetch.tries) else { return };
        let deadline = now.after(self.fetch_limit(tries));
        if let Some(fetch) = self.fetches.get_mut(at) {
            fetch.deadline = deadline.0;
        }
        self.note_deadline(deadline);
    }

    /// All time limits: those that have passed act, the next one is noted.
    pub(super) fn deadlines(&mut self, now: Time) {
        self.next_deadline = Time::NEVER;
        self.ray_deadlines(now);
        self.tile_deadlines(now);
        for at in 0..self.fetches.len() {
            let Some(&(mut fetch)) = self.fetches.get(at) else { break };
            if fetch.state != FetchSlot::SENT {
                continue;
            }
            if now.0 < fetch.deadline {
                self.note_deadline(Time(fetch.deadline));
                continue;
            }
            if fetch.gone == 0 && self.outbox.asks_for(fetch.block, fetch.asked()) {
                // Nobody has let it wait: it has not left.
                self.put_off(at, now);
                continue;
            }
            tell!(debug, "node {}: block {} is asked for again", self.here.0, fetch.block);
            self.suspect(fetch.asked());
            self.counts.fetches_again = self.counts.fetches_again.saturating_add(1);
            fetch.tries = fetch.tries.saturating_add(1);
            fetch.request = fetch.request.wrapping_add(1);
            fetch.begun = now.ticks();
            fetch.state = FetchSlot::TO_BE_SENT;
            self.unsent = true;
            let all_gone = self.owner_for(fetch.block, None, fetch.gone).is_none();
            let in_vain = fetch.tries >= self.most_tries(fetch.block);
            if all_gone || (in_vain && !self.is_told_of_deaths()) {
                // It goes on asking: who was thought dead may come back.
                tell!(error, "node {}: nobody answers for block {}", self.here.0, fetch.block);
                self.lost = Some(fetch.block);
                fetch.gone = 0;
            }
            if let Some(place) = self.fetches.get_mut(at) {
                *place = fetch;
            }
        }
    }

    /// How long an answer is awaited after so many requests in vain: all holders are asked in turn, each time for twice as long.
    fn fetch_limit(&self, tries: u16) -> Time {
        let round = tries.checked_div(self.settings.placement.copies()).unwrap_or(0);
        self.settings.limit(self.haste, self.fetch_time, round)
    }

    /// Requests for a block, to all its holders, after which it counts as lost where nobody tells of deaths: the shorter their time limits
    /// are, the more of them.
    fn most_tries(&self, block: u32) -> u16 {
        let Settings { placement, patience, .. } = &self.settings;
        let holders = (0..placement.copies()).filter_map(|copy| placement.owner(block, copy));
        let hops = holders.map(|holder| self.router.mesh().distance(self.here, holder)).max();
        let far = hops.unwrap_or(0).saturating_sub(NEAR).saturating_mul(2);
        let most = placement.copies().saturating_mul(FETCH_TRIES.saturating_add(far));
        let times = patience.0.checked_div(self.fetch_limit(0).0).unwrap_or(1).max(1);
        most.saturating_mul(times.min(u16::MAX.into()) as u16)
    }

    /// Whether it hears of the deaths of all holders of a block; there are bits for so many.
    fn is_told_of_deaths(&self) -> bool {
        let all_known = u32::from(self.settings.placement.copies()) <= u16::BITS;
        self.settings.deaths_told && all_known
    }

    /// A piece of a block has gone to its frame, or was dropped.
    pub(super) fn on_piece(&mut self, placed: Option<Piece>, request: u8, now: Time) {
        let Some(Piece { at, bytes, complete }) = placed else {
            self.note_unasked();
            return;
        };
        self.work.copied = self.work.copied.saturating_add(bytes as u32);
        let Some(&(mut fetch)) = self.fetches.get(at) else { return };
        if fetch.tries > 0 {
            // The answer to the last request: those before it were lost. To an earlier one: it was late, and asked for again too soon.
            let is_lost = request == fetch.request;
            self.haste = if is_lost { self.haste.saturating_add(1).min(HASTE) } else { 0 };
        }
        (fetch.tries, fetch.gone) = (0, 0);
        let deadline = now.after(self.fetch_limit(0));
        fetch.deadline = deadline.0;
        // It may be sooner than that before: this one counts anew.
        self.note_deadline(deadline);
        if complete {
            if request == fetch.request {
                self.fetch_time = smoothed(self.fetch_time, now.since(fetch.begun));
            }
            fetch.state = FetchSlot::COMPLETE;
            self.complete = true;
        }
        if let Some(place) = self.fetches.get_mut(at) {
            *place = fetch;
        }
    }

    /// Checks one of the blocks that are complete, and lets those go on that wait for it: whether there was one.
    ///
    /// Its link buffers are free by then: what takes as long as some rays keeps no packet waiting.
    pub(super) fn check_block(&mut self, now: Time) -> bool {
        if !self.complete {
            return false;
        }
        let Some(fetch) = self.fetches.iter_mut().find(|fetch| fetch.is_complete()) else {
            self.complete = false;
            return false;
        };
        fetch.state = FetchSlot::FREE;
        self.fetching = self.fetching.saturating_sub(1);
        let block = fetch.block;
        let whole = self.blocks.cache.block_bytes() as u32;
        self.work.checked = self.work.checked.saturating_add(whole);
        let Self { world, blocks, .. } = self;
        let sound = blocks.cache.incoming(block).is_some_and(|bytes| world.check(block, bytes));
        if sound {
            self.blocks.cache.arrived(block);
            self.wake(block);
        } else {
            tell!(warn, "node {}: block {} came damaged", self.here.0, block);
            self.counts.blocks_refused = self.counts.blocks_refused.saturating_add(1);
            self.blocks.cache.discard(block);
            self.want(block, now);
        }
        true
    }

    /// Sends the blocks that other nodes have asked for, as far as there is room.
    ///
    /// Requests wait here for room in the reply channel alone (rule 4), in a queue of their own, so that they do not
    /// stand in the buffers of links before others.
    pub(super) fn serve(&mut self, now: Time) {
        while let Some(&Serve { block, offset, to, request, .. }) = self.serves.front() {
            let begin = (offset as usize).saturating_add(self.served);
            let bytes = self.blocks.rom.block(block).and_then(|bytes| bytes.get(begin..));
            let rest = bytes.unwrap_or_default();
            if rest.is_empty() {
                self.serves.dequeue();
                self.served = 0;
                continue;
            }
            let piece = rest.get(..self.piece).unwrap_or(rest);
            let offset = begin as u32;
            let message = Message::Part { block, offset, request, bytes: piece };
            if !self.push(NodeId(to), &message, now) {
                return;
            }
            self.served = self.served.saturating_add(piece.len());
        }
    }

    /// Whether a node is being sent a block, from this offset or one before: a request that was made again brings nothing new. (If
    /// a piece is lost meanwhile, it asks once more.)
    pub(super) fn is_served(&self, block: u32, offset: u32, to: NodeId) -> bool {
        let same = |serve: &Serve| serve.block == block && serve.to == to.0;
        self.serves.iter().any(|serve| same(serve) && serve.offset <= offset)
    }

    /// The node to ask for a block, or to send a ray to: the nearest holder of those that answer; where `asked` was asked in vain, the next one
    /// in turn, so that none is left out however many are suspected. Those that are `gone` are not asked.
    pub(super) fn owner_for(&self, block: u32, asked: Option<NodeId>, gone: u16) -> Option<NodeId> {
        let placement = &self.settings.placement;
        let copies = placement.copies();
        let holder = |copy| {
            let owner = placement.owner(block, copy).filter(|&owner| owner != self.here);
            owner.filter(|_| gone & copy_bit(copy) == 0)
        };
        let after = asked.and_then(|asked| self.copy_of(block, asked));
        if let Some(after) = after {
            let behind = after.saturating_add(1);
            return (behind..copies).chain(0..behind).find_map(holder);
        }
        (0..copies).filter_map(holder).min_by_key(|&node| {
            (self.is_suspect(node), self.router.mesh().distance(self.here, node))
        })
    }

    /// Which copy of a block a node holds.
    fn copy_of(&self, block: u32, node: NodeId) -> Option<u16> {
        let placement = &self.settings.placement;
        (0..placement.copies()).find(|&copy| placement.owner(block, copy) == Some(node))
    }

    /// The router of a dead node says so: the time limits of all that was asked of it pass at once.
    pub(super) fn on_gone(&mut self, node: NodeId, now: Time) {
        tell!(warn, "node {}: node {} is gone", self.here.0, node.0);
        for at in 0..self.fetches.len() {
            let Some(&fetch) = self.fetches.get(at) else { break };
            if fetch.state != FetchSlot::SENT || fetch.asked() != node {
                continue;
            }
            let gone = self.copy_of(fetch.block, node).map_or(0, copy_bit);
            if let Some(fetch) = self.fetches.get_mut(at) {
                fetch.deadline = now.0;
                fetch.gone |= gone;
            }
        }
        let sent = |slot: &&mut RaySlot| slot.stage() == Stage::Away && slot.sent_to == node.0;
        self.rays.iter_mut().filter(sent).for_each(|slot| slot.limit = 0);
        self.on_master_gone(node, now);
        self.note_deadline(now);
    }

    /// A node has let a request wait in vain.
    pub(super) fn suspect(&mut self, node: NodeId) {
        if !self.is_suspect(node) {
            tell!(info, "node {}: node {} lets a request wait", self.here.0, node.0);
            put_first(&mut self.suspects, node);
        }
    }

    /// A node has been heard of.
    pub(super) fn clear(&mut self, node: NodeId) {
        for suspect in self.suspects.iter_mut().filter(|suspect| **suspect == node.0) {
            *suspect = u16::MAX;
        }
    }

    fn is_suspect(&self, node: NodeId) -> bool {
        const { assert!(SUSPECTS > 0) };
        self.suspects.contains(&node.0)
    }
}

/// Sends a message that is a header alone, at once or not at all: whether there was room. For who has no node: the host, and the router of a dead
/// node, which tells who asks it that it is [gone](Message::Gone) (rule 16).
pub fn signal(router: &mut Router<'_>, to: NodeId, message: &Message<'_>) -> bool {
    let mut payload = [0; Item::BYTES];
    let (channel, priority) = (message.channel(), message.priority());
    write(&mut payload, 0, message).is_some()
        && router.inject(to, channel, priority, &payload).is_ok()
}

/// The bit of a copy; none of those beyond the first sixteen.
fn copy_bit(copy: u16) -> u16 {
    1_u16.checked_shl(copy.into()).unwrap_or(0)
}

/// What became of a piece of a block.
#[derive(Debug, Clone, Copy)]
pub(super) struct Piece {
    at: usize,
    bytes: usize,
    /// It was the last one.
    complete: bool,
}

/// Copies a piece of a block straight to its frame. `None` for a late or doubled one (rules 3, 14), or one of a wrong size.
pub(super) fn place(
    blocks: &mut Blocks<'_>,
    fetches: &mut [FetchSlot],
    piece: usize,
    block: u32,
    offset: u32,
    bytes: &[u8],
) -> Option<Piece> {
    let whole = blocks.cache.block_bytes();
    let begin = offset as usize;
    let end = begin.checked_add(bytes.len())?;
    let sized = bytes.len() == piece && end <= whole || end == whole && bytes.len() < piece;
    if begin.checked_rem(piece)? != 0 || !sized {
        return None;
    }
    let at = fetches.iter().position(|fetch| fetch.is_for(block))?;
    let fetch = fetches.get_mut(at)?;
    if !fetch.note(begin.checked_div(piece)?) {
        return None;
    }
    blocks.cache.incoming(block)?.get_mut(begin..end)?.copy_from_slice(bytes);
    let complete = fetch.first_missing() >= whole.div_ceil(piece);
    Some(Piece { at, bytes: bytes.len(), complete })
}

/// A running mean over about eight values.
#[cfg_attr(not(feature = "bundles"), inline(never))]
pub(super) const fn smoothed(mean: Time, value: Time) -> Time {
    if mean.0 == 0 { value } else { Time((mean.0.saturating_mul(7).saturating_add(value.0)) / 8) }
}
