use crate::network::NodeId;
use crate::path::PathKey;
use crate::protocol::ReturnAddress;
use crate::shade::{PackedHit, PathRay, Sum, Task};
use crate::trace::Trail;
use bytemuck::{Pod, Zeroable};

/// What becomes of a ray slot next.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub(super) enum Stage {
    Free = 0,
    /// To be traced.
    Trace = 1,
    /// Waits for a block to arrive.
    Blocked = 2,
    /// To be sent to another node.
    Send = 3,
    /// Another node runs it; this is what it is made again from.
    Away = 4,
    /// Its hit is to be shaded: lights are asked.
    Shade = 5,
    /// Its second child needs a slot.
    Split = 6,
}

/// A ray under way: the path's own memory from its start to its end.
///
/// The first child of a hit takes over the slot, the second takes another one. While the ray is away the slot is what it is
/// made again from, and what it is run in if nobody else can.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(super) struct RaySlot {
    pub(super) ray: PathRay,
    /// The best hit so far; of a shadow ray the optical depth.
    pub(super) best: PackedHit,
    /// While it is traced where it is in the tree; while it is shaded where it is among the lights.
    pub(super) at: [u32; 8],
    pub(super) root: u16,
    stage: u8,
    /// Runs here whatever the schedule says.
    pub(super) home: u8,
    pub(super) refusals: u8,
    pub(super) tries: u8,
    /// Of an away ray: the node it was sent to; of lights that are to be sent: the helper.
    pub(super) sent_to: u16,
    /// Of an away ray: when it was sent, in ticks. Of any other the number of its path, in the order in which they were begun.
    pub(super) since: u32,
    /// Of an away ray: how long it is given, in ticks.
    pub(super) limit: u32,
}

impl RaySlot {
    /// A ray of path `number`.
    pub(super) fn new(ray: PathRay, root: u16, number: u32) -> Self {
        let slot = Self { ray, root, stage: Stage::Trace as u8, since: number, ..Self::zeroed() };
        slot.at_trail(&Trail::START)
    }

    pub(super) fn at_trail(mut self, trail: &Trail) -> Self {
        self.set_trail(trail);
        self
    }

    pub(super) fn stage(&self) -> Stage {
        match self.stage {
            1 => Stage::Trace,
            2 => Stage::Blocked,
            3 => Stage::Send,
            4 => Stage::Away,
            5 => Stage::Shade,
            6 => Stage::Split,
            _ => Stage::Free,
        }
    }

    pub(super) fn set_stage(&mut self, stage: Stage) {
        self.stage = stage as u8;
    }

    /// The name by which its answer is known. The lights of a hit have another than the ray, which may have been in this slot before; what a
    /// hit brings is what its ray brings, so that an answer to either is right (rule 14).
    pub(super) fn name(&self) -> PathKey {
        let key = self.ray.key();
        if self.ray.task() == Task::Lights { key.child(LIGHTS) } else { key }
    }

    /// No other node shall run it.
    pub(super) fn run_at_home(&mut self) {
        self.home = 1;
        self.set_stage(match self.ray.task() {
            Task::Lights | Task::Hit => Stage::Shade,
            Task::Path | Task::Shadow => Stage::Trace,
        });
    }

    pub(super) fn trail(&self) -> Trail {
        let [a, b, c, d, e, ..] = self.at;
        bytemuck::cast([a, b, c, d, e])
    }

    pub(super) fn set_trail(&mut self, trail: &Trail) {
        let [a, b, c, d, e]: [u32; 5] = bytemuck::cast(*trail);
        self.at = [a, b, c, d, e, 0, 0, 0];
    }
}

/// Behind the children of a point in the order of names: two rays.
const LIGHTS: u32 = 2;

/// Where a shadow ray goes on, and what it has come through. It lies apart from the ray: most rays end where they begin.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(super) struct Onward {
    pub(super) trail: Trail,
    pub(super) depth: [u32; 3],
}

impl Onward {
    /// Of a ray at its beginning.
    pub(super) const START: Self = Self { trail: Trail::START, depth: [0; 3] };
}

