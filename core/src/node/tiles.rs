#[cfg(feature = "bundles")]
use super::Lack;
use super::group::{Asked, sub_master};
use super::rules::Rule;
use super::slots::{Root, RootState};
use super::{Node, ShadowPolicy, Time, World};
use crate::network::{HOST, NodeId};
use crate::protocol::{Item, Message, WIDTH_MAX, pack};
use crate::shade::Sum;

/// Where a node's tiles come from: its requests for work, and its leases if it is a sub-master.
#[derive(Debug)]
pub(super) struct Tiles {
    len: usize,
    pixels: usize,
    /// Answers that it has had: of its sub-master, and of the host.
    answers: [u32; 2],
    /// A request is under way until this moment at the latest.
    asked: Option<Time>,
    tries: u8,
    /// How often a master has answered twice: it was asked again though nothing was lost, so time limits are doubled, as
    /// far as [`Settings::limit`](super::Settings::limit) does.
    late: u8,
    /// How many more requests go straight to the host, as the sub-master did not answer.
    past: u32,
    /// There was nothing to be had: it asks again at this moment.
    dry: Time,
    /// It had nothing else to do when it asked last.
    idle: bool,
    /// When there was nothing, a node that had work.
    busy: u32,
    /// Tiles that it may render or give away.
    leases: [(u32, u32); LEASES],
    /// How many the host gave last.
    had: u32,
    /// For how many it asks: more where it has to wait for answers. (Boards ask for one at a time: it would take flash.)
    #[cfg(feature = "bundles")]
    wanted: u8,
    /// It has waited for the last answer with nothing else to do.
    #[cfg(feature = "bundles")]
    waited: bool,
}

/// Runs of tiles that a node can hold.
const LEASES: usize = 4;
/// Requests that go past a sub-master which lets two wait: one that has died is waited for so much more rarely.
const PAST: u32 = 16;
/// For how many tiles a node asks at once, at most. A master gives fewer, and one at last, as they become few.
#[cfg(feature = "bundles")]
const WANTED_MAX: u8 = 8;
/// For how many tiles a sub-master asks at once, for each node of its group.
const LEASE_PER_NODE: u32 = 2;

impl Tiles {
    pub(super) const fn new(len: usize, pixels: usize) -> Self {
        Self {
            len,
            pixels,
            answers: [0; 2],
            asked: None,
            tries: 0,
            late: 0,
            past: 0,
            dry: Time(0),
            idle: false,
            busy: u32::MAX,
            leases: [(0, 0); LEASES],
            had: 0,
            #[cfg(feature = "bundles")]
            wanted: 1,
            #[cfg(feature = "bundles")]
            waited: false,
        }
    }

    /// Tiles that can be rendered at once: the first roots.
    pub(super) const fn len(&self) -> usize {
        self.len
    }

    /// Where the sum of a pixel lies; `None` for the root of a visit.
    pub(super) const fn sum_of(&self, root: usize, pixel: usize) -> Option<usize> {
        if root >= self.len || pixel >= self.pixels {
            return None;
        }
        Some(root.saturating_mul(self.pixels).saturating_add(pixel))
    }

    /// The tile that camera rays come from next: the one that was given first.
    pub(super) fn opening(&self, roots: &[Root]) -> Option<u16> {
        let tiles = roots.iter().take(self.len).enumerate();
        let opening = tiles.filter(|(_, root)| root.state() == RootState::Opening);
        opening.min_by_key(|(_, root)| root.deadline).map(|(at, _)| at as u16)
    }

    /// Until when it waits for tiles.
    pub(super) fn until(&self, now: Time) -> Time {
        let until = self.asked.unwrap_or(self.dry);
        // A moment that has passed without a new request: there is none to be made.
        if until > now { until } else { Time::NEVER }
    }

    /// How many answers it has had of a master. They number its requests: one has one answer, however often it is asked and answered.
    const fn answers_of(&mut self, master: NodeId) -> &mut u32 {
        let [sub_master, host] = &mut self.answers;
        if master.0 == HOST.0 { host } else { sub_master }
    }

    fn next_leased(&self) -> Option<u32> {
        self.leases.iter().find(|(_, count)| *count > 0).map(|(first, _)| *first)
    }

    fn take_leased(&mut self) -> Option<u32> {
        let (first, count) = self.leases.iter_mut().find(|(_, count)| *count > 0)?;
        let tile = *first;
        *first = first.wrapping_add(1);
        *count = count.saturating_sub(1);
        Some(tile)
    }

