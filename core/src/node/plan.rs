use super::group::{Group, Member};
use super::outbox::Open;
use super::slots::{FetchSlot, Onward, RaySlot, Root, Serve};
use super::{PointHome, RayKind, Schedule, ShadowPolicy};
use crate::network::{Channel, Mesh, NodeId, RouterSize};
use crate::protocol::Item;
use crate::render::Tiling;
use crate::shade::{Shadow, Sum};
use crate::store::{
    Arena, Budget, BudgetError, Line, LineBudget, frame_bytes, frame_table_bytes, frames_that_fit,
};

/// How the memory of a node of a mesh is divided: the lengths of all lines.
///
/// Each line has a least length with which everything works, one ray at a time. What memory there is beyond it is divided between rays under
/// way and block frames: the rays are doubled as long as frames keep half of it, and get the rest.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct NodePlan {
    /// Buffers of the links.
    pub router: RouterSize,
    /// Open bundles of messages.
    pub bundles: usize,
    /// Rays under way.
    pub rays: usize,
    /// Shadow rays that wait; 0 where each is a ray of its own.
    pub shadows: usize,
    /// Tiles in work.
    pub tiles: usize,
    /// Rays of other nodes.
    pub visits: usize,
    /// Pixels along a tile.
    pub side: usize,
    /// Blocks that can be asked for at once.
    pub fetches: usize,
    /// Blocks that others can ask for before their requests wait in links.
    pub serves: usize,
    /// Nodes that it gives tiles to, as their sub-master.
    pub members: usize,
    /// Block frames.
    pub frames: usize,
    /// Bytes of a block.
    pub block_bytes: usize,
    /// Bytes of its share of the scene that lie in the arena rather than in read-only memory.
    pub owned: usize,
}

/// What of a run decides about a node's memory.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct NodeNeeds {
    /// Where it is.
    pub mesh: Mesh,
    /// See `mesh`.
    pub here: NodeId,
    /// Bytes of a block.
    pub block_bytes: usize,
    /// Blocks that it has to fetch when it needs them.
    pub remote: usize,
    /// Bytes of its share of the scene, blocks and [tables](crate::shade::Tables::arena_bytes), that shall lie in the arena: whole chunks.
    pub owned: usize,
    /// How often a path may split, at most: `0` where no surface is specular.
    pub splits: usize,
    /// Which rays go where.
    pub schedule: Schedule,
    /// Who traces shadow rays.
    pub shadow: ShadowPolicy,
    /// Where intersection points live.
    pub points: PointHome,
    /// Nodes for each sub-master; 0 for none.
    pub group: u16,
    /// Pixels along a tile.
    pub side: usize,
    /// Greatest payload of a packet \[bytes\], the same at all nodes of a mesh; 0 for the default: a block, or a half, a quarter and so on of one, as the
    /// memory of this node allows.
    pub packet: usize,
    /// Packets in each buffer; 0 for the default.
    pub depth: u16,
    /// Packets in each buffer at the host's end of a link; 0: as many as at nodes, and so in any case without the feature
    /// `bundles`.
    pub host_depth: u16,
}

/// Least and greatest payload of a packet: a ray must fit, and a length 16 bits.
pub(super) const PAYLOAD_MIN: usize = 256;
pub(super) const PAYLOAD_MAX: usize = 16 << 10;
/// Buffers of links with more than one packet each take an eighth of the memory at most; where packets are long two sevenths, since
/// one that waits then keeps others waiting for long. Where the length of packets is ours to choose, buffers of one packet each take as
/// much at most. (64 nodes of 64, 128 and 256 KiB, a torus, blocks of 4 KiB: a picture of `colour-cube:36` takes 0.39, 0.35 and 0.70 of the time that it
/// took with a 256th of the memory for a packet, `conference:40` 0.40, 0.35 and 0.68.)
const MESSAGES_PART: usize = 8;
const LONG_PART: [usize; 2] = [2, 7];
/// Packets of the node's own a 32nd, beyond two.
const OWN_PART: usize = 32;

/// How much is under way at a time.
struct Step {
    /// Of what the links' buffers leave, frames get at least so many [`TWELFTHS`], or as many as there are blocks.
    frames: usize,
    rays: usize,
    /// Shadow rays that wait: many at a time go to the same light through the same blocks.
    shadows: usize,
    /// Packets of the node's own: what a step makes leaves while the next is taken.
    own: u16,
    bundles: usize,
    tiles: usize,
}

