use super::rays::REFUSED;
use super::slots::{RaySlot, Stage};
use super::{Lit, Node, ShadowPolicy, Time, World};
use crate::network::NodeId;
use crate::path::mix;
use crate::protocol::Message;
use crate::shade::{Counts, Task};

/// Nodes that help this one at once, at most.
pub(super) const HELPERS: usize = 4;
/// Hits that a helper has of this node at once, at most.
const HITS: usize = 16;
/// Nodes that an idle one asks for work at a time, if nobody tells it who has some.
const ASKED: u64 = 4;
/// No node.
const NOBODY: u16 = u16::MAX;

/// Nodes without work that have said so to this one.
///
/// They ask the lights of some of its hits: a hit needs one message there and one back, however many shadow rays it sends. Its slot is that
/// of a ray that is away, by the same rules; nothing waits for a helper that has gone, as such a task needs nothing but shadow
/// rays, which can always be run at home (rule 10).
#[derive(Debug)]
pub(super) struct Helpers {
    pub(super) nodes: [u16; HELPERS],
    /// Shadow rays that the last hit has sent.
    pub(super) rays_per_hit: u32,
}

impl Helpers {
    pub(super) const NONE: Self = Self { nodes: [NOBODY; HELPERS], rays_per_hit: 0 };

    fn add(&mut self, node: NodeId) {
        if !self.nodes.contains(&node.0) {
            put_first(&mut self.nodes, node);
        }
    }

    /// It does not help any more.
    pub(super) fn remove(&mut self, node: u16) {
        for helper in self.nodes.iter_mut().filter(|helper| **helper == node) {
            *helper = NOBODY;
        }
    }
}

/// Puts a node before others; the last is forgotten.
pub(super) fn put_first(nodes: &mut [u16], node: NodeId) {
    nodes.iter_mut().fold(node.0, |before, place| core::mem::replace(place, before));
}

impl<W: World> Node<'_, W> {
    /// There are no tiles: if it has nothing else to do, this node says so to one that the master has named, or to some by chance. Nothing depends
    /// on it: what finds no room is not said.
    pub(super) fn offer_help(&mut self, number: u32, named: u32, now: Time) {
        let (nodes, here) = (u64::from(self.settings.placement.nodes), u64::from(self.here.0));
        let count = match self.settings.shadow {
            ShadowPolicy::Keep => return,
            ShadowPolicy::Offer => 1,
            ShadowPolicy::Steal => ASKED,
        };
        if !self.is_idle() {
            return;
        }
        for i in 0..count {
            let node = match self.settings.shadow {
                ShadowPolicy::Offer => u64::from(named),
                _ => mix(here << 32 | u64::from(number) ^ i << 56).checked_rem(nodes).unwrap_or(0),
            };
            if node < nodes && node != here {
                self.push(NodeId(node as u16), &Message::Idle, now);
            }
        }
    }

    /// Whether it has no ray to trace, of its own or of others, and waits for none.
    pub(super) fn is_idle(&self) -> bool {
        self.free_len == self.rays.len() && self.fresh == 0 && self.parked == 0
    }

    /// Another node has nothing to do.
    pub(super) fn on_idle(&mut self, from: NodeId) {
        let known = from.0 < self.settings.placement.nodes && from != self.here;
        if known && self.settings.shadow != ShadowPolicy::Keep {
            self.helpers.add(from);
        } else {
            self.note_unasked();
        }
    }

    /// Gives the lights of a hit to a helper that has fewer of this node's hits than wait here: whether it did.
    ///
    /// The slot in which it waits for them is none of those in reserve (rule 7).
    pub(super) fn give_lights(&mut self, slot: &RaySlot, point: &W::Point) -> bool {
        let kept = self.settings.schedule.reserve(self.world.splits(0));
        if slot.ray.task() == Task::Lights || self.free_len <= kept {
            return false;
        }
        let waiting = self.fresh.saturating_add(self.parked);
        let most = waiting.checked_div(self.helpers.rays_per_hit as usize).unwrap_or(0);
        let Some(helper) = self.helper(most.saturating_add(self.ready.len()).min(HITS)) else {
            return false;
        };
        let Self { world, blocks, work, .. } = self;
        let mut lights = world.lights(point, None);
        let first = world.next_light(blocks, point, &mut lights, &mut Counts::default(), work);
        if !matches!(first, Some(Lit::By(_))) {
            return false;
        }
        let mut given = RaySlot::new(slot.ray.with_task(Task::Lights), slot.root, slot.since);
        given.best = slot.best;
        given.sent_to = helper;
        given.set_stage(Stage::Send);
        let Some(number) = self.take_slot(given) else { return false };
        self.enqueue(number);
        self.counts.lights_given = self.counts.lights_given.saturating_add(1);
        true
    }

    /// The helper that has the fewest hits of this node, if those are fewer than `most`.
    fn helper(&self, most: usize) -> Option<u16> {
        let helpers = self.helpers.nodes.iter().filter(|&&node| node != NOBODY);
        let hits = |node: u16| {
            let theirs = |slot: &&RaySlot| {
                matches!(slot.stage(), Stage::Send | Stage::Away)
                    && slot.ray.task() == Task::Lights
                    && slot.sent_to == node
            };
            self.rays.iter().filter(theirs).count()
        };
        let least = helpers.map(|&node| (hits(node), node)).min();
        least.filter(|&(hits, _)| hits < most).map(|(_, node)| node)
    }
}

const _: () = assert!(NOBODY == REFUSED);
