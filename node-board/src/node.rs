//! The picture by a mesh of one node, and the host beside it.

use kiloray_core::block::KiloView;
use kiloray_core::network::{HOST, Mesh, NodeId, PacketHeader, Port, Router, RouterSize, Topology};
use kiloray_core::node::{
    Dealing, Next, Node, NodeNeeds, NodePlan, Picture, Placement, PointHome, Prefetch, Progress,
    Rom, Schedule, Settings, ShadowPolicy, TaskOrder, Time,
};
use kiloray_core::render::Tiling;
use kiloray_core::store::{Arena, Chunk};
use kiloray_core::trace::Scalar;

use crate::host::Host;
use crate::picture::{Done, PictureError, Pixels, SIZE, camera, shader};

/// Pixels along a tile.
const SIDE: u32 = 8;
const SCHEDULE: Schedule = Schedule::Hybrid;
/// What the host and the link take beside the node's arena.
pub(crate) const BESIDE_BYTES: usize = 2 << 10;

const ONE: Topology = Topology::Full { nodes: 1 };
const HERE: NodeId = NodeId(0);
/// The host's end of the link between them.
const ENTRY: Port = Port(0);

/// The actor.
pub(crate) type Actor<'a> = Node<'a, Picture<'a, Scalar>>;

/// Renders in the arena, behind what lies beside it, and writes the pixels.
#[cfg_attr(feature = "measure", allow(dead_code))]
pub(crate) fn render(
    file: &KiloView<'_>,
    memory: &mut [Chunk],
    pixels: &mut Pixels,
) -> Result<Done, PictureError> {
    render_by(file, memory, pixels, |node| node.poll(Time(0)))
}

/// The same, with each step of the actor taken by `step`.
pub(crate) fn render_by(
    file: &KiloView<'_>,
    memory: &mut [Chunk],
    pixels: &mut Pixels,
    mut step: impl FnMut(&mut Actor<'_>) -> Progress,
) -> Result<Done, PictureError> {
    let (beside, memory) = memory.split_at_mut(BESIDE_BYTES / size_of::<Chunk>());
    let mesh = Mesh::new(ONE);
    let tiling = Tiling::new(SIZE, SIZE, SIDE);
    let plan = plan(file, mesh, size_of_val(memory))?;
    // Used where it was made: moved, it would lie on the stack twice.
    let mut made = node(file, mesh, tiling, &plan, memory);
    let node = made.as_mut().map_err(|error| *error)?;
    let mut beside = Arena::new(beside);
    let packet = beside.carve(PacketHeader::BYTES + plan.payload()).map_err(PictureError::Arena)?;
    let size = RouterSize::new(&mesh, HOST, plan.router.depth, plan.router.payload);
    let mut host = Host::new(&mut beside, mesh, size, shader(file), tiling, pixels)
        .map_err(PictureError::Arena)?;
    let exit = mesh.reverse(HOST, ENTRY).unwrap_or(ENTRY);
    while !host.is_complete() {
        let next = step(node).next;
        let out = carry((node.router(), exit), (host.router(), ENTRY), packet);
        host.poll();
        let back = carry((host.router(), ENTRY), (node.router(), exit), packet);
        if host.has_failed() || next != Next::Now && !out && !back {
            return Err(PictureError::Render("the node and its host do not go on"));
        }
    }
    Ok(Done { counts: node.counts().shade, budget: node.budget() })
}

/// The arena, with all blocks in flash.
fn plan(file: &KiloView<'_>, mesh: Mesh, bytes: usize) -> Result<NodePlan, PictureError> {
    let needs = NodeNeeds {
        mesh,
        here: HERE,
        block_bytes: file.limits().block_bytes,
        remote: 0,
        owned: 0,
        splits: shader(file).splits(0),
        schedule: SCHEDULE,
        shadow: ShadowPolicy::Keep,
        points: PointHome::Finder,
        group: 0,
        side: SIDE as usize,
        // Tiles are all that is said: the least does.
        packet: 256,
        depth: 1,
        host_depth: 0,
    };
    NodePlan::new(bytes, &needs).map_err(PictureError::Memory)
}

/// The node, with all blocks. Not inlined, so that what it is made of does not stay on the stack.
#[inline(never)]
fn node<'a>(
    file: &KiloView<'a>,
    mesh: Mesh,
    tiling: Tiling,
    plan: &NodePlan,
    memory: &'a mut [Chunk],
) -> Result<Actor<'a>, PictureError> {
    let limits = file.limits();
    let settings = Settings {
        schedule: SCHEDULE,
        shadow: ShadowPolicy::Keep,
        points: PointHome::Finder,
        placement: Placement {
            dealing: Dealing::Subtrees,
            blocks: file.blocks(),
            nodes: mesh.nodes(),
            top: 0,
            replicas: 1,
        },
        refusals: 1,
        prefetch: Prefetch::Nearest(0),
        order: TaskOrder::Made,
        // Nothing is lost on its way through memory: there is no clock, and no time limit ever passes.
        patience: Time(1),
        bundle_age: Time(1),
        group: 0,
        deaths_told: false,
    };
    let budget = plan.budget(size_of_val(memory)).map_err(PictureError::Memory)?;
    let rom = Rom::of_file(file.block_section(), limits.block_bytes, settings.placement, HERE);
    let world = Picture::new(Scalar, shader(file), camera(file)?, tiling, limits);
    Node::new(&mut Arena::new(memory), plan, budget, settings, rom, mesh, world)
        .map_err(PictureError::Arena)
}

/// Carries all packets that may leave over a link: whether there was any.
fn carry(
    (from, leave): (&mut Router<'_>, Port),
    (to, enter): (&mut Router<'_>, Port),
    packet: &mut [u8],
) -> bool {
    let mut any = false;
    while let Some(len) = from.transmit(leave, packet) {
        to.receive(enter, packet.get(..len).unwrap_or_default(), |_| false);
        any = true;
    }
    any
}
