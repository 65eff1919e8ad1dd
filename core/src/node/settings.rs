use super::{Placement, Time};

/// A time limit is 2³ times what answers take on average.
const MARGIN: u8 = 3;
/// It is doubled at most this often: where packets are lost, and nobody is slow, each doubling more is waited for in vain.
const DOUBLINGS: u16 = 5;

/// What all nodes of a run share.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Settings {
    /// Which rays go where.
    pub schedule: Schedule,
    /// Who traces the shadow rays of a hit.
    pub shadow: ShadowPolicy,
    /// Where intersection points live.
    pub points: PointHome,
    /// Which node owns which block.
    pub placement: Placement,
    /// Refusals of a ray after which the node that sent it runs it itself.
    pub refusals: u8,
    /// How many blocks are fetched ahead for a bundle.
    pub prefetch: Prefetch,
    /// Which of the waiting rays goes on first.
    pub order: TaskOrder,
    /// First time limit of a request; doubled each time it passes \[ns\].
    pub patience: Time,
    /// Greatest age of a bundle of messages that waits for more \[ns\].
    pub bundle_age: Time,
    /// Nodes for each sub-master; 0 for none: all ask the host.
    pub group: u16,
    /// Routers of dead nodes outlive them and say so ([`Message::Gone`](crate::protocol::Message::Gone)). A block then counts as lost only when all its holders
    /// are known to be dead; otherwise after many requests without an answer.
    pub deaths_told: bool,
}

impl Settings {
    /// The time limit of a request that was made so often in vain, if answers have taken so long of late: `patience` at least, halved `haste` times.
    #[cfg_attr(not(feature = "bundles"), inline(never))]
    pub(super) fn limit(&self, haste: u8, took: Time, tries: u16) -> Time {
        let least = Time(self.patience.0 >> (haste & 63));
        least.max(took.doubled(MARGIN)).doubled(tries.min(DOUBLINGS) as u8)
    }
}

/// Which rays are demand driven (their blocks come to them), and which data parallel (they go to their blocks).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
pub enum Schedule {
    /// Camera and shadow rays fetch, specular rays migrate (the dissertation's).
    Hybrid,
    /// All rays fetch (Green & Paddon 1989).
    Demand,
    /// All rays migrate.
    Data,
}

/// What kind of ray a schedule is asked about.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum RayKind {
    /// From the camera.
    Camera,
    /// To a light.
    Shadow,
    /// Reflected or refracted.
    Specular,
}

impl Schedule {
    /// Whether a ray of this kind goes to the owner of its next block.
    #[must_use]
    pub const fn migrates(self, kind: RayKind) -> bool {
        match self {
            Self::Hybrid => matches!(kind, RayKind::Specular),
            Self::Demand => false,
            Self::Data => true,
        }
    }

    /// Slots that must stay free beside that of a ray, if paths may split so often from it on (rule 7): each split takes another,
    /// and so does each shadow ray that migrates.
    pub(super) fn reserve(self, splits: usize) -> usize {
        splits.saturating_add(usize::from(self.migrates(RayKind::Shadow)))
    }

    /// Whether a node of so many has visits to expect, if paths may split so often.
    pub(super) const fn expects_visits(self, nodes: u16, splits: usize) -> bool {
        let specular = splits > 0 && self.migrates(RayKind::Specular);
        nodes > 1 && (self.migrates(RayKind::Camera) || self.migrates(RayKind::Shadow) || specular)
    }
}

/// Who traces the shadow rays of a hit, where they are demand driven: any node can.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
pub enum ShadowPolicy {
    /// The node that has found the hit.
    Keep,
    /// Also nodes without work, which the master sends to those that still render.
    #[default]
    Offer,
    /// Also nodes without work, which ask others for some by chance.
    Steal,
}

/// Where an intersection point lives: its lights are asked and its children begin there, and what they bring comes back there.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
pub enum PointHome {
    /// With the node that has found it.
    #[default]
    Finder,
    /// With the owner of the block that its surface lies in, apart from points that would only pass on what one ray brings.
    Owner,
}

impl PointHome {
    /// Whether a node of so many may have to visit another to find its points a home.
    pub(super) const fn expects_visits(self, nodes: u16) -> bool {
        nodes > 1 && matches!(self, Self::Owner)
    }
}

/// How many blocks are fetched ahead for a bundle of shadow rays.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
pub enum Prefetch {
    /// All that its pyramid touches, up to [`MOST`](Self::MOST), as far as frames and requests are free.
    All,
    /// The nearest so many; 0: a block is fetched when a ray needs it.
    Nearest(u16),
}

impl Prefetch {
    /// Most blocks for one bundle.
    pub const MOST: u16 = 16;

    /// Most blocks.
    #[must_use]
    pub(super) const fn most(self) -> usize {
        match self {
            Self::Nearest(blocks) if blocks < Self::MOST => blocks as usize,
            Self::All | Self::Nearest(_) => Self::MOST as usize,
        }
    }
}

/// Which of the waiting rays goes on first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
pub enum TaskOrder {
    /// That of the path that was begun first: a few paths come to their end before others get far.
    Made,
    /// The one that could go on first: as blocks arrive.
    Ready,
}
