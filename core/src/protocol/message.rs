use crate::network::{Channel, NodeId};
use crate::path::PathKey;
use crate::shade::{PackedHit, PathRay, Sum};
use crate::trace::Trail;
use bytemuck::{Pod, Zeroable};

/// Where an answer belongs: the slot that waits for it, and the name of the ray that it waits for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Pod, Zeroable)]
#[repr(C)]
pub struct ReturnAddress {
    node: u16,
    slot: u16,
    key: [u32; 2],
    sample: u32,
}

impl ReturnAddress {
    /// The address of a slot at a node that waits for the ray of this key.
    #[must_use]
    pub const fn new(node: NodeId, slot: u16, key: PathKey) -> Self {
        let halves = [key.path as u32, (key.path >> 32) as u32];
        Self { node: node.0, slot, key: halves, sample: key.sample }
    }

    /// The node that waits.
    #[must_use]
    pub const fn node(&self) -> NodeId {
        NodeId(self.node)
    }

    /// Its slot.
    #[must_use]
    pub const fn slot(&self) -> u16 {
        self.slot
    }

    /// The ray that it waits for.
    #[must_use]
    pub const fn key(&self) -> PathKey {
        let [low, high] = self.key;
        PathKey { path: (high as u64) << 32 | low as u64, sample: self.sample }
    }
}

/// A ray on its way from node to node: all that anyone needs to go on with it.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct RayMessage {
    /// Who waits for what it brings.
    pub reply: ReturnAddress,
    /// The ray and its path.
    pub ray: PathRay,
    /// What earlier parts of its path have brought, in steps of the picture's unit: added to the answer.
    pub sum: [[u32; 2]; 3],
    /// The best hit so far; of a shadow ray the optical depth.
    pub best: PackedHit,
    /// Where it is in the tree.
    pub trail: Trail,
}

impl RayMessage {
    /// Its length.
    pub const BYTES: usize = size_of::<Self>();

    /// A ray as it lies in a packet.
    #[must_use]
    pub fn read(bytes: &[u8; Self::BYTES]) -> Self {
        bytemuck::cast(*bytes)
    }

    /// As it is to lie in a packet.
    #[must_use]
    pub fn bytes(&self) -> &[u8; Self::BYTES] {
        bytemuck::cast_ref(self)
    }
}

/// A message.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Message<'a> {
    /// Asks an owner for a block.
    Fetch {
        /// The block.
        block: u32,
        /// All before it is there already \[bytes\].
        offset: u32,
        /// How often it was asked for before, modulo 256.
        request: u8,
    },
    /// A piece of a block.
    Part {
        /// The block.
        block: u32,
        /// Where the piece begins \[bytes\].
        offset: u32,
        /// Of the request that it answers: tells who has asked again whether the first was lost or is late.
        request: u8,
        /// The piece: a multiple of four bytes.
        bytes: &'a [u8],
    },
    /// Asks a master for tiles.
    Ask {
        /// How many grants this asker has had, those of no tile included: names this request, so that one that comes twice is answered the
        /// same way twice.
        number: u32,
        /// How many it can take.
        count: u32,
    },
    /// Tiles to render: a run of places in the picture's order of work.
    Grant {
        /// The number of the request that it answers; another is not waited for.
        number: u32,
        /// The first place.
        first: u32,
        /// How many; 0 for none now: then the first place is the number of a node that has work, if there is such a node.
        count: u32,
        /// When there are none: how long to wait before asking again \[µs\].
        wait: u32,
    },
    /// The sender has nothing to do, and would take some of the receiver's work.
    Idle,
    /// Sums of a run of pixels of a tile.
    Pixels {
        /// The tile, by its place in the order of work.
        tile: u32,
        /// The first pixel, row by row.
        first: u32,
        /// Bytes of a channel.
        width: u8,
        /// Sums, as [`pack`](super::pack) leaves them: three little-endian numbers each.
        sums: &'a [u8],
    },
    /// The host has all pixels of a tile.
    Accepted {
        /// The tile, by its place in the order of work.
        tile: u32,
    },
    /// No copy of a block answers.
    Lost {
        /// The block.
        block: u32,
    },
    /// A ray, as [`RayMessage::bytes`] gives it: it is far longer than all else, which would be moved as slowly as a ray.
    Ray(&'a [u8; RayMessage::BYTES]),
    /// What a ray and all that followed from it brought.
    Answer {
        /// Who waits.
        to: ReturnAddress,
        /// The light.
        sum: Sum,
    },
    /// A ray found no room.
    Refusal {
        /// Who waits.
        to: ReturnAddress,
    },
    /// A ray that came again is not done yet.
    AtWork {
        /// Who waits.
        to: ReturnAddress,
    },
    /// The node that was asked is dead: its router says so in its name.
    Gone,
    /// The host asks a node what it has done.
    Tell,
    /// What a node has done.
    Told {
        /// The bytes of [`Figures`](crate::node::Figures).
        figures: &'a [u8],
    },
}

impl Message<'_> {
    /// Its channel.
    #[must_use]
    pub const fn channel(&self) -> Channel {
        match self {
            Self::Fetch { .. }
            | Self::Ask { .. }
            | Self::Idle
            | Self::Pixels { .. }
            | Self::Lost { .. }
            | Self::Ray(_)
            | Self::Tell => Channel::Request,
            Self::Part { .. }
            | Self::Grant { .. }
            | Self::Accepted { .. }
            | Self::Answer { .. }
            | Self::Refusal { .. }
            | Self::AtWork { .. }
            | Self::Gone
            | Self::Told { .. } => Channel::Reply,
        }
    }

    /// Its urgency: the least goes first (dissertation, table 4.2).
    #[must_use]
    pub const fn priority(&self) -> u8 {
        match self {
            Self::Fetch { .. } | Self::Lost { .. } | Self::Gone => 1,
            Self::Part { .. } => 2,
            Self::Ask { .. }
            | Self::Idle
            | Self::Grant { .. }
            | Self::Pixels { .. }
            | Self::Accepted { .. }
            | Self::Tell
            | Self::Told { .. } => 3,
            Self::Ray(_) | Self::Answer { .. } | Self::Refusal { .. } | Self::AtWork { .. } => 4,
        }
    }
}
