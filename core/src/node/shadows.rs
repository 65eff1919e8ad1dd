use super::slots::{Onward, RaySlot};
use super::together::bundle_len;
use super::{Lit, Node, Prefetch, RayKind, Time, Traced, World};
use crate::shade::{PathRay, Shadow};
use crate::trace::BUNDLE;

/// Shadow rays traced one by one in a step, at least.
const SHADOWS_PER_STEP: u32 = 2;
/// A ray alone costs as much as so many of a bundle.
const ALONE: usize = 4;

impl<W: World> Node<'_, W> {
    pub(super) fn has_shadow_room(&self) -> bool {
        self.shadow_room() > 0
    }

    /// How many more shadow rays have room.
    pub(super) fn shadow_room(&self) -> usize {
        if self.settings.schedule.migrates(RayKind::Shadow) {
            self.free_len
        } else {
            self.shadows.len().saturating_sub(self.fresh).saturating_sub(self.parked)
        }
    }

    /// Makes shadow rays of a point, as many as there is room for: how many, and whether that was all.
    pub(super) fn make_shadows(
        &mut self,
        point: &W::Point,
        lights: &mut W::Lights,
        from: &RaySlot,
    ) -> (u32, bool) {
        let (root, pixel) = (from.root, from.ray.pixel());
        let room = self.shadow_room();
        let migrate = self.settings.schedule.migrates(RayKind::Shadow);
        let mut made = 0;
        let mut all = false;
        while made < room {
            let Self { world, blocks, counts, work, .. } = &mut *self;
            let mut shadow = match world.next_light(blocks, point, lights, &mut counts.shade, work)
            {
                Some(Lit::By(shadow)) => shadow,
                Some(Lit::Whole(sum)) => {
                    self.add(root, pixel, sum);
                    continue;
                }
                None => {
                    all = true;
                    break;
                }
            };
            if migrate {
                let world = &self.world;
                let ray = PathRay::of_shadow(&shadow, world.shadow_key(point, lights), pixel);
                if let Some(number) = self.take_slot(RaySlot::new(ray, root, from.since)) {
                    self.enqueue(number);
                }
            } else {
                (shadow.pixel, shadow.root) = (pixel, root);
                self.put_shadow(shadow);
            }
            made = made.saturating_add(1);
        }
        if migrate {
            self.counts.shade.shadow = self.counts.shade.shadow.saturating_add(made as u64);
        } else {
            self.open(root, made as u32);
            let held = self.fresh.saturating_add(self.parked) as u32;
            self.counts.shadows_peak = self.counts.shadows_peak.max(held);
        }
        (made as u32, all)
    }

    /// Puts a shadow ray behind the others, but before those that have been looked at, and so before those that go on.
    fn put_shadow(&mut self, shadow: Shadow) {
        let Self { shadows, onward, fresh, looked_at, going, .. } = self;
        // Where those begin that have been looked at, and those that go on: one of each makes place behind the others.
        let [second, third] = [looked_at, going].map(|last| fresh.saturating_sub(*last));
        take_over(shadows, *fresh, third);
        take_over(onward, *fresh, third);
        take_over(shadows, third, second);
        put(shadows, second, shadow);
        *fresh = fresh.saturating_add(1);
    }

    /// Traces some of the shadow rays that wait, bundle by bundle.
    pub(super) fn light(&mut self, now: Time) -> u32 {
        if !self.draining && self.going == 0 {
            self.draining = true;
            // Each time the other way round: the blocks towards the light that came last are still here.
            self.turned = !self.turned;
            let turned = if self.turned { u32::MAX } else { 0 };
            // Where much has to come, a bundle is cut short by blocks: of rays of the same signs more go together. Else they follow their points, which suits
            // pyramids.
            let by_signs = cfg!(feature = "bundles") && !self.is_quiet();
            // Those that go on stand behind them: among them they would divide bundles.
            let begin = self.fresh.saturating_sub(self.looked_at);
            let begin = self.shadows.get_mut(..begin).unwrap_or_default();
            let order = |shadow: &Shadow| shadow.order(by_signs) ^ turned;
            // Nobody waits there: no block is awaited.
            #[cfg(feature = "bundles")]
            crate::render::sort_large_by_key(begin, self.awaited, order);
            #[cfg(not(feature = "bundles"))]
            crate::render::sort_by_key(begin, order);
        }
        let traced = match self.last_bundle() {
            Some((false, count)) if self.skip_bundle(count, now) => SHADOWS_PER_STEP,
            bundle => {
                let count = bundle.map_or(0, |(_, count)| count).min(bundle_len());
                let together = self.trace_shadows_together(count, now);
                if together > 0 { together } else { self.trace_shadows(count, now) }
            }
        };
        self.draining &= self.fresh > 0;
        traced
    }

    /// The shadow rays at the end that go to the same light and are at their beginning: whether they have been looked at, and how many they are.
    fn last_bundle(&self) -> Option<(bool, usize)> {
        let fresh = self.shadows.get(..self.fresh)?;
        let source = fresh.last()?.source;
        // What has been looked at is gone through in each step: no further than it is traced.
        let traced = bundle_len().max(SHADOWS_PER_STEP as usize);
        let looked_at = self.looked_at > 0;
        let most = match (looked_at, self.going) {
            (true, 0) => traced.min(self.looked_at),
            (true, _) => 0,
            (false, _) => self.world.most(),
        };
        let last = fresh.get(fresh.len().saturating_sub(most)..)?;
        let alike = |shadow: &&Shadow| shadow.source == source;
        Some((looked_at, last.iter().rev().take_while(alike).count()))
    }

    /// Looks at the last shadow rays: whether nothing can be in the way of them, or of the last bundle. Then these are done.
    fn skip_bundle(&mut self, count: usize, now: Time) -> bool {
        let Self { world, blocks, work, .. } = self;
        let last = self.shadows.get(..self.fresh).unwrap_or_default().iter().rev().take(count);
        let skipped = world.clear_of(blocks, last, work);
        let clear = skipped > 0;
        let count = if clear { skipped } else { count.min(BUNDLE) };
        let first = self.fresh.saturating_sub(count);
        let bundle = self.shadows.get(first..self.fresh).unwrap_or_default();
        let mut room = [0; Prefetch::MOST as usize];
        let most = if clear { 0 } else { self.settings.prefetch.most() };
        let ahead = match room.get_mut(..most) {
            Some(room) if most > 0 => {
                let found = world.touched(blocks, bundle.iter(), room, work);
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
        if clear {
            self.end_shadows(count, 0);
        } else {
            self.looked_at = count;
        }
        clear
    }

    /// The last shadow rays have come to their end, none of which goes on: the last of all is hidden if the lowest bit is set, and so on.
    pub(super) fn end_shadows(&mut self, count: usize, mut hidden: u64) {
        let waiting = self.shadows.get(..self.fresh).unwrap_or_default();
        let Some(last) = waiting.last().filter(|_| count > 0) else { return };
        // Most follow one of the same root, which hears of them together.
        let (mut of, mut rays) = (last.root, 0);
        let first = self.fresh.saturating_sub(count);
        for at in (first..self.fresh).rev() {
            let Self { world, shadows, .. } = &*self;
            let Some(shadow) = shadows.get(at) else { break };
            let root = shadow.root;
            if hidden & 1 == 0 {
                let sum = world.passed(shadow.light(), Onward::START.depth);
                let pixel = shadow.pixel;
                self.add(root, pixel, sum);
            }
            hidden >>= 1;
            if root != of {
                self.close(of, core::mem::take(&mut rays));
                of = root;
            }
            rays += 1;
        }
        self.close(of, rays);
        let ended = self.fresh.saturating_sub(first);
        self.looked_at = self.looked_at.saturating_sub(ended);
        self.fresh = first;
    }

    /// Takes the last shadow ray, and where it goes on.
    pub(super) fn take_shadow(&mut self) -> Option<(Shadow, Onward)> {
        self.fresh = self.fresh.checked_sub(1)?;
        self.looked_at = self.looked_at.saturating_sub(1);
        let mut onward = Onward::START;
        if self.going > 0 {
            self.going = self.going.saturating_sub(1);
            onward = *self.onward.get(self.fresh)?;
        }
        Some((*self.shadows.get(self.fresh)?, onward))
    }

    /// Traces some of the last shadow rays one by one: how many. Of those that are not at their beginning `count` is 0.
    fn trace_shadows(&mut self, count: usize, now: Time) -> u32 {
        let most = (self.step_len() / ALONE) as u32;
        let most = (count as u32).clamp(1, most.max(SHADOWS_PER_STEP));
        for _ in 0..most {
            let Some((shadow, mut onward)) = self.take_shadow() else { break };
            let Onward { trail, depth } = &mut onward;
            let Self { world, blocks, work, .. } = self;
            let traced = world.shadow(blocks, &shadow.ray(), trail, depth, work);
            self.shadow_traced(&shadow, onward, traced, now);
        }
        most
    }

    /// A shadow ray has come to its end, or to a block that is not here.
    pub(super) fn shadow_traced(
        &mut self,
        shadow: &Shadow,
        onward: Onward,
        traced: Traced,
        now: Time,
    ) {
        match traced {
            Traced::Done => {
                let light = self.world.passed(shadow.light(), onward.depth);
                self.add(shadow.root, shadow.pixel, light);
                self.close(shadow.root, 1);
            }
            Traced::Missing(block) => {
                self.parked = self.parked.saturating_add(1);
                let place = self.shadows.len().saturating_sub(self.parked);
                put(self.shadows, place, *shadow);
                put(self.onward, place, onward);
                put(self.awaited, place, onward.trail.block());
                self.await_block(block, now);
            }
            Traced::Corrupt(block) => {
                self.lost = Some(block);
                self.close(shadow.root, 1);
            }
        }
    }
}

/// Puts one in a place, whatever is there.
#[cfg_attr(not(feature = "bundles"), inline(never))]
pub(super) fn put<T>(all: &mut [T], place: usize, one: T) {
    if let Some(place) = all.get_mut(place) {
        *place = one;
    }
}

/// A place gets what is in another, where it is not needed any more.
#[cfg_attr(not(feature = "bundles"), inline(never))]
pub(super) fn take_over<T: Copy>(all: &mut [T], place: usize, other: usize) {
    if place != other
        && let Some(&one) = all.get(other)
    {
        put(all, place, one);
    }
}
