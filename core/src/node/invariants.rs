//! What holds of a node between two steps, whatever it has been sent, lost or refused. Checked after each step where debug checks are on.

use super::rules::Rule;
use super::slots::{FetchSlot, RootState, Stage};
use super::{Node, World};
use crate::path::mix;
use crate::shade::Task;
use crate::store::Residency;

impl<W: World> Node<'_, W> {
    /// Looks at all of it.
    pub(super) fn check_invariants(&self) {
        self.check_slots();
        if self.keeps(Rule::Reserve) && self.keeps(Rule::ReserveByDepth) {
            self.check_reserve();
        }
        self.check_roots();
        self.check_fetches();
        #[cfg(test)]
        self.router.check_heads();
        let inbox = [self.inbox_at, self.inbox_len, self.inbox.len()];
        debug_assert!(
            inbox.is_sorted(),
            "a request packet is dealt with as far as it goes: {inbox:?}"
        );
    }

    /// The numbers of the ray slots in a stage.
    fn slots_in(&self, is_in: impl Fn(Stage) -> bool) -> impl Iterator<Item = u16> {
        (0..)
            .zip(&*self.rays)
            .filter(move |(_, slot)| is_in(slot.stage()))
            .map(|(number, _)| number)
    }

    /// A slot is free or in use, and in the queue if it can go on, once.
    fn check_slots(&self) {
        let free = self.free.iter().take(self.free_len).copied();
        debug_assert_eq!(
            bag(free),
            bag(self.slots_in(|stage| stage == Stage::Free)),
            "free slots are listed once"
        );
        let can_go_on =
            |stage| matches!(stage, Stage::Trace | Stage::Send | Stage::Shade | Stage::Split);
        debug_assert_eq!(
            bag(self.ready.iter().copied()),
            bag(self.slots_in(can_go_on)),
            "slots that can go on are queued once"
        );
        let blocked = self.slots_in(|stage| stage == Stage::Blocked).count();
        debug_assert_eq!(blocked, usize::from(self.blocked), "slots that wait are counted");
    }

    /// Rays that may split `k` times or more leave `k` slots free (rule 7).
    fn check_reserve(&self) {
        let most = self.world.splits(0);
        for k in 1..=most {
            let may_split = |slot: &&super::slots::RaySlot| {
                slot.stage() != Stage::Free
                    && matches!(slot.ray.task(), Task::Path | Task::Hit)
                    && self.world.splits(slot.ray.depth()) >= k
            };
            let held = self.rays.iter().filter(may_split).count();
            let left = self.rays.len().checked_sub(held);
            debug_assert!(
                left >= Some(k),
                "{held} of {} slots may split {k} times",
                self.rays.len()
            );
        }
    }

    /// What is open is what there is, and belongs to something.
    fn check_roots(&self) {
        let in_use = self.rays.iter().filter(|slot| slot.stage() != Stage::Free);
        let parked = self.shadows.iter().rev().take(self.parked);
        let shadows = self.shadows.iter().take(self.fresh).chain(parked);
        let roots = in_use.map(|slot| slot.root).chain(shadows.map(|shadow| shadow.root));
        for (root, at) in self.roots.iter().zip(0..) {
            let waits = matches!(
                root.state(),
                RootState::Opening | RootState::Rendering | RootState::Visit
            );
            debug_assert!(
                waits || root.open == 0,
                "nothing of root {at} is open once it has ended"
            );
            debug_assert!(
                root.state() != RootState::Visit || root.open > 0,
                "visit {at} has ended"
            );
            let is_behind_tiles = root.state() != RootState::Free && at >= self.tiles.len();
            debug_assert_eq!(root.is_visit(), is_behind_tiles, "visits come behind tiles");
        }
        let open = (0..).zip(&*self.roots);
        let open = open.flat_map(|(at, root)| core::iter::repeat_n(at, root.open as usize));
        debug_assert_eq!(bag(open), bag(roots), "rays that have not ended are open");
        let visits = self.roots.iter().filter(|root| root.is_visit()).count();
        debug_assert_eq!(visits, usize::from(self.visitors), "visits are counted");
        let room = self.shadows.len().checked_sub(self.parked);
        debug_assert!(room >= Some(self.fresh), "shadow rays have a place each");
        debug_assert!(self.looked_at <= self.fresh, "those that have been looked at are there");
        debug_assert!(self.going <= self.looked_at, "those that go on have been looked at");
        let parked = self.onward.iter().zip(&*self.awaited).rev().take(self.parked);
        let mut differ = parked.filter(|(onward, block)| onward.trail.block() != **block);
        debug_assert!(differ.next().is_none(), "the block that a shadow ray waits for is known");
    }

    /// A block that was asked for has its frame (rule 11), and one request.
    fn check_fetches(&self) {
        let asked = self.fetches.iter().filter(|fetch| !fetch.is_free());
        let count = asked.clone().count();
        debug_assert_eq!(count, usize::from(self.fetching), "fetches are counted");
        for (before, fetch) in asked.clone().enumerate() {
            let residency = self.blocks.cache.residency(fetch.block);
            debug_assert!(
                residency == Residency::OnItsWay || !self.keeps(Rule::FrameFirst),
                "rule 11"
            );
            let same = asked.clone().take(before).any(|other| other.block == fetch.block);
            debug_assert!(!same, "a block is asked for once");
        }
        for (state, noted) in
            [(FetchSlot::TO_BE_SENT, self.unsent), (FetchSlot::COMPLETE, self.complete)]
        {
            let is_noted = noted || self.fetches.iter().all(|fetch| fetch.state != state);
            debug_assert!(is_noted, "a fetch in state {state} is looked for");
        }
        // Whoever waits for a block waits for one that was asked for, or will be.
        let blocked = self.rays.iter().filter(|slot| slot.stage() == Stage::Blocked);
        let parked = self.onward.iter().rev().take(self.parked);
        let parked = parked.map(|onward| onward.trail.block());
        let mut waited = blocked.map(|slot| slot.trail().block()).chain(parked);
        let will_come = |block| asked.clone().any(|fetch| fetch.block == block);
        debug_assert!(self.starved || waited.all(will_come), "a block that is waited for comes");
    }
}

/// One number for numbers in any order, which others have, or the same with one of them twice, once in 2⁶⁴.
fn bag(numbers: impl Iterator<Item = u16>) -> u64 {
    numbers.fold(0, |bag, number| bag.wrapping_add(mix(number.into())))
}
