//! What holds between any two steps of a node.

use super::super::slots::{RootState, Stage};
use super::super::{Node, World};
use crate::store::Place;
use std::collections::BTreeSet;

impl<W: World> Node<'_, W> {
    /// Panics where an invariant does not hold.
    pub(super) fn check_invariants(&self) {
        // The list of free slots is that of the slots in stage `Free`, once each.
        let free: BTreeSet<u16> = self.free[..self.free_len].iter().copied().collect();
        assert_eq!(free.len(), self.free_len, "a slot is free once");
        for (slot, at) in self.rays.iter().zip(0..) {
            assert_eq!(slot.stage() == Stage::Free, free.contains(&at), "slot {at}");
        }
        // A slot is queued if, and only if, it can go on.
        let mut queued: Vec<u16> = self.ready.iter().copied().collect();
        queued.sort_unstable();
        let can_go_on =
            |stage| matches!(stage, Stage::Trace | Stage::Send | Stage::Shade | Stage::Split);
        let going = self.rays.iter().zip(0..).filter(|(slot, _)| can_go_on(slot.stage()));
        assert_eq!(queued, going.map(|(_, at)| at).collect::<Vec<u16>>());
        // Each root counts its rays and shadow rays; a free one has none.
        assert!(self.fresh + self.parked <= self.shadows.len());
        let (fresh, rest) = self.shadows.split_at(self.fresh);
        let parked = &rest[rest.len() - self.parked..];
        for (root, at) in self.roots.iter().zip(0..) {
            let rays =
                self.rays.iter().filter(|r| r.stage() != Stage::Free && r.root == at).count();
            let shadows = fresh.iter().chain(parked).filter(|slot| slot.root == at).count();
            assert_eq!(root.open as usize, rays + shadows, "root {at}");
            let ended = !matches!(
                root.state(),
                RootState::Opening | RootState::Rendering | RootState::Visit
            );
            assert!(!ended || root.open == 0, "root {at}");
            assert!(root.state() != RootState::Visit || root.open > 0, "visit {at}");
            assert_eq!(
                root.is_visit(),
                root.state() != RootState::Free && usize::from(at) >= self.tiles.len()
            );
        }
        let visits = self.roots.iter().filter(|root| root.is_visit()).count();
        assert_eq!(usize::from(self.visitors), visits);
        for (state, noted) in [(1, self.unsent), (3, self.complete)] {
            assert!(noted || self.fetches.iter().all(|fetch| fetch.state != state));
        }
        self.router.check_counts();
        // A block is asked for once, and its frame is reserved.
        let asked: Vec<u32> =
            self.fetches.iter().filter(|fetch| fetch.state != 0).map(|fetch| fetch.block).collect();
        assert_eq!(asked.iter().collect::<BTreeSet<_>>().len(), asked.len(), "asked for once");
        for &block in asked.iter().filter(|_| self.keeps(super::super::rules::Rule::FrameFirst)) {
            assert_eq!(self.blocks.cache.place(block), Place::OnItsWay, "block {block}");
        }
        // Whoever waits for a block waits for one that is on its way, or will be asked for again.
        let blocked = self.rays.iter().filter(|slot| slot.stage() == Stage::Blocked);
        let waited = blocked.map(|slot| slot.trail().block());
        for block in waited.chain(parked.iter().map(|slot| slot.trail.block())) {
            assert!(asked.contains(&block) || self.starved, "block {block} is waited for");
        }
    }
}