    /// All of it, with times as a checker sees them: passed, or not.
    #[cfg(test)]
    pub(super) fn snapshot(
        &mut self,
        s: &mut crate::tests::snapshot::Snapshot,
        now: Time,
        later: Time,
    ) {
        self.asked = self.asked.map(|_| later);
        self.dry = if self.dry > now { later } else { Time(0) };
        let mut asked = self.asked.is_some();
        s.bool(&mut asked);
        self.asked = asked.then_some(later);
        s.pod(&mut self.dry.0);
        s.pod(&mut self.busy);
        s.bool(&mut self.idle);
        s.all(&mut self.answers);
        s.pod(&mut self.tries);
        // Of time limits only that they run counts.
        self.late = 0;
        s.pod(&mut self.past);
        for (first, count) in &mut self.leases {
            *first = if *count == 0 { 0 } else { *first };
            s.pod(first);
            s.pod(count);
        }
        s.pod(&mut self.had);
        #[cfg(feature = "bundles")]
        {
            s.pod(&mut self.wanted);
            s.bool(&mut self.waited);
        }
    }

    /// Whether a time limit runs: of its request, of its wait for new tiles.
    #[cfg(test)]
    pub(super) fn waits(&self, now: Time) -> (bool, bool) {
        (self.asked.is_some(), self.dry > now)
    }

    /// Makes one pass.
    #[cfg(test)]
    pub(super) fn expire(&mut self, asked: bool, now: Time) {
        match asked {
            true => self.asked = Some(now),
            false => self.dry = now,
        }
    }

    /// It waits for something.
    #[cfg(feature = "bundles")]
    pub(super) fn note_wait(&mut self, lack: Lack) {
        self.waited |= lack == Lack::Master;
    }

    /// An answer has come: where it was waited for it asks for more the next time, else for fewer.
    #[cfg(feature = "bundles")]
    fn adapt_wanted(&mut self) {
        let waited = core::mem::take(&mut self.waited);
        let next = if waited { self.wanted.saturating_mul(2) } else { self.wanted / 2 };
        self.wanted = next.clamp(1, WANTED_MAX);
    }

    /// Whether a master has still to answer: what it was asked for, or that it has the sums of a tile, whose place the next one takes.
    pub(super) fn await_master(&self) -> bool {
        self.asked.is_some() || self.leased() > 0
    }

    fn leased(&self) -> u32 {
        self.leases.iter().fold(0, |sum, (_, count)| sum.saturating_add(*count))
    }
}