/// What a node may have under way beyond the least, in the order in which memory is spent on it: rays first, as one that waits
/// for a block leaves a node idle, then shadow rays. More rays yet want more blocks at a time than they hide latency.
const STEPS: [Step; 8] = [
    Step { frames: 8, rays: 4, shadows: 8, own: 2, bundles: 2, tiles: 1 },
    Step { frames: 8, rays: 8, shadows: 32, own: 4, bundles: 3, tiles: 1 },
    Step { frames: 7, rays: 8, shadows: 64, own: 4, bundles: 3, tiles: 1 },
    Step { frames: 7, rays: 8, shadows: 128, own: 4, bundles: 3, tiles: 1 },
    Step { frames: 8, rays: 12, shadows: 384, own: 8, bundles: 3, tiles: 2 },
    Step { frames: 9, rays: 32, shadows: 512, own: 16, bundles: 5, tiles: 3 },
    Step { frames: 9, rays: 64, shadows: 1024, own: 16, bundles: 6, tiles: 3 },
    Step { frames: 9, rays: 128, shadows: 2048, own: 16, bundles: 7, tiles: 3 },
];
const TWELFTHS: usize = 12;
/// One ray at a time.
const LEAST: Step = Step { frames: 0, rays: 1, shadows: 1, own: 1, bundles: 2, tiles: 1 };
/// Blocks on their way take an eighth of the frames at most, or they would push out those in use; and no more than hide the latency of links, as what
/// is asked for by all at once queues at its owners: 8 are quicker than 12 from 1 to 100 µs.
const FETCHES_PART: usize = 8;
const FETCHES_MAX: usize = 8;

const _: () = assert!(Item::RAY_BYTES <= PAYLOAD_MIN);

impl NodePlan {
    /// Divides `memory` bytes.
    ///
    /// # Errors
    /// [`BudgetError`] if even single rays do not fit: then what each line needs at least.
    pub fn new(memory: usize, needs: &NodeNeeds) -> Result<Self, BudgetError> {
        let least = Self::of(&LEAST, memory, needs);
        least.budget(memory)?;
        let mut best = least;
        for step in &STEPS {
            let plan = Self::of(step, memory, needs);
            let all = frame_bytes(needs.remote, needs.block_bytes);
            let rest = memory.saturating_sub(plan.bytes());
            let wanted = memory.saturating_sub(plan.router.bytes()) / TWELFTHS;
            if plan.bytes() > memory || rest < wanted.saturating_mul(step.frames).min(all) {
                break;
            }
            best = plan;
        }
        let left = memory.saturating_sub(best.with_frames(0).bytes());
        let frames = frames_that_fit(left, best.block_bytes).min(needs.remote).max(best.frames);
        let mut plan = best.with_frames(frames);
        plan.fetches = plan.fetches.min((frames / FETCHES_PART).max(usize::from(frames > 0)));
        Ok(plan)
    }

    /// The least lengths with which everything works.
    #[must_use]
    pub fn least(needs: &NodeNeeds) -> Self {
        Self::of(&LEAST, 0, needs)
    }

    /// The payload of packets for a memory, where none is asked for: a whole block, or half of one, a quarter and so on, so that buffers of one
    /// packet each take [`LONG_PART`] of it at most.
    fn packet(memory: usize, needs: &NodeNeeds) -> usize {
        let least = Self::packet_min(needs.block_bytes);
        let pieces = (0..usize::BITS).map_while(|n| needs.block_bytes.checked_shr(n));
        let payloads = pieces.map(|piece| {
            let payload = piece.saturating_add(Item::PART_BYTES).next_multiple_of(64);
            payload.min(PAYLOAD_MAX)
        });
        let most = part(LONG_PART, memory.saturating_sub(needs.owned));
        let fits = |payload: &usize| {
            let one = Self::with_payload(&LEAST, memory, needs, *payload);
            let widest = RouterSize::new(&needs.mesh, NodeId(0), 1, *payload as u16);
            widest.bytes() <= most && one.bytes() <= memory
        };
        let payloads = payloads.take_while(|&payload| payload > least);
        payloads.into_iter().find(fits).unwrap_or(least)
    }

    /// The least payload: a ray fits, and a block has no more pieces than can be counted.
    #[must_use]
    pub fn packet_min(block_bytes: usize) -> usize {
        let piece = block_bytes.div_ceil(FetchSlot::PIECES).saturating_add(Item::PART_BYTES);
        piece.next_multiple_of(64).clamp(PAYLOAD_MIN, PAYLOAD_MAX)
    }

    fn of(step: &Step, memory: usize, needs: &NodeNeeds) -> Self {
        let payload = match needs.packet {
            0 => Self::packet(memory, needs),
            bytes => bytes.clamp(Self::packet_min(needs.block_bytes), PAYLOAD_MAX),
        };
        Self::with_payload(step, memory, needs, payload)
    }

