use super::slots::{Onward, RaySlot, Stage};
use super::{Ends, Node, Time, World};
use crate::shade::{PackedHit, Shadow};
use crate::trace::{BUNDLE, Trail};

/// Fewer rays than this go one by one.
const FEWEST: usize = if cfg!(test) { 2 } else { 4 };
/// Rays that are traced in a step at a node that has been asked for something of late, at most: it looks for more between, as others wait for its answers.
const MOST_BUSY: usize = 12;
/// Steps without a request after which none is expected soon.
const QUIET: u8 = 64;

/// Rays that are traced together, at most.
pub(super) const fn bundle_len() -> usize {
    if cfg!(feature = "bundles") { BUNDLE } else { 0 }
}

impl<W: World> Node<'_, W> {
    /// Whether no other node has asked for anything of late.
    pub(super) fn is_quiet(&self) -> bool {
        self.quiet >= QUIET
    }

    /// Rays that a step may trace, but for shadow rays that go together.
    pub(super) fn step_len(&self) -> usize {
        if self.is_quiet() { bundle_len() } else { bundle_len().min(MOST_BUSY) }
    }

    /// Traces the oldest of the rays that can go on together with those that begin as it does: how many.
    pub(super) fn trace_together(&mut self, now: Time) -> u32 {
        let begins = |slot: &&RaySlot| slot.stage() == Stage::Trace && slot.trail() == Trail::START;
        let slots = self.ready.iter().filter_map(|&number| self.rays.get(usize::from(number)));
        let slots = slots.take(self.step_len());
        let Some(shadow) = slots.clone().next().map(|slot| slot.ray.is_shadow()) else { return 0 };
        let alike = |slot: &&RaySlot| begins(slot) && slot.ray.is_shadow() == shadow;
        let rays = slots.take_while(alike).map(|slot| &slot.ray);
        if rays.clone().count() < FEWEST {
            return 0;
        }
        let Self { world, blocks, work, .. } = self;
        let count = if shadow {
            world.shadows_together(blocks, rays.map(|ray| ray.ray()), work).count
        } else {
            world.closest_together(blocks, rays, work)
        };
        for at in 0..count {
            let Some(number) = self.ready.front().copied() else { break };
            let Some(&(mut slot)) = self.rays.get(usize::from(number)) else { break };
            let Self { world, .. } = self;
            let end = if shadow {
                let end = world.shadow_end(at);
                end.map(|(traced, trail, depth)| (traced, trail, PackedHit::of_depth(depth)))
            } else {
                world.closest_end(at)
            };
            let Some((traced, trail, best)) = end else { break };
            self.ready.dequeue();
            slot.best = best;
            slot.set_trail(&trail);
            if self.traced(number, &mut slot, traced, now) {
                self.enqueue(number);
            }
        }
        count as u32
    }

    /// Traces the last shadow rays, which are of a bundle, together: how many.
    pub(super) fn trace_shadows_together(&mut self, count: usize, now: Time) -> u32 {
        if count < FEWEST {
            return 0;
        }
        let fresh = self.shadows.get(..self.fresh).unwrap_or_default();
        let rays = fresh.iter().rev().take(count).map(Shadow::ray);
        let Self { world, blocks, work, .. } = self;
        let Ends { count, apart, hidden } = world.shadows_together(blocks, rays, work);
        let mut at = 0;
        while at < count {
            let ended = count.saturating_sub(at).min((apart >> at).trailing_zeros() as usize);
            self.end_shadows(ended, hidden >> at);
            at += ended;
            if at < count {
                let Some((traced, trail, depth)) = self.world.shadow_end(at) else { break };
                let Some((shadow, _)) = self.take_shadow() else { break };
                self.shadow_traced(&shadow, Onward { trail, depth }, traced, now);
                at += 1;
            }
        }
        count as u32
    }
}
