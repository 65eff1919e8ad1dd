use super::slots::{RaySlot, ShadowSlot};
use super::world::BUNDLE;
use super::{Node, RayKind, Time, Traced, World};
use crate::shade::{PathRay, Shadow};
use crate::trace::Trail;

/// Blocks that are asked for ahead at once, at most.
const AHEAD: usize = 16;
/// Shadow rays traced in a step.
const SHADOWS_PER_STEP: u32 = 2;

impl<W: World> Node<'_, W> {
    pub(super) fn has_shadow_room(&self) -> bool {
        if self.settings.schedule.migrates(RayKind::Shadow) {
            self.free_len > 0
        } else {
            self.fresh.saturating_add(self.parked) < self.shadows.len()
        }
    }

    pub(super) fn put_shadow(
        &mut self,
        mut shadow: Shadow,
        key: crate::path::PathKey,
        from: &RaySlot,
    ) {
        let (root, pixel) = (from.root, from.ray.pixel());
        if self.settings.schedule.migrates(RayKind::Shadow) {
            self.counts.shade.shadow = self.counts.shade.shadow.saturating_add(1);
            let ray = PathRay::of_shadow(&shadow, key, pixel);
            if let Some(number) = self.take_slot(RaySlot::new(ray, root, from.since)) {
                self.enqueue(number);
            }
            return;
        }
        self.open(root);
        shadow.pixel = u32::from(pixel);
        if let Some(place) = self.shadows.get_mut(self.fresh) {
            *place = ShadowSlot { shadow, trail: Trail::START, depth: [0; 3], root, begun: 0 };
            self.fresh = self.fresh.saturating_add(1);
        }
        let held = self.fresh.saturating_add(self.parked) as u32;
        self.counts.shadows_peak = self.counts.shadows_peak.max(held);
    }

    /// Traces some of the shadow rays that wait, bundle by bundle.
    pub(super) fn light(&mut self, now: Time) -> u32 {
        if !self.draining {
            self.draining = true;
            // Each time the other way round: the blocks towards the light that came last are still here.
            self.turned = !self.turned;
            let turned = if self.turned { u32::MAX } else { 0 };
            let fresh = self.shadows.get_mut(..self.fresh).unwrap_or_default();
            crate::render::sort_by_key(fresh, |slot| slot.shadow.source ^ turned);
        }
        let mut traced = SHADOWS_PER_STEP;
        if !self.skip_bundle(now) {
            match self.trace_shadows_together(now) {
                0 => {
                    for _ in 0..SHADOWS_PER_STEP {
                        if !self.trace_shadow(now) {
                            break;
                        }
                    }
                }
                count => traced = count,
            }
        }
        self.draining = self.fresh > 0;
        traced
    }

    /// Whether the last bundle is one that nothing can be in the way of: then it is done.
    fn skip_bundle(&mut self, now: Time) -> bool {
        let fresh = self.shadows.get(..self.fresh).unwrap_or_default();
        let Some(last) = fresh.last().filter(|slot| slot.begun == 0) else { return false };
        let source = last.shadow.source;
        let alike = |slot: &&ShadowSlot| slot.begun == 0 && slot.shadow.source == source;
        let count = fresh.iter().rev().take(BUNDLE).take_while(alike).count();
        let first = self.fresh.saturating_sub(count);
        let Self { world, blocks, work, shadows, .. } = self;
        let bundle = shadows.get(first..self.fresh).unwrap_or_default();
        let clear = world.is_clear(blocks, bundle.iter().map(|slot| &slot.shadow), work);
        let mut room = [0; AHEAD];
        let most = if clear { 0 } else { self.settings.prefetch.most().min(AHEAD) };
        let ahead = match room.get_mut(..most) {
            Some(room) if most > 0 => {
                let rays = bundle.iter().map(|slot| &slot.shadow);
                let found = world.touched(blocks, rays, room, work);
                room.get(..found).unwrap_or_default()
            }
            _ => &[],
        };
        for &block in ahead {
            self.prefetch(block, now);
        }
        let traced = &mut self.counts.shade;
        let kind = if clear { &mut traced.shadow_clear } else { &mut traced.shadow };
        *kind = kind.saturating_add(count as u64);
        for at in first..self.fresh {
            let Some(slot) = self.shadows.get_mut(at) else { break };
            slot.begun = 1;
            if clear {
                let slot = *slot;
                self.end_shadow(&slot);
            }
        }
        if clear {
            self.fresh = first;
        }
        clear
    }

    fn end_shadow(&mut self, slot: &ShadowSlot) {
        let sum = self.world.passed(slot.shadow.light(), slot.depth);
        self.add(slot.root, slot.shadow.pixel as u16, sum);
        self.close(slot.root);
    }

    /// Takes the last shadow ray that has been looked at; `None` if there is none.
    pub(super) fn take_shadow(&mut self) -> Option<ShadowSlot> {
        let at = self.fresh.checked_sub(1)?;
        let slot = self.shadows.get(at).copied().filter(|slot| slot.begun != 0)?;
        self.fresh = at;
        Some(slot)
    }

    /// Traces the last shadow ray that has been looked at; `false` if there is none.
    fn trace_shadow(&mut self, now: Time) -> bool {
        let Some(mut slot) = self.take_shadow() else { return false };
        let ray = slot.shadow.ray();
        let Self { world, blocks, work, .. } = self;
        let traced = world.shadow(blocks, &ray, &mut slot.trail, &mut slot.depth, work);
        self.shadow_traced(slot, traced, now);
        true
    }

    /// A shadow ray has come to its end, or to a block that is not here.
    pub(super) fn shadow_traced(&mut self, slot: ShadowSlot, traced: Traced, now: Time) {
        match traced {
            Traced::Done => self.end_shadow(&slot),
            Traced::Missing(block) => {
                self.parked = self.parked.saturating_add(1);
                let place = self.shadows.len().saturating_sub(self.parked);
                if let Some(place) = self.shadows.get_mut(place) {
                    *place = slot;
                }
                self.want(block, now);
            }
            Traced::Corrupt(block) => {
                self.lost = Some(block);
                self.close(slot.root);
            }
        }
    }
}
