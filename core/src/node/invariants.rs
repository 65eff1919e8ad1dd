//! What holds of a node between two steps, whatever it has been sent, lost or refused. Checked after each step where debug checks are on.

use super::fetch::{COMPLETE, TO_BE_SENT};
use super::rules::Rule;
use super::slots::{RootState, Stage};
use super::{Node, World};
use crate::shade::Task;
use crate::store::Place;

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
        self.router.check_counts();
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
            Numbers::of(free),
            Numbers::of(self.slots_in(|stage| stage == Stage::Free)),
            "free slots are listed once"
        );
        let can_go_on =
            |stage| matches!(stage, Stage::Trace | Stage::Send | Stage::Shade | Stage::Split);
        debug_assert_eq!(
            Numbers::of(self.ready.iter().copied()),
            Numbers::of(self.slots_in(can_go_on)),
            "slots that can go on are queued once"
        );
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
        let roots = in_use.map(|slot| slot.root).chain(shadows.map(|slot| slot.root));
        let is_there = |root: u16| {
            self.roots.get(usize::from(root)).is_some_and(|root| root.state() != RootState::Free)
        };
        debug_assert!(roots.clone().all(is_there), "a ray belongs to a tile or a visit");
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
            debug_assert!(!root.is_visit() || at >= self.tiles.len(), "visits come behind tiles");
            // Of all together where there are many.
            if self.roots.len() <= FEW_ROOTS {
                let held = roots.clone().filter(|&root| usize::from(root) == at).count();
                debug_assert_eq!(root.open as usize, held, "rays of root {at} that have not ended");
            }
        }
        let open: u64 = self.roots.iter().map(|root| u64::from(root.open)).sum();
        debug_assert_eq!(open, roots.count() as u64, "rays that have not ended are open");
        let visits = self.roots.iter().filter(|root| root.is_visit()).count();
        debug_assert_eq!(visits, usize::from(self.visitors), "visits are counted");
        let room = self.shadows.len().checked_sub(self.parked);
        debug_assert!(room >= Some(self.fresh), "shadow rays have a place each");
    }

    /// A block that was asked for has its frame (rule 11), and one request.
    fn check_fetches(&self) {
        let asked = self.fetches.iter().filter(|fetch| !fetch.is_free());
        for (before, fetch) in asked.clone().enumerate() {
            let place = self.blocks.cache.place(fetch.block);
            debug_assert!(place == Place::OnItsWay || !self.keeps(Rule::FrameFirst), "rule 11");
            let same = asked.clone().take(before).any(|other| other.block == fetch.block);
            debug_assert!(!same, "a block is asked for once");
        }
        for (state, noted) in [(TO_BE_SENT, self.unsent), (COMPLETE, self.complete)] {
            let is_noted = noted || self.fetches.iter().all(|fetch| fetch.state != state);
            debug_assert!(is_noted, "a fetch in state {state} is looked for");
        }
        // Whoever waits for a block waits for one that was asked for, or will be.
        let blocked = self.rays.iter().filter(|slot| slot.stage() == Stage::Blocked);
        let parked = self.shadows.iter().rev().take(self.parked);
        let mut waited =
            blocked.map(|slot| slot.trail().block()).chain(parked.map(|slot| slot.trail.block()));
        let will_come = |block| asked.clone().any(|fetch| fetch.block == block);
        debug_assert!(self.starved || waited.all(will_come), "a block that is waited for comes");
    }
}

/// Roots are looked at one by one if there are no more: each against all rays.
const FEW_ROOTS: usize = 8;

/// Numbers in any order: how many, and their sums of two kinds. Those of different sets, or with one twice, are hardly ever the same.
#[derive(Debug, PartialEq, Eq)]
struct Numbers {
    count: u64,
    sum: u64,
    squares: u64,
}

impl Numbers {
    fn of(numbers: impl Iterator<Item = u16>) -> Self {
        let none = Self { count: 0, sum: 0, squares: 0 };
        numbers.map(u64::from).fold(none, |so_far, number| Self {
            count: so_far.count.wrapping_add(1),
            sum: so_far.sum.wrapping_add(number),
            squares: so_far.squares.wrapping_add(number.wrapping_mul(number)),
        })
    }
}
