use super::rules::Rule;
use super::shadows::{put, take_over};
use super::slots::{RaySlot, Root, RootState, Stage};
use super::tell::tell;
use super::{Node, RayKind, Settings, TaskOrder, Time, Traced, World};
use crate::network::NodeId;
use crate::protocol::{Message, RayMessage, ReturnAddress, split};
use crate::render::sort_by_key;
use crate::shade::{Counts as ShadeCounts, PackedHit, PathRay, Task};
use crate::store::Residency;

/// Requests for a ray after which it is run at home.
const RAY_TRIES: u8 = 5;
/// As many where the hit is known: nothing needs to be fetched at home.
const HIT_TRIES: u8 = 2;

impl<W: World> Node<'_, W> {
    /// How many slots must stay free beside that of a new ray: one for each time that it, or what follows from it, needs
    /// another one while it holds its own (rule 7).
    ///
    /// A ray that may split `s` times takes a slot only if more than `s` are free. Why that is enough: rays with
    /// `s = 0` need none and end. If only rays with `s ≥ k` are left at a node and none can go on, take the one that got its slot last: since then no slot was
    /// taken, so `k` are free at least, and a child with `k - 1` may have one. Rays that are away end likewise elsewhere, or after so many
    /// refusals in the slot that they have here (rule 8).
    fn reserve(&self, task: Task, depth: u32) -> usize {
        if !self.keeps(Rule::Reserve) {
            return 0;
        }
        let splits = self.world.splits(depth);
        let splits = if self.keeps(Rule::ReserveByDepth) { splits } else { splits.min(1) };
        match task {
            Task::Shadow => 0,
            Task::Lights => self.settings.schedule.reserve(0),
            Task::Path | Task::Hit => self.settings.schedule.reserve(splits),
        }
    }

    pub(super) fn may_take_slot(&self, ray: &PathRay) -> bool {
        self.free_len > self.reserve(ray.task(), ray.depth())
    }

    /// Takes a slot for a ray of a root.
    pub(super) fn take_slot(&mut self, slot: RaySlot) -> Option<u16> {
        let len = self.free_len.checked_sub(1)?;
        let number = *self.free.get(len)?;
        *self.rays.get_mut(usize::from(number))? = slot;
        self.free_len = len;
        let held = self.rays.len().saturating_sub(len) as u32;
        self.counts.rays_peak = self.counts.rays_peak.max(held);
        self.open(slot.root, 1);
        Some(number)
    }

    /// The number of a new path.
    fn begin_path(&mut self) -> u32 {
        self.begun = self.begun.wrapping_add(1);
        self.begun
    }

    /// A path number that sorts before all present ones: rays that come back go first.
    fn oldest(&self) -> u32 {
        self.begun.wrapping_sub(u32::MAX / 2)
    }

    /// Puts the slots that can go on in the order in which their paths were begun, if that is the order of work.
    pub(super) fn order_ready(&mut self) {
        if self.settings.order == TaskOrder::Made {
            let Self { ready, rays, begun, .. } = self;
            let age = |number: &u16| {
                rays.get(usize::from(*number)).map_or(0, |slot| begun.wrapping_sub(slot.since))
            };
            sort_by_key(ready.as_mut_slice(), |number| !age(number));
        }
    }

    /// A ray has ended.
    pub(super) fn free_slot(&mut self, number: u16) {
        let Some(slot) = self.rays.get_mut(usize::from(number)) else { return };
        debug_assert!(slot.stage() != Stage::Free, "a slot is freed once");
        let root = slot.root;
        *slot = bytemuck::Zeroable::zeroed();
        if let Some(place) = self.free.get_mut(self.free_len) {
            *place = number;
            self.free_len = self.free_len.saturating_add(1);
        }
        self.close(root, 1);
    }

    /// Writes a slot back.
    pub(super) fn put(&mut self, number: u16, slot: RaySlot) {
        if let Some(place) = self.rays.get_mut(usize::from(number)) {
            *place = slot;
        }
    }

    /// Goes on with a ray: `false` if it lacks room, and stays as it is.
    pub(super) fn advance(&mut self, number: u16, now: Time) -> bool {
        let Some(&slot) = self.rays.get(usize::from(number)) else { return true };
        match slot.stage() {
            Stage::Trace => self.trace(number, slot, now),
            Stage::Send => self.send(number, slot, now),
            Stage::Shade => self.shade(number, slot, now),
            Stage::Split => self.split(number, slot),
            Stage::Free | Stage::Blocked | Stage::Away => true,
        }
    }

    fn kind(ray: &PathRay) -> RayKind {
        match (ray.is_shadow(), ray.depth()) {
            (true, _) => RayKind::Shadow,
            (false, 0) => RayKind::Camera,
            (false, _) => RayKind::Specular,
        }
    }

    fn trace(&mut self, number: u16, mut slot: RaySlot, now: Time) -> bool {
        let mut trail = slot.trail();
        let Self { world, blocks, work, .. } = self;
        let traced = if slot.ray.is_shadow() {
            let mut depth = slot.best.depth();
            let traced = world.shadow(blocks, &slot.ray.ray(), &mut trail, &mut depth, work);
            slot.best = PackedHit::of_depth(depth);
            traced
        } else {
            world.closest(blocks, &slot.ray, &mut trail, &mut slot.best, work)
        };
        slot.set_trail(&trail);
        if self.traced(number, &mut slot, traced, now) && !self.shade(number, slot, now) {
            self.enqueue(number);
        }
        true
    }

    /// A ray has come to its end, or to a block that is not here. `true`: it is to be shaded.
    pub(super) fn traced(
        &mut self,
        number: u16,
        slot: &mut RaySlot,
        traced: Traced,
        now: Time,
    ) -> bool {
        match traced {
            Traced::Done if slot.ray.is_shadow() => {
                let sum = self.world.passed(slot.ray.path().throughput, slot.best.depth());
                self.add(slot.root, slot.ray.pixel(), sum);
                self.free_slot(number);
            }
            Traced::Done => {
                slot.at = [0; 8];
                slot.set_stage(Stage::Shade);
                self.put(number, *slot);
                return true;
            }
            Traced::Missing(block) => {
                let migrates = self.settings.schedule.migrates(Self::kind(&slot.ray));
                let goes = migrates && slot.home == 0 && self.owner_for(block, None, 0).is_some();
                slot.set_stage(if goes { Stage::Send } else { Stage::Blocked });
                self.put(number, *slot);
                if !goes {
                    self.blocked = self.blocked.saturating_add(1);
                    self.await_block(block, now);
                } else if !self.send(number, *slot, now) {
                    self.enqueue(number);
                }
            }
            Traced::Corrupt(block) => {
                self.lost = Some(block);
                self.free_slot(number);
            }
        }
        false
    }

    /// Shades a hit: its light, its shadow rays as long as there is room, then its children.
    fn shade(&mut self, number: u16, mut slot: RaySlot, now: Time) -> bool {
        let begun = slot.at.last() == Some(&1);
        if begun && !self.has_shadow_room() {
            return false;
        }
        let (light, point) = self.world.arrive(&slot.ray, &slot.best);
        let only_lights = slot.ray.task() == Task::Lights;
        if begun {
            self.note_shading_again();
        } else {
            self.work.shadings = self.work.shadings.saturating_add(1);
            if point.as_ref().is_some_and(|point| self.lives_elsewhere(&slot, point)) {
                if !self.keeps(Rule::WholeAnswer) {
                    self.add(slot.root, slot.ray.pixel(), light);
                }
                return self.send_hit(number, slot, now);
            }
            let added = slot.ray.task() == Task::Hit && !self.keeps(Rule::WholeAnswer);
            if !only_lights && !added {
                self.add(slot.root, slot.ray.pixel(), light);
            }
        }
        let Some(point) = point else {
            self.free_slot(number);
            return true;
        };
        let mut lights = self.world.lights(&point, begun.then_some(slot.at));
        let given = !begun && self.give_lights(&slot, &point);
        let (made, all) =
            if given { (0, true) } else { self.make_shadows(&point, &mut lights, &slot) };
        self.work.light_samples = self.work.light_samples.saturating_add(made);
        if !all {
            slot.at = self.world.save(&lights);
            self.put(number, slot);
            self.enqueue(number);
            return true;
        }
        if made > 0 {
            self.helpers.rays_per_hit = made;
        }
        if only_lights {
            self.free_slot(number);
            return true;
        }
        let Self { world, counts, .. } = &mut *self;
        let [a, b] = world.children(&point, slot.ray.pixel(), &mut counts.shade);
        let count = u64::from(a.is_some()) + u64::from(b.is_some());
        self.counts.shade.specular = self.counts.shade.specular.saturating_add(count);
        self.follow(number, slot, [a, b])
    }

    /// The first child takes over the slot; the second gets another one, when there is one.
    fn follow(&mut self, number: u16, mut slot: RaySlot, children: [Option<PathRay>; 2]) -> bool {
        let (first, second) = match children {
            [Some(a), b] => (a, b),
            [None, Some(b)] => (b, None),
            [None, None] => {
                self.free_slot(number);
                return true;
            }
        };
        if let Some(second) = second {
            if !self.may_take_slot(&second) {
                slot.set_stage(Stage::Split);
                self.put(number, slot);
                return false;
            }
            if let Some(other) = self.take_slot(RaySlot::new(second, slot.root, slot.since)) {
                self.enqueue(other);
            }
        }
        self.put(number, RaySlot::new(first, slot.root, slot.since));
        self.enqueue(number);
        true
    }

    /// Counts a hit whose shading goes on.
    fn note_shading_again(&mut self) {
        #[cfg(feature = "bundles")]
        {
            self.work.shadings_again = self.work.shadings_again.saturating_add(1);
        }
    }

    /// Tries again to give the second child its slot.
    fn split(&mut self, number: u16, slot: RaySlot) -> bool {
        // As for the child, which is to be found for it.
        if self.free_len <= self.reserve(Task::Path, slot.ray.depth().saturating_add(1)) {
            return false;
        }
        self.note_shading_again();
        let (_, point) = self.world.arrive(&slot.ray, &slot.best);
        let Some(point) = point else {
            self.free_slot(number);
            return true;
        };
        let children = self.world.children(&point, slot.ray.pixel(), &mut ShadeCounts::default());
        self.follow(number, slot, children)
    }

    /// Sends a ray to the owner of its next block, or of its hit's.
    ///
    /// A ray that is all that is left of a visit goes on in the visit's name, with what that has brought: nothing waits for it here
    /// (a tail call, rule 9).
    pub(super) fn send(&mut self, number: u16, mut slot: RaySlot, now: Time) -> bool {
        let trail = slot.trail();
        let only_lights = slot.ray.task() == Task::Lights;
        let sent_to = NodeId(slot.sent_to);
        let asked = (slot.tries > 0).then_some(sent_to);
        let to = match slot.ray.task() {
            Task::Lights => Some(sent_to),
            Task::Hit => self.owner_for(slot.best.block(), asked, 0),
            Task::Path | Task::Shadow => self.owner_for(trail.block(), asked, 0),
        };
        let Some(to) = to else {
            slot.run_at_home();
            self.put(number, slot);
            return false;
        };
        let visit = self.roots.get(usize::from(slot.root)).copied();
        let visit =
            visit.filter(|root| root.state() == RootState::Visit && root.open == 1 && !only_lights);
        let own = ReturnAddress::new(self.here, number, slot.name());
        let message = RayMessage {
            reply: visit.map_or(own, |root| root.to),
            ray: slot.ray,
            sum: split(visit.map_or_else(Default::default, |root| root.sum)),
            best: slot.best,
            trail,
        };
        if !self.push(to, &Message::Ray(message.bytes()), now) {
            return false;
        }
        if slot.tries == 0 && !slot.ray.task().knows_hit() {
            self.counts.migrated = self.counts.migrated.saturating_add(1);
        }
        if visit.is_some() {
            self.free_slot(number);
            self.free_root(usize::from(slot.root));
            return true;
        }
        let limit = self.settings.limit(0, self.ray_time, slot.tries.into());
        slot.set_stage(Stage::Away);
        slot.sent_to = to.0;
        slot.since = now.ticks();
        slot.limit = limit.limit_ticks();
        self.put(number, slot);
        self.note_deadline(now.after(Time::of_ticks(slot.limit)));
        true
    }

    /// Time limits of rays that are away (rule 15).
    pub(super) fn ray_deadlines(&mut self, now: Time) {
        for number in 0..self.rays.len() {
            let Some(&(mut slot)) = self.rays.get(number) else { break };
            if slot.stage() != Stage::Away {
                continue;
            }
            let age = now.ticks_since(slot.since);
            if age < slot.limit {
                self.note_deadline(now.after(Time::of_ticks(slot.limit.saturating_sub(age))));
                continue;
            }
            slot.since = self.oldest();
            if slot.sent_to == REFUSED {
                slot.set_stage(Stage::Send);
            } else {
                self.suspect(NodeId(slot.sent_to));
                self.helpers.remove(slot.sent_to);
                self.counts.rays_again = self.counts.rays_again.saturating_add(1);
                slot.tries = slot.tries.saturating_add(1);
                slot.set_stage(Stage::Send);
                let known = slot.ray.task().knows_hit();
                if slot.tries >= if known { HIT_TRIES } else { RAY_TRIES } {
                    tell!(debug, "node {}: a ray sent in vain runs at home", self.here.0);
                    self.counts.run_at_home = self.counts.run_at_home.saturating_add(1);
                    slot.run_at_home();
                }
            }
            self.put(number as u16, slot);
            self.enqueue(number as u16);
        }
    }

    /// The away ray that an address names, if it is one.
    pub(super) fn away(&mut self, to: &ReturnAddress) -> Option<&mut RaySlot> {
        // Rule 14.
        let by_key = self.keeps(Rule::AnswerByKey);
        let slot = self.rays.get_mut(usize::from(to.slot()))?;
        let named = slot.stage() == Stage::Away && (slot.name() == to.key() || !by_key);
        (named && to.node() == self.here).then_some(slot)
    }

    /// A ray was refused: it is sent again a little later, or run here after so many refusals (rule 8).
    pub(super) fn on_refusal(&mut self, to: &ReturnAddress, now: Time) {
        let (most, pause) = (self.settings.refusals, Time(self.settings.patience.0 / 16));
        let limited = self.keeps(Rule::RefusalLimit);
        let oldest = self.oldest();
        let Some(slot) = self.away(to) else {
            self.note_unasked();
            return;
        };
        let home = slot.ray.task().knows_hit() || slot.refusals >= most && limited;
        slot.refusals = slot.refusals.saturating_add(1);
        let helper = (slot.ray.task() == Task::Lights).then_some(slot.sent_to);
        if home {
            slot.since = oldest;
            slot.run_at_home();
        } else {
            slot.sent_to = REFUSED;
            slot.since = now.ticks();
            slot.limit = pause.limit_ticks();
        }
        if let Some(helper) = helper {
            self.helpers.remove(helper);
        }
        self.counts.refused = self.counts.refused.saturating_add(1);
        if home {
            self.counts.run_at_home = self.counts.run_at_home.saturating_add(1);
            self.enqueue(to.slot());
        } else {
            self.note_deadline(now.after(Time::of_ticks(pause.limit_ticks())));
        }
    }

    /// A ray of another node: it becomes a visit, or is refused where it lies (rules 4, 5, 7).
    pub(super) fn on_ray(&mut self, message: &RayMessage, now: Time) {
        let to = message.reply;
        let same = |root: &Root| root.is_visit() && root.to == to;
        if self.visitors > 0 && self.roots.iter().any(same) {
            self.push(to.node(), &Message::AtWork { to }, now);
            return;
        }
        let first = self.tiles.len();
        let free = self.roots.iter().skip(first).position(|r| r.state() == RootState::Free);
        let place = free.filter(|_| self.may_take_slot(&message.ray));
        let Some(place) = place else {
            // There is room: `requests` looked for it.
            self.push(to.node(), &Message::Refusal { to }, now);
            return;
        };
        let at = first.saturating_add(place);
        if let Some(root) = self.roots.get_mut(at) {
            root.set_state(RootState::Visit);
            self.visitors = self.visitors.saturating_add(1);
            root.to = to;
            root.sum = crate::protocol::join(message.sum);
        }
        let number = self.begin_path();
        let mut slot = RaySlot::new(message.ray, at as u16, number).at_trail(&message.trail);
        slot.best = message.best;
        if slot.ray.task().knows_hit() {
            slot.at = [0; 8];
            slot.set_stage(Stage::Shade);
        }
        if let Some(number) = self.take_slot(slot) {
            self.enqueue(number);
        }
        self.counts.visitors = self.counts.visitors.saturating_add(1);
        self.counts.visitors_peak = self.counts.visitors_peak.max(self.visitors.into());
    }

    /// Begins camera rays of the oldest tile that has any, as long as slots are free.
    pub(super) fn open_camera_rays(&mut self) -> bool {
        let mut opened = false;
        while self.can_open_camera_rays() {
            let Some(at) = self.tiles.opening(self.roots) else { break };
            let Some(root) = self.roots.get_mut(usize::from(at)) else { break };
            if let Some(ray) = self.world.camera(root.tile, &mut root.camera) {
                self.counts.shade.primary = self.counts.shade.primary.saturating_add(1);
                let path = self.begin_path();
                if let Some(number) = self.take_slot(RaySlot::new(ray, at, path)) {
                    self.enqueue(number);
                }
                opened = true;
            } else {
                root.set_state(RootState::Rendering);
                // The last ray may have ended before.
                self.open(at, 1);
                self.close(at, 1);
                break;
            }
        }
        opened
    }

    /// Whether a camera ray can begin: some slots are left to rays of other nodes.
    pub(super) fn can_open_camera_rays(&self) -> bool {
        let Settings { schedule, points, placement, .. } = &self.settings;
        let (nodes, splits) = (placement.nodes, self.world.splits(0));
        let visited = schedule.expects_visits(nodes, splits) || points.expects_visits(nodes);
        let kept = if visited { self.rays.len() / 4 } else { 0 };
        self.free_len > schedule.reserve(splits).max(kept)
            && self.tiles.opening(self.roots).is_some()
    }

    /// Lets all go on that wait for this block.
    pub(super) fn wake(&mut self, block: u32) {
        let slots = if self.blocked > 0 { self.rays.len() } else { 0 };
        for number in 0..slots {
            let Some(slot) = self.rays.get_mut(number) else { break };
            if slot.stage() == Stage::Blocked && slot.trail().block() == block {
                slot.set_stage(Stage::Trace);
                self.blocked = self.blocked.saturating_sub(1);
                self.enqueue(number as u16);
            }
        }
        let Self { shadows, onward, awaited, fresh, looked_at, going, parked, .. } = self;
        let mut at = shadows.len().saturating_sub(*parked);
        while let Some(next) = awaited.get(at..).and_then(|rest| place_of(block, rest)) {
            at = at.saturating_add(next);
            let (Some(&shadow), Some(&trail)) = (shadows.get(at), onward.get(at)) else { break };
            // The place that it leaves is taken by the first of those that still wait.
            let first = shadows.len().saturating_sub(*parked);
            take_over(shadows, at, first);
            take_over(onward, at, first);
            take_over(awaited, at, first);
            put(shadows, *fresh, shadow);
            put(onward, *fresh, trail);
            *parked = parked.saturating_sub(1);
            *fresh = fresh.saturating_add(1);
            *looked_at = looked_at.saturating_add(1);
            *going = going.saturating_add(1);
            at = at.saturating_add(1);
        }
    }

    /// Asks again for blocks for which there was no frame: whether a ray can go on.
    pub(super) fn feed(&mut self, now: Time) -> bool {
        if !self.can_fetch() {
            return false;
        }
        self.starved = false;
        let mut woken = false;
        let slots = if self.blocked > 0 { self.rays.len() } else { 0 };
        for number in 0..slots {
            let Some(slot) = self.rays.get(number) else { break };
            if slot.stage() == Stage::Blocked {
                let block = slot.trail().block();
                if self.is_here(block) {
                    self.wake(block);
                    woken = true;
                } else {
                    self.want(block, now);
                }
            }
            if self.starved {
                return woken;
            }
        }
        let first = self.shadows.len().saturating_sub(self.parked);
        for at in first..self.shadows.len() {
            let Some(&block) = self.awaited.get(at) else { break };
            if self.is_here(block) {
                self.wake(block);
                // What waits has been moved: the rest is looked at next time.
                self.starved = true;
                return true;
            }
            self.want(block, now);
            if self.starved {
                return woken;
            }
        }
        woken
    }

    fn is_here(&self, block: u32) -> bool {
        self.blocks.rom.holds(block) || self.blocks.cache.residency(block) == Residency::Cached
    }
}

/// Where the first of some numbers stands that is this one.
fn place_of(number: u32, among: &[u32]) -> Option<usize> {
    let mut from = 0_usize;
    if cfg!(feature = "bundles") {
        // Sixteen at a time, without a way out between them: so a processor with lanes compares them at once.
        let (chunks, _) = among.as_chunks::<16>();
        let has = |chunk: &[u32; 16]| chunk.iter().fold(false, |has, &n| has | (n == number));
        from = chunks.iter().take_while(|chunk| !has(chunk)).count().saturating_mul(16);
    }
    let place = among.get(from..)?.iter().position(|&n| n == number)?;
    Some(from.saturating_add(place))
}

/// In [`RaySlot::sent_to`]: it was refused, and is sent again when its time is up.
pub(super) const REFUSED: u16 = u16::MAX;

#[cfg(test)]
mod tests {
    use super::place_of;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn the_first_place_of_a_number_is_found(
            among in proptest::collection::vec(0_u32..40, 0..100), number in 0_u32..40,
        ) {
            prop_assert_eq!(place_of(number, &among), among.iter().position(|&n| n == number));
        }
    }
}