    fn with_payload(step: &Step, memory: usize, needs: &NodeNeeds, payload: usize) -> Self {
        let shadows_migrate = needs.schedule.migrates(RayKind::Shadow);
        let nodes = needs.mesh.nodes();
        let helps = needs.shadow != ShadowPolicy::Keep && nodes > 1 && !shadows_migrate;
        let visited = helps
            || needs.schedule.expects_visits(nodes, needs.splits)
            || needs.points.expects_visits(nodes);
        let least = needs.schedule.reserve(needs.splits).saturating_add(1);
        let rays = step.rays.max(least);
        let router = |here, depth| {
            let size = RouterSize::new(&needs.mesh, here, depth, payload as u16);
            // Boards' hosts are as deep as they are: it would take flash.
            if cfg!(feature = "bundles") {
                size.with_host(&needs.mesh, here, needs.host_depth)
            } else {
                size
            }
        };
        // Two packets keep a link busy; four are of use where they cost little. Both ends of a link must agree: the node that the host
        // is joined to has the most ports.
        let fits = |depth: &u16| {
            let size = router(NodeId(0), *depth);
            let long = size.payload_of(Channel::Request) < size.payload_of(Channel::Reply);
            size.bytes() <= if long { part(LONG_PART, memory) } else { memory / MESSAGES_PART }
        };
        let depth = match needs.depth {
            0 => [4, 2].into_iter().find(fits).unwrap_or(1),
            depth => depth,
        };
        let router = router(needs.here, depth);
        let own = (memory / OWN_PART).checked_div(payload).unwrap_or(0).clamp(2, 255) as u16;
        let remote = usize::from(needs.remote > 0);
        Self {
            router: router.with_own(own.min(step.own)),
            bundles: step.bundles,
            rays,
            shadows: if shadows_migrate { 0 } else { step.shadows },
            tiles: step.tiles,
            visits: if visited { (rays / 2).max(1) } else { 0 },
            side: needs.side.clamp(1, Tiling::SIDE_MAX as usize),
            fetches: remote.saturating_mul(step.rays.min(FETCHES_MAX)),
            serves: step.rays,
            members: Group::len_at(needs.here, needs.group, nodes),
            frames: remote,
            block_bytes: needs.block_bytes,
            owned: needs.owned,
        }
    }

    fn with_frames(self, frames: usize) -> Self {
        Self { frames, ..self }
    }

    /// Greatest payload of a packet \[bytes\].
    #[must_use]
    pub const fn payload(&self) -> usize {
        self.router.payload as usize
    }

    /// Bytes of a block in a packet: a multiple of four.
    #[must_use]
    pub const fn piece(&self) -> usize {
        self.payload().saturating_sub(Item::PART_BYTES) / 4 * 4
    }

    /// Pixels of a tile.
    #[must_use]
    pub const fn pixels(&self) -> usize {
        self.side.saturating_mul(self.side)
    }

    /// Bytes of all lines.
    #[must_use]
    pub fn bytes(&self) -> usize {
        self.lines().iter().fold(0, |sum, line| sum.saturating_add(line.bytes))
    }

    /// The plan, line by line.
    ///
    /// # Errors
    /// [`BudgetError`] if it takes more than `memory` bytes.
    pub fn budget(&self, memory: usize) -> Result<Budget, BudgetError> {
        Budget::new(memory, &self.lines())
    }

    fn lines(&self) -> [LineBudget; 8] {
        let sum = |parts: &[usize]| parts.iter().fold(0_usize, |sum, &p| sum.saturating_add(p));
        let rays = sum(&[
            Arena::bytes_of::<RaySlot>(self.rays),
            Arena::bytes_of::<u16>(self.rays).saturating_mul(2),
        ]);
        let roots = Arena::bytes_of::<Root>(self.tiles.saturating_add(self.visits));
        // And the inbox.
        let packets = self.router.packets().saturating_add(self.bundles).saturating_add(1);
        let messages = sum(&[
            self.router.arena_bytes(),
            Arena::bytes_of::<Open>(self.bundles),
            Arena::bytes_of::<u8>(self.bundles.saturating_mul(self.payload())),
            Arena::bytes_of::<u8>(usize::from(self.router.payload_of(Channel::Request))),
            Arena::bytes_of::<Serve>(self.serves),
            Arena::bytes_of::<Member>(self.members),
        ]);
        let fetches = Arena::bytes_of::<FetchSlot>(self.fetches);
        let table = sum(&[frame_table_bytes(self.frames), fetches]);
        let pixels = self.tiles.saturating_mul(self.pixels());
        let frames = self.block_bytes.saturating_mul(self.frames);
        [
            LineBudget::new(Line::Tables, self.owned, self.owned),
            LineBudget::new(Line::Points, self.visits, roots),
            LineBudget::new(Line::Rays, self.rays, rays),
            LineBudget::new(
                Line::Bundles,
                self.shadows,
                Arena::bytes_of::<Shadow>(self.shadows)
                    .saturating_add(Arena::bytes_of::<Onward>(self.shadows))
                    .saturating_add(Arena::bytes_of::<u32>(self.shadows)),
            ),
            LineBudget::new(Line::Messages, packets, messages),
            LineBudget::new(Line::Tile, self.tiles, Arena::bytes_of::<Sum>(pixels)),
            LineBudget::new(Line::FrameTable, self.frames, table),
            LineBudget::new(Line::Frames, self.frames, Arena::bytes_of::<u8>(frames)),
        ]
    }
}

/// A part of so many bytes.
const fn part([part, of]: [usize; 2], bytes: usize) -> usize {
    bytes.saturating_mul(part) / of
}
