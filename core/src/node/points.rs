use super::slots::{RaySlot, Stage};
use super::{Node, PointHome, Time, World};
use crate::shade::Task;

/// Points that live with the owners of their blocks ([`PointHome::Owner`]).
///
/// A hit goes to the owner as any ray goes to another node, and is one there: the owner asks its lights, sends its children and answers what all of them
/// bring. It is all that its ray brings, so it goes by the ray's own name, in the ray's own slot, by the rules of a ray that is away.
/// As the hit says all that shading needs, the finder can always do it instead, and does after one refusal or two time limits (rules 8, 16).
///
/// No point waits for one answer to pass it on: one that would ([`World::passes_on`]) stays where it was found, where its child takes over its
/// slot; and a visit that has nothing left but the hit sends it in the visit's name (rule 9).
impl<W: World> Node<'_, W> {
    /// Whether the point of a hit is another node's, and not yet there.
    pub(super) fn lives_elsewhere(&self, slot: &RaySlot, point: &W::Point) -> bool {
        let block = slot.best.block();
        self.settings.points == PointHome::Owner
            && slot.ray.task() == Task::Path
            && slot.home == 0
            && !self.blocks.rom.holds(block)
            && self.owner_for(block, None, 0).is_some()
            && !self.world.passes_on(point)
    }

    /// Sends a hit to the owner of its block: `false` if there is no room for the message yet.
    pub(super) fn send_hit(&mut self, number: u16, mut slot: RaySlot, now: Time) -> bool {
        slot.ray = slot.ray.with_task(Task::Hit);
        slot.set_stage(Stage::Send);
        self.put(number, slot);
        self.counts.points_moved = self.counts.points_moved.saturating_add(1);
        self.send(number, slot, now)
    }
}
