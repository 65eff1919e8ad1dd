use kiloray_core::node::Work;

use crate::NodeTime;

/// How long the operations of a node take on a machine \[ns\].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Profile {
    /// What it is called.
    pub name: &'static str,
    /// A tree node: eight boxes.
    pub node: f64,
    /// A leaf record: up to four triangles.
    pub leaf: f64,
    /// Entering a block.
    pub block: f64,
    /// Beginning, or going on with, a closest-hit ray.
    pub ray: f64,
    /// Beginning, or going on with, a shadow ray.
    pub shadow_ray: f64,
    /// Shading a hit.
    pub shading: f64,
    /// Making a shadow ray.
    pub light_sample: f64,
    /// Clipping a bundle.
    pub clip: f64,
    /// Handling a message, in or out.
    pub message: f64,
    /// Copying a byte.
    pub copy: f64,
    /// Checking a byte of a block.
    pub check: f64,
}

impl Profile {
    /// One core of a present-day PC.
    pub const PC: Self = Self {
        name: "pc",
        node: 10.0,
        leaf: 15.0,
        block: 20.0,
        ray: 100.0,
        shadow_ray: 60.0,
        shading: 150.0,
        light_sample: 60.0,
        clip: 500.0,
        message: 50.0,
        copy: 0.1,
        check: 0.5,
    };

    /// All profiles.
    pub const ALL: [Self; 1] = [Self::PC];

    /// The profile of this name.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|profile| profile.name == name)
    }

    /// The time of an amount of work, by what it is, for a node that is slower by a factor.
    pub(crate) fn time(&self, work: &Work, slow: f64) -> NodeTime {
        let ns = |terms: &[(u64, f64)]| {
            let sum: f64 = terms.iter().map(|&(count, each)| count as f64 * each).sum();
            (sum * slow).round() as u64
        };
        NodeTime {
            trace: ns(&[
                (work.nodes, self.node),
                (work.leaves, self.leaf),
                (work.blocks, self.block),
                (work.rays, self.ray),
                (work.shadow_rays, self.shadow_ray),
            ]),
            shade: ns(&[(work.shadings, self.shading), (work.light_samples, self.light_sample)]),
            clip: ns(&[(work.clips, self.clip)]),
            messages: ns(&[(work.messages, self.message)]),
            copies: ns(&[(work.copied, self.copy)]),
            checks: ns(&[(work.checked, self.check)]),
            ..NodeTime::default()
        }
    }
}
