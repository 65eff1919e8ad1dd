//! The state of a node as a checker sees it: without what only counts, and with times that have passed or have not.

use super::super::rays::REFUSED;
use super::super::slots::{FetchSlot, RaySlot, RootState, Stage};
use super::super::{Counts, Node, TaskOrder, Time, World};
use crate::shade::Task;
use crate::tests::snapshot::Snapshot;
use std::vec::Vec;

/// The time at which all happens.
pub(super) const NOW: Time = Time(1 << 40);
/// Time limits that have not passed.
pub(super) const LATER: Time = Time(1 << 41);

/// A time limit of a node.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum Timer {
    /// Of a ray that is away.
    Ray(u16),
    /// Of one that was refused.
    Refused(u16),
    Fetch(u16),
    /// Of a tile that the host has not acknowledged.
    Tile(u16),
    /// Of its request for tiles.
    Ask,
    /// Of its wait for new ones.
    Dry,
}

impl<W: World> Node<'_, W> {
    /// Numbers the paths by age alone, or not at all where it decides nothing.
    fn rank_paths(&mut self) {
        let has_number = |slot: &&mut RaySlot| !matches!(slot.stage(), Stage::Free | Stage::Away);
        let age = |since: u32| self.begun.wrapping_sub(since);
        let mut ages: Vec<_> =
            self.rays.iter_mut().filter(has_number).map(|s| age(s.since)).collect();
        ages.sort_unstable();
        ages.dedup();
        let made = self.settings.order == TaskOrder::Made;
        for slot in self.rays.iter_mut().filter(has_number) {
            let rank = ages.binary_search(&age(slot.since)).unwrap() as u32;
            slot.since = if made { 0_u32.wrapping_sub(rank) } else { 0 };
        }
        self.begun = 0;
    }

    /// Writes or reads its state; what behaves alike is made alike before.
    pub(super) fn snapshot(&mut self, s: &mut Snapshot) {
        let most = self.settings.refusals.saturating_add(1);
        self.rank_paths();
        for slot in self.rays.iter_mut() {
            if slot.stage() == Stage::Away {
                slot.since = NOW.ticks();
                slot.limit = if slot.limit == u32::MAX { u32::MAX } else { 1 };
                slot.refusals = slot.refusals.min(most);
            } else {
                slot.limit = 0;
                let lights = slot.ray.task() == Task::Lights && slot.stage() == Stage::Send;
                let again = slot.tries > 0 && self.settings.placement.copies() > 1;
                if !lights && !again {
                    slot.sent_to = 0;
                }
            }
            s.pod(slot);
        }
        s.pod(&mut self.begun);
        s.pod(&mut self.blocked);
        s.pod(&mut self.fetching);
        s.len(&mut self.free_len);
        s.all(&mut self.free[..self.free_len]);
        self.ready.snapshot(s);
        s.len(&mut self.fresh);
        s.len(&mut self.parked);
        let (fresh, parked) = (self.fresh, self.shadows.len() - self.parked);
        s.all(&mut self.shadows[..fresh]);
        s.all(&mut self.shadows[parked..]);
        s.all(&mut self.awaited[parked..]);
        s.len(&mut self.looked_at);
        s.len(&mut self.going);
        let going = fresh - self.going;
        s.all(&mut self.onward[going..fresh]);
        s.all(&mut self.onward[parked..]);
        s.bool(&mut self.draining);
        // They decide about time only.
        (self.turned, self.quiet, self.haste) = (false, 0, 0);
        s.bool(&mut self.starved);
        for root in self.roots.iter_mut() {
            root.deadline = match root.state() {
                RootState::Opening => NOW.0,
                RootState::Sent => LATER.0,
                _ => 0,
            };
            s.pod(root);
        }
        self.tiles.snapshot(s, NOW, LATER);
        self.group.snapshot(s);
        for at in (0..self.tiles.len()).filter(|&at| self.roots[at].state() == RootState::Free) {
            let pixels = self.sums.len() / self.tiles.len();
            self.sums[at * pixels..][..pixels].fill(crate::shade::Sum::ZERO);
        }
        s.all(self.sums);
        for fetch in self.fetches.iter_mut() {
            if fetch.is_free() {
                *fetch = bytemuck::Zeroable::zeroed();
            } else {
                if let (false, [0, ..], Some(bytes)) =
                    (s.reads(), fetch.pieces, self.blocks.cache.incoming(fetch.block))
                {
                    bytes.fill(0);
                }
                (fetch.begun, fetch.request) = (NOW.ticks(), 0);
                fetch.deadline = if fetch.state == FetchSlot::SENT { LATER.0 } else { 0 };
            }
            s.pod(fetch);
        }
        self.visitors = self.roots.iter().filter(|root| root.is_visit()).count() as u16;
        (self.unsent, self.complete) = (true, true);
        self.outbox.snapshot(s, NOW);
        if !s.reads() {
            self.inbox.copy_within(self.inbox_at..self.inbox_len, 0);
            (self.inbox_at, self.inbox_len) = (0, self.inbox_len - self.inbox_at);
            if self.inbox_len == 0 {
                self.inbox_from.0 = 0;
            }
        }
        self.inbox_at = 0;
        s.len(&mut self.inbox_len);
        s.bytes(&mut self.inbox[..self.inbox_len]);
        s.pod(&mut self.inbox_from.0);
        self.serves.snapshot(s);
        s.len(&mut self.served);
        if self.settings.placement.copies() == 1 {
            // It changes nothing whom they suspect.
            self.suspects.fill(u16::MAX);
        }
        self.suspects.sort_unstable();
        s.all(&mut self.suspects);
        s.all(&mut self.helpers.nodes);
        s.pod(&mut self.helpers.rays_per_hit);
        let mut lost = self.lost.map_or(0, |block| block + 1);
        s.pod(&mut lost);
        self.lost = lost.checked_sub(1);
        self.blocks.cache.snapshot(s);
        self.router.snapshot(s);
        (self.fetch_time, self.ray_time, self.next_deadline) = (Time(0), Time(0), LATER);
        self.counts = Counts::default();
        self.work = super::super::Work::default();
    }

    /// Its time limits.
    pub(super) fn timers(&mut self) -> Vec<Timer> {
        let mut timers = Vec::new();
        for (slot, at) in self.rays.iter().zip(0..) {
            if slot.stage() != Stage::Away || slot.limit == u32::MAX {
                continue;
            }
            let refused = slot.sent_to == REFUSED;
            timers.push(if refused { Timer::Refused(at) } else { Timer::Ray(at) });
        }
        let sent = self.fetches.iter().zip(0..).filter(|(fetch, _)| fetch.state == FetchSlot::SENT);
        timers.extend(sent.map(|(_, at)| Timer::Fetch(at)));
        let tiles = self.roots.iter().zip(0..).filter(|(root, _)| root.state() == RootState::Sent);
        timers.extend(tiles.map(|(_, at)| Timer::Tile(at)));
        let (asks, dry) = self.tiles.waits(NOW);
        timers.extend(asks.then_some(Timer::Ask));
        timers.extend(dry.then_some(Timer::Dry));
        timers
    }

    /// Makes a time limit pass.
    pub(super) fn expire(&mut self, timer: Timer) {
        match timer {
            Timer::Ray(at) | Timer::Refused(at) => self.rays[usize::from(at)].limit = 0,
            Timer::Fetch(at) => self.fetches[usize::from(at)].deadline = NOW.0,
            Timer::Tile(at) => self.roots[usize::from(at)].deadline = NOW.0,
            Timer::Ask | Timer::Dry => self.tiles.expire(timer == Timer::Ask, NOW),
        }
        self.next_deadline = NOW;
    }

    /// Whether nothing is left in it.
    pub(super) fn is_empty(&self) -> bool {
        self.free_len == self.rays.len()
            && self.ready.is_empty()
            && self.fresh == 0
            && self.parked == 0
            && self.roots.iter().all(|root| root.state() == RootState::Free)
            && self.fetches.iter().all(FetchSlot::is_free)
            && self.outbox.is_empty()
            && self.inbox_at >= self.inbox_len
            && self.serves.is_empty()
            && self.router.is_idle()
    }
}
