use kiloray_core::block::KiloView;
use kiloray_core::network::{HOST, Mesh, NodeId, PacketHeader, RouterSize};
use kiloray_core::node::{NodeNeeds, NodePlan, Placement, Rom, Settings, Time};
use kiloray_core::shade::{Shader, Tables};
use kiloray_core::store::Budget;

use crate::{Error, Link, Options, Profile};

/// How a run is divided: blocks among nodes, the memory of each node, the picture into tiles.
#[derive(Debug)]
pub(crate) struct Layout {
    /// What all nodes share.
    pub(crate) settings: Settings,
    /// How the memory of each node is divided.
    pub(crate) plans: Vec<NodePlan>,
    /// The same, line by line.
    pub(crate) budgets: Vec<Budget>,
    block_bytes: usize,
}

/// Of the blocks every node has this part, those nearest to the root: more of it is read by most rays.
const TOP_PART: u32 = 64;
/// Tiles for each node, where the picture has so many pixels.
const TILES_PER_NODE: u32 = 16;
/// Greatest and least side of a tile.
const SIDES: [u32; 4] = [32, 16, 8, 4];
/// The part of the memory that the sums of a tile may take.
const TILE_PART: usize = 8;

impl Layout {
    /// Divides all.
    pub(crate) fn new(file: &KiloView<'_>, options: &Options, mesh: &Mesh) -> Result<Self, Error> {
        let nodes = mesh.nodes();
        let placement = Placement {
            dealing: options.dealing,
            blocks: file.blocks(),
            nodes,
            top: options.top.unwrap_or(file.blocks() / TOP_PART).max(1).min(file.blocks()),
            replicas: options.replicas,
        };
        let block_bytes = file.limits().block_bytes;
        let splits = Shader::new(Tables::of(file), options.settings).splits(0);
        let side = options.tile.map_or_else(|| side(options, nodes), u32::from).max(1);
        let mut plans = Vec::with_capacity(usize::from(nodes));
        let mut budgets = Vec::with_capacity(usize::from(nodes));
        for here in (0..nodes).map(NodeId) {
            let owned = placement.held(here) as usize;
            let needs = NodeNeeds {
                mesh: *mesh,
                here,
                block_bytes,
                remote: file.blocks() as usize - owned,
                owned: if options.owned_in_arena { owned } else { 0 },
                splits,
                schedule: options.schedule,
                side: side as usize,
                packet: usize::from(options.link.packet).saturating_sub(PacketHeader::BYTES),
                depth: 0,
            };
            let plan = NodePlan::new(options.memory, &needs)?;
            budgets.push(plan.budget(options.memory)?);
            plans.push(plan);
        }
        let packet = plans.first().map_or(0, NodePlan::payload) + PacketHeader::BYTES;
        let settings = Settings {
            schedule: options.schedule,
            placement,
            refusals: options.refusals,
            prefetch: options.prefetch,
            order: options.order,
            patience: patience(&options.link, &options.profile, packet, mesh),
            bundle_age: bundle_age(&options.link, packet),
            group: options.group,
        };
        Ok(Self { settings, plans, budgets, block_bytes })
    }

    /// Side of a tile.
    pub(crate) fn side(&self) -> u32 {
        self.plans.first().map_or(1, |plan| plan.side as u32)
    }

    /// Greatest packet, header included \[bytes\].
    pub(crate) fn packet(&self) -> u16 {
        let payload = self.plans.first().map_or(0, NodePlan::payload);
        (payload + PacketHeader::BYTES).min(usize::from(u16::MAX)) as u16
    }

    /// The blocks that a node reads in place.
    pub(crate) fn rom<'a>(&self, file: &KiloView<'a>, here: NodeId) -> Rom<'a> {
        Rom::of_file(file.block_section(), self.block_bytes, self.settings.placement, here)
    }

    /// How many blocks a node reads in place.
    pub(crate) fn owned(&self, here: NodeId) -> u32 {
        self.settings.placement.held(here)
    }

    /// The host's end of the network is as deep as the nodes'.
    pub(crate) fn host_router(&self, mesh: &Mesh) -> RouterSize {
        let (depth, payload) =
            self.plans.first().map_or((1, 1), |plan| (plan.router.depth, plan.router.payload));
        RouterSize::new(mesh, HOST, depth, payload)
    }

    /// Who asks the host for tiles.
    pub(crate) fn askers(&self) -> u32 {
        let nodes = self.plans.len() as u32;
        match self.settings.group {
            0 => nodes,
            group => nodes.div_ceil(u32::from(group)),
        }
    }
}

/// The greatest side with which every node has some tiles, and which the memory holds.
fn side(options: &Options, nodes: u16) -> u32 {
    let pixels = u64::from(options.width) * u64::from(options.height);
    let fits = |side: &u32| {
        let area = u64::from(side * side);
        let sums = area as usize * size_of::<kiloray_core::shade::Sum>();
        pixels >= area * u64::from(TILES_PER_NODE) * u64::from(nodes)
            && sums <= options.memory / TILE_PART
    };
    SIDES.into_iter().find(fits).unwrap_or(SIDES[SIDES.len() - 1])
}

/// How long a request may stay unanswered at first: many times the way across the mesh and what a node does between two looks
/// at its messages. Nodes adapt it to what they see.
fn patience(link: &Link, profile: &Profile, packet: usize, mesh: &Mesh) -> Time {
    let across = u64::from(mesh.distance(HOST, mesh.topology().antipode()))
        + u64::from(mesh.topology().distance(NodeId(0), mesh.topology().antipode()));
    let way = across.saturating_mul(link.latency.saturating_add(link.duration(packet)));
    Time(way.saturating_mul(16).saturating_add((profile.typical_ray() * 1000.0) as u64))
}

/// How long messages wait for others to the same node: as long as a packet is on its way to the next.
fn bundle_age(link: &Link, packet: usize) -> Time {
    Time(link.latency.saturating_add(link.duration(packet)).saturating_mul(2))
}
