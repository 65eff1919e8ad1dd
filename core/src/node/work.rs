use core::ops::AddAssign;

use bytemuck::{Pod, Zeroable};

use crate::tally::tally;

/// A moment of a node's clock, since its start, or a length of time \[ns\].
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default, Pod, Zeroable)]
#[repr(transparent)]
pub struct Time(pub u64);

impl Time {
    /// No moment at all.
    pub const NEVER: Self = Self(u64::MAX);

    /// Later by so much.
    #[must_use]
    pub const fn after(self, by: Self) -> Self {
        Self(self.0.saturating_add(by.0))
    }

    /// So often doubled.
    #[must_use]
    pub(super) const fn doubled(self, times: u8) -> Self {
        Self(self.0.saturating_mul(1 << (times & 31)))
    }

    /// In ticks of 2¹⁰ ns, as slots keep it; wraps.
    pub(super) const fn ticks(self) -> u32 {
        (self.0 >> TICK) as u32
    }

    /// A time limit in ticks: at least one, and no more than can be told from one that has passed.
    #[cfg_attr(not(feature = "bundles"), inline(never))]
    pub(super) const fn limit_ticks(self) -> u32 {
        match (self.0 >> TICK) as u32 {
            _ if self.0 >> (TICK + 30) > 0 => LIMIT_MAX,
            0 => 1,
            ticks => ticks,
        }
    }

    /// So many ticks.
    pub(super) const fn of_ticks(ticks: u32) -> Self {
        Self((ticks as u64) << TICK)
    }

    /// Ticks since a moment in ticks.
    pub(super) const fn ticks_since(self, ticks: u32) -> u32 {
        self.ticks().wrapping_sub(ticks)
    }

    /// The time since a moment in ticks.
    pub(super) const fn since(self, ticks: u32) -> Self {
        Self::of_ticks(self.ticks_since(ticks))
    }
}

/// A tick is 2 to this power \[ns\].
const TICK: u32 = 10;
/// The longest time limit, 18 minutes \[ticks\].
pub(super) const LIMIT_MAX: u32 = u32::MAX / 4;

/// Operations that a node has carried out, in one step or in all (`u64`): what a machine profile turns into time.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Work<N = u32> {
    /// Tree nodes visited: eight box tests each.
    pub nodes: N,
    /// Leaf records tested: up to four triangles each.
    pub leaves: N,
    /// Blocks entered by a ray.
    pub blocks: N,
    /// Closest-hit rays begun or gone on with.
    pub rays: N,
    /// Shadow rays begun or gone on with.
    pub shadow_rays: N,
    /// Rays begun together.
    pub bundle_rays: N,
    /// Tree nodes visited by rays together, each once for all of them.
    pub bundle_nodes: N,
    /// Tests of eight rays against a box.
    pub bundle_boxes: N,
    /// Tests of a ray among others against eight boxes.
    pub bundle_ray_boxes: N,
    /// Tests of eight rays against a triangle.
    pub bundle_triangles: N,
    /// Tests of a ray among others against the triangles of a record.
    pub bundle_ray_triangles: N,
    /// Hits shaded: their material, children and choice of lights.
    pub shadings: N,
    /// Hits whose shading was interrupted for lack of room, and has gone on: their surfaces and materials are found anew.
    pub shadings_again: N,
    /// Lights that were asked: each a bundle of shadow rays.
    pub lights: N,
    /// Shadow rays made: places on lights and their weights. Those that are made again for the rest of an interrupted bundle count again.
    pub light_samples: N,
    /// Bundles of shadow rays clipped against the tree, to prefetch or to skip them.
    pub clips: N,
    /// Messages handled, in and out.
    pub messages: N,
    /// Bytes copied, of messages and blocks.
    pub copied: N,
    /// Bytes of arrived blocks checked.
    pub checked: N,
}

impl<N: Copy + Into<u64>> AddAssign<Work<N>> for Work<u64> {
    fn add_assign(&mut self, more: Work<N>) {
        tally!(self, &more, Work {
            sum nodes, leaves, blocks, rays, shadow_rays, bundle_rays, bundle_nodes, bundle_boxes,
                bundle_ray_boxes, bundle_triangles, bundle_ray_triangles, shadings, shadings_again,
                lights, light_samples, clips, messages, copied, checked;
        });
    }
}

/// What a step of a node was, and when the next may be.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Progress {
    /// What it did.
    pub work: Work,
    /// When to call again.
    pub next: Next,
}

/// When a node can go on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Next {
    /// At once: it has work.
    Now,
    /// When a packet arrives or leaves, or at this moment at the latest.
    Wait {
        /// A deadline; [`Time::NEVER`] for none.
        until: Time,
        /// For what.
        lack: Lack,
    },
}

/// What an idle node waits for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Lack {
    /// Blocks that were requested.
    Data,
    /// Answers to rays that were sent.
    Answers,
    /// An answer of the master, or of the host.
    Master,
    /// Tiles: there are none.
    Tiles,
    /// Room in buffers to send.
    Credit,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_time_limit_is_never_shorter_than_it_is() {
        let ticks = |ns| Time(ns).limit_ticks();
        assert_eq!((ticks(0), ticks(1023), ticks(2048)), (1, 1, 2));
        // As ticks alone, this would be one of a microsecond.
        assert_eq!((Time(1 << 42 | 1 << TICK).ticks(), ticks(1 << 42 | 1 << TICK)), (1, LIMIT_MAX));
        assert_eq!(ticks(u64::MAX), LIMIT_MAX);
    }
}