/// What waits for rays to end: a tile that is rendered here, or the visit of a ray of another node.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(super) struct Root {
    /// What a visit has brought so far. (The sums of a tile lie apart.)
    pub(super) sum: Sum,
    /// Of a tile: when its time limit passes \[ns\].
    pub(super) deadline: u64,
    /// Rays and shadow rays that have not ended.
    pub(super) open: u32,
    /// Of a visit: who waits for it.
    pub(super) to: ReturnAddress,
    /// Of a tile: its place in the order of work.
    pub(super) tile: u32,
    /// Of a tile: the camera ray that comes next.
    pub(super) camera: [u32; 3],
    /// Of a tile: pixels sent.
    pub(super) sent: u32,
    state: u8,
    pub(super) tries: u8,
    /// Of a tile: bytes of a channel of its sums, once they are packed; else 0.
    pub(super) width: u8,
    pub(super) _zero: [u8; 5],
}

/// What a root is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub(super) enum RootState {
    Free = 0,
    /// A tile with camera rays to come.
    Opening = 1,
    /// A tile all of whose camera rays are under way or done.
    Rendering = 2,
    /// A tile whose sums are being sent.
    Sending = 3,
    /// A tile whose sums the host has not acknowledged.
    Sent = 4,
    /// A visit.
    Visit = 5,
    /// A visit that has ended and is to be answered.
    Answering = 6,
}

impl Root {
    pub(super) fn state(&self) -> RootState {
        match self.state {
            1 => RootState::Opening,
            2 => RootState::Rendering,
            3 => RootState::Sending,
            4 => RootState::Sent,
            5 => RootState::Visit,
            6 => RootState::Answering,
            _ => RootState::Free,
        }
    }

    pub(super) fn set_state(&mut self, state: RootState) {
        self.state = state as u8;
    }

    pub(super) fn is_visit(&self) -> bool {
        matches!(self.state(), RootState::Visit | RootState::Answering)
    }
}

/// A block that another node has asked for.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(super) struct Serve {
    pub(super) block: u32,
    pub(super) offset: u32,
    pub(super) to: u16,
    /// See [`Message::Fetch`](crate::protocol::Message::Fetch).
    pub(super) request: u8,
    pub(super) _zero: u8,
}

/// A block that was requested.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(super) struct FetchSlot {
    /// Pieces that are there, a bit each.
    pub(super) pieces: [u32; FetchSlot::PIECES / 32],
    pub(super) block: u32,
    /// When it was asked for last, in units of 2¹⁰ ns.
    pub(super) begun: u32,
    pub(super) deadline: u64,
    pub(super) asked: u16,
    /// Requests without any piece since.
    pub(super) tries: u16,
    /// [`FREE`](Self::FREE), [`TO_BE_SENT`](Self::TO_BE_SENT), [`SENT`](Self::SENT) or [`COMPLETE`](Self::COMPLETE).
    pub(super) state: u8,
    /// How often it was asked for before, modulo 256.
    pub(super) request: u8,
    /// Holders that are dead, by their routers: a bit for each of the first copies.
    pub(super) gone: u16,
}

impl FetchSlot {
    /// Pieces of a block, at most.
    pub(super) const PIECES: usize = 128;
    /// It stands for no block.
    pub(super) const FREE: u8 = 0;
    /// Its request has not left yet.
    pub(super) const TO_BE_SENT: u8 = 1;
    /// Its request is under way, or its answer.
    pub(super) const SENT: u8 = 2;
    /// All pieces are there, and are to be checked.
    pub(super) const COMPLETE: u8 = 3;

    pub(super) fn is_free(&self) -> bool {
        self.state == Self::FREE
    }

    pub(super) fn is_complete(&self) -> bool {
        self.state == Self::COMPLETE
    }

    /// Whether it is for this block.
    pub(super) fn is_for(&self, block: u32) -> bool {
        !self.is_free() && self.block == block
    }

    pub(super) fn asked(&self) -> NodeId {
        NodeId(self.asked)
    }

    /// Notes a piece: whether it is new.
    pub(super) fn note(&mut self, piece: usize) -> bool {
        let Some(word) = self.pieces.get_mut(piece / 32) else { return false };
        let bit = 1 << (piece % 32);
        let new = *word & bit == 0;
        *word |= bit;
        new
    }

    /// The first piece that is not there.
    pub(super) fn first_missing(&self) -> usize {
        let full = self.pieces.iter().take_while(|&&word| word == u32::MAX).count();
        let rest = self.pieces.get(full).map_or(0, |word| word.trailing_ones() as usize);
        full.saturating_mul(32).saturating_add(rest)
    }
}