impl<W: World> Node<'_, W> {
    /// Asks a master for tiles when the camera rays of all that it has are under way, and there is room for another, or will be as soon as the sums of one are
    /// accepted: it comes with the answer to them.
    pub(super) fn ask_for_tiles(&mut self, now: Time) {
        let wanted = if self.is_sub_master() {
            let most = u32::from(self.settings.group).saturating_mul(LEASE_PER_NODE);
            let room = self.tiles.leases.iter().any(|(_, count)| *count == 0);
            // Half of what came last is given away: more than its share would lie here while others have nothing to do.
            if room && self.tiles.leased() <= self.tiles.had / 2 { most } else { 0 }
        } else {
            let roots = self.roots.get(..self.tiles.len).unwrap_or_default();
            let ends = |root: &Root| {
                matches!(root.state(), RootState::Free | RootState::Sending | RootState::Sent)
            };
            let opening = self.tiles.opening(self.roots).is_some();
            let wants = !opening && self.tiles.leased() == 0 && roots.iter().any(ends);
            #[cfg(feature = "bundles")]
            let most = self.tiles.wanted.into();
            #[cfg(not(feature = "bundles"))]
            let most = 1;
            if wants { most } else { 0 }
        };
        // Who has come to the end of all its work asks once more: the master may know who has some left.
        let done = self.is_idle() && self.settings.shadow != ShadowPolicy::Keep;
        let dry = now < self.tiles.dry && (!done || self.tiles.idle);
        self.tiles.idle &= done;
        let waits = self.tiles.asked.is_some_and(|until| now < until) || dry;
        if wanted == 0 || waits {
            return;
        }
        if self.tiles.asked.is_some() {
            self.tiles.tries = self.tiles.tries.saturating_add(1);
        }
        // A master that does not answer is left out.
        if self.tiles.tries > 1 {
            self.tiles.past = self.tiles.past.max(PAST);
        }
        let to = if self.tiles.past > 0 { HOST } else { self.master() };
        let ask = Message::Ask { number: *self.tiles.answers_of(to), count: wanted };
        if self.push(to, &ask, now) {
            let wait = self.tiles_limit(self.tiles.tries);
            self.tiles.asked = Some(now.after(wait));
            // The answer says anew how long there is nothing; if none comes, it asks again.
            self.tiles.dry = Time(0);
            self.tiles.idle = done;
        }
    }

    /// The time limit of what a master was told or asked so often in vain.
    fn tiles_limit(&self, tries: u8) -> Time {
        self.settings.limit(0, Time(0), tries.saturating_add(self.tiles.late).into())
    }

    /// A master has answered for the second time. (Links drop what they carry twice.)
    fn note_late_answer(&mut self) {
        self.tiles.late = self.tiles.late.saturating_add(1);
        self.note_unasked();
    }

    fn is_sub_master(&self) -> bool {
        sub_master(self.here, self.settings.group) == Some(self.here)
    }

    /// Whom this node asks for tiles.
    fn master(&self) -> NodeId {
        let first = sub_master(self.here, self.settings.group);
        first.filter(|&first| first != self.here).unwrap_or(HOST)
    }

    fn free_tile(&self) -> Option<usize> {
        let tiles = self.roots.get(..self.tiles.len).unwrap_or_default();
        tiles.iter().position(|root| root.state() == RootState::Free)
    }

    /// Begins a tile that this node may render: whether there was one.
    pub(super) fn begin_leased(&mut self, now: Time) -> bool {
        if self.tiles.opening(self.roots).is_some() {
            return false;
        }
        let Some(at) = self.free_tile() else { return false };
        let Some(tile) = self.tiles.take_leased() else { return false };
        let pixels = self.world.tile_pixels(tile);
        if pixels == 0 || pixels > self.tiles.pixels {
            return false;
        }
        if let Some(root) = self.roots.get_mut(at) {
            root.set_state(RootState::Opening);
            root.tile = tile;
            root.deadline = now.0;
        }
        let begin = at.saturating_mul(self.tiles.pixels);
        let sums = self.sums.get_mut(begin..).and_then(|sums| sums.get_mut(..pixels));
        sums.unwrap_or_default().fill(Sum::ZERO);
        let roots = self.roots.get(..self.tiles.len).unwrap_or_default();
        let held = roots.iter().filter(|root| root.state() != RootState::Free).count() as u32;
        self.counts.tiles_peak = self.counts.tiles_peak.max(held);
        true
    }

    pub(super) fn on_grant(
        &mut self,
        from: NodeId,
        number: u32,
        (first, count): (u32, u32),
        wait: u32,
        now: Time,
    ) {
        // One that comes late is an answer too, after that of the host in its sub-master's place: its tiles are nobody else's.
        let master = from == HOST || from == self.master();
        let answers = self.tiles.answers_of(from);
        if !master || *answers != number {
            self.note_late_answer();
            return;
        }
        *answers = number.wrapping_add(1);
        self.tiles.asked = None;
        self.tiles.tries = 0;
        self.tiles.past = if from == HOST { self.tiles.past.saturating_sub(1) } else { 0 };
        self.tiles.had = count;
        #[cfg(feature = "bundles")]
        self.tiles.adapt_wanted();
        if count == 0 {
            self.tiles.dry = now.after(Time(u64::from(wait).saturating_mul(1000)));
            self.tiles.busy = first;
            self.offer_help(number, first, now);
        } else {
            self.lease(first, count);
        }
        self.begin_leased(now);
    }

    /// A node is dead: who waits for it as its sub-master asks the host, from now on.
    pub(super) fn on_master_gone(&mut self, node: NodeId, now: Time) {
        if node == self.master() {
            self.tiles.past = u32::MAX;
            self.tiles.asked = self.tiles.asked.map(|_| now);
        }
    }

    /// Keeps a run of tiles that it may render or give away.
    fn lease(&mut self, first: u32, count: u32) {
        if let Some(lease) = self.tiles.leases.iter_mut().find(|(_, count)| *count == 0) {
            *lease = (first, count);
        }
    }

    /// A node of the group asks its sub-master. Where that has asked for tiles itself, the answer waits for the host's: whoever were told to come
    /// back would find the tiles gone, or let them lie.
    pub(super) fn on_ask(&mut self, from: NodeId, number: u32, now: Time) {
        if !self.keeps(Rule::OneAnswer) {
            self.group.forget(from);
        }
        match self.group.on_ask(from, number) {
            Asked::Waits => self.answer_waiting(now),
            Asked::Answered(tile) => {
                self.grant(from, number, tile, now);
            }
        }
    }

    /// Gives tiles to those that have waited for them, as far as there is room.
    pub(super) fn answer_waiting(&mut self, now: Time) {
        while let Some(tile) = self.tiles.next_leased() {
            let Some((node, number)) = self.group.first_waiting() else { return };
            if !self.grant(node, number, Some(tile), now) {
                return;
            }
            self.group.answer(node, tile);
            let _ = self.tiles.take_leased();
        }
    }

    /// Gives a node of the group a tile, or says that there is none: `false` if there is no room to say so.
    fn grant(&mut self, to: NodeId, number: u32, tile: Option<u32>, now: Time) -> bool {
        let Some(first) = tile else {
            // Until the host again has tiles. Nobody knows when it answers: that long, whoever asks here too often keeps others from it.
            let patience = self.settings.patience.0;
            let dry = self.tiles.dry.0.saturating_sub(now.0);
            let wait = if self.tiles.asked.is_some() { patience } else { dry.min(patience) };
            let wait = (wait / 1000).max(10) as u32;
            // Each name goes to one node: a group that offers its help to the same one keeps it from its work.
            let first = core::mem::replace(&mut self.tiles.busy, u32::MAX);
            return self.push(to, &Message::Grant { number, first, count: 0, wait }, now);
        };
        self.push(to, &Message::Grant { number, first, count: 1, wait: 0 }, now)
    }

    pub(super) fn on_accepted(&mut self, tile: u32) {
        let tiles = self.roots.iter().take(self.tiles.len);
        let sent = |root: &Root| matches!(root.state(), RootState::Sending | RootState::Sent);
        let at = tiles.enumerate().find(|(_, root)| sent(root) && root.tile == tile);
        match at.map(|(at, _)| at) {
            Some(at) => {
                self.counts.tiles = self.counts.tiles.saturating_add(1);
                self.free_root(at);
            }
            None => self.note_late_answer(),
        }
    }

    /// Sends the sums of finished tiles to the host, a message at a time; they are kept until it has acknowledged them.
    pub(super) fn send_tiles(&mut self, now: Time) {
        for at in 0..self.tiles.len {
            let Some(&root) = self.roots.get(at) else { break };
            if root.state() != RootState::Sending {
                continue;
            }
            let pixels = self.world.tile_pixels(root.tile);
            let width = self.packed(at, pixels);
            let bytes = usize::from(width).saturating_mul(3);
            let room = self.inbox.len().saturating_sub(Item::PART_BYTES);
            let most = room.checked_div(bytes).unwrap_or(0).max(1);
            let mut sent = root.sent as usize;
            while sent < pixels {
                let count = pixels.saturating_sub(sent).min(most);
                let Self { outbox, router, counts, work, sums, .. } = self;
                let sums = sums.get(at.saturating_mul(self.tiles.pixels)..).unwrap_or_default();
                let sums = bytemuck::cast_slice(sums).get(sent.saturating_mul(bytes)..);
                let sums = sums.and_then(|sums| sums.get(..count.saturating_mul(bytes)));
                let sums = sums.unwrap_or_default();
                let message = Message::Pixels { tile: root.tile, first: sent as u32, width, sums };
                if !outbox.push(router, HOST, &message, now, counts, work) {
                    break;
                }
                sent = sent.saturating_add(count);
            }
            let wait = self.tiles_limit(root.tries.saturating_add(2));
            let Some(root) = self.roots.get_mut(at) else { break };
            root.sent = sent as u32;
            if sent < pixels {
                break;
            }
            root.set_state(RootState::Sent);
            let deadline = now.after(wait);
            root.deadline = deadline.0;
            self.note_deadline(deadline);
        }
    }

    /// Packs the sums of a finished tile, if they are not: how many bytes a channel takes. (Boards leave them as they are: it would take flash.)
    fn packed(&mut self, at: usize, pixels: usize) -> u8 {
        if !cfg!(feature = "bundles") {
            return WIDTH_MAX;
        }
        let Some(root) = self.roots.get_mut(at) else { return WIDTH_MAX };
        if root.width == 0 {
            let sums = self.sums.get_mut(at.saturating_mul(self.tiles.pixels)..);
            let sums = sums.and_then(|sums| sums.get_mut(..pixels)).unwrap_or_default();
            root.width = pack(sums);
            self.work.copied = self.work.copied.saturating_add(size_of_val(sums) as u32);
        }
        root.width
    }

    /// Time limits of tiles that the host has not acknowledged.
    pub(super) fn tile_deadlines(&mut self, now: Time) {
        for at in 0..self.tiles.len {
            let Some(root) = self.roots.get_mut(at) else { break };
            if root.state() != RootState::Sent {
                continue;
            }
            let deadline = Time(root.deadline);
            if now >= deadline {
                root.set_state(RootState::Sending);
                root.sent = 0;
                root.tries = root.tries.saturating_add(1);
                self.counts.tiles_again = self.counts.tiles_again.saturating_add(1);
            } else {
                self.note_deadline(deadline);
            }
        }
    }
}
