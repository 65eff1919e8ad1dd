use super::Ledger;
use kiloray_core::block::KiloView;
use kiloray_core::network::{HOST, Mesh, NodeId, PacketHeader, RouterSize, Topology};
use kiloray_core::node::{
    Dealing, NodeNeeds, NodePlan, Placement, PointHome, Prefetch, Rom, Schedule, Settings,
    ShadowPolicy, TaskOrder, Time,
};
use kiloray_core::shade::{self, Shader, Tables};
use kiloray_core::store::{Arena, Budget, BudgetError};
use kiloray_render::PictureError;

/// Packets in each buffer at the host's end of a link. All nodes send to it, over two links: with as few as nodes with little memory have, each packet
/// would wait for the credit of the one before.
const HOST_DEPTH: u16 = 32;

/// What decides how a run is divided among the nodes of a mesh.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeshOptions {
    /// Columns of the picture.
    pub width: u32,
    /// Rows of the picture.
    pub height: u32,
    /// Samples, bounces and seed of the picture.
    pub settings: shade::Settings,
    /// How the nodes are joined, and how many there are.
    pub topology: Topology,
    /// Bytes for everything that a node holds.
    pub memory: usize,
    /// Greatest packet, its header included \[bytes\]; 0: by the [memory](NodePlan::packet) of a node.
    pub packet: u16,
    /// Which rays go where.
    pub schedule: Schedule,
    /// Who traces the shadow rays of a hit.
    pub shadow: ShadowPolicy,
    /// Where intersection points live.
    pub points: PointHome,
    /// How blocks are dealt out to nodes.
    pub dealing: Dealing,
    /// Blocks that every node has; `None` for as many as suit the scene, and the memory where they take part of it.
    pub top: Option<u32>,
    /// Copies of each other block.
    pub replicas: u16,
    /// How many blocks are fetched ahead for a bundle.
    pub prefetch: Prefetch,
    /// Which of the waiting rays goes on first.
    pub order: TaskOrder,
    /// Nodes for each sub-master; 0 for none: all ask the host.
    pub group: u16,
    /// Refusals of a ray that is sent again, before the node that sent it runs it itself: who has no room now mostly has none in time.
    pub refusals: u8,
    /// Side of a tile \[pixels\]; `None` for what suits the picture, the mesh and the memory.
    pub tile: Option<u16>,
    /// The blocks that a node owns take part of its memory too, and so do the tables of the scene.
    pub owned_in_arena: bool,
}

impl MeshOptions {
    /// A picture on a mesh, with all else as it is by default.
    #[must_use]
    pub fn new(width: u32, height: u32, topology: Topology) -> Self {
        Self {
            width,
            height,
            settings: shade::Settings::default(),
            topology,
            memory: 256 << 10,
            packet: 0,
            schedule: Schedule::Hybrid,
            shadow: ShadowPolicy::default(),
            points: PointHome::default(),
            dealing: Dealing::Subtrees,
            top: None,
            replicas: 1,
            // Fetching ahead has not paid on any scene measured.
            prefetch: Prefetch::Nearest(0),
            order: TaskOrder::Ready,
            group: 0,
            refusals: 0,
            tile: None,
            owned_in_arena: false,
        }
    }

    /// The least [`packet`](Self::packet) with which blocks of a size can be sent \[bytes\]; less would be taken as this.
    #[must_use]
    pub fn packet_min(block_bytes: usize) -> u16 {
        let packet = NodePlan::packet_min(block_bytes) + PacketHeader::BYTES;
        u16::try_from(packet).unwrap_or(u16::MAX)
    }

    /// The greatest [`packet`](Self::packet), which suits any block \[bytes\]; more would be taken as this.
    #[must_use]
    pub fn packet_max() -> u16 {
        Self::packet_min(usize::MAX)
    }

    /// Which node owns which blocks of a scene.
    #[must_use]
    pub fn placement(&self, file: &KiloView<'_>) -> Placement {
        Placement {
            dealing: self.dealing,
            blocks: file.blocks(),
            nodes: self.topology.nodes(),
            top: self.top.unwrap_or_else(|| top(file, self)).clamp(1, file.blocks().max(1)),
            replicas: self.replicas,
        }
    }
}

/// How a run is divided: blocks among nodes, the memory of each node, the picture into tiles.
///
/// It follows from the scene and the options alone: whoever has them finds the same.
#[derive(Debug, Clone)]
pub struct MeshLayout {
    /// What all nodes share.
    pub settings: Settings,
    /// How the memory of each node is divided.
    pub plans: Vec<NodePlan>,
    /// The same, line by line.
    pub budgets: Vec<Budget>,
    block_bytes: usize,
}

/// Of the blocks every node has this part, those nearest to the root: more of it is read by most rays.
const TOP_PART: u32 = 64;
/// Of a small scene more of them, as many as would fit this part of a node's memory: a few owners would be asked by all.
/// Where they take memory themselves, they take no more than that: the node's own take most.
const TOP_MEMORY_PART: usize = 16;
/// Tiles for each node, where the picture has so many pixels.
const TILES_PER_NODE: u32 = 16;
/// Greatest and least side of a tile.
const SIDES: [u32; 4] = [32, 16, 8, 4];
/// The part of the memory that the sums of a tile may take.
const TILE_PART: usize = 8;

impl MeshLayout {
    /// Divides all. `pace` says, of the greatest packet with its header, the first [`patience`](Settings::patience) of nodes and the
    /// [greatest age](Settings::bundle_age) of their bundles of messages.
    ///
    /// What suits a memory may not fit into it where most of it is taken: then the least of each does. So whatever memory is enough, more is.
    ///
    /// # Errors
    /// [`BudgetError`] if the memory is too small: with what is needed at least.
    pub fn new(
        file: &KiloView<'_>,
        options: &MeshOptions,
        pace: impl FnOnce(usize) -> (Time, Time),
    ) -> Result<Self, BudgetError> {
        let suits = Division::suiting(file, options);
        let (Division { placement, .. }, plans) = match suits.plans(file, options) {
            Ok(plans) => (suits, plans),
            Err(_) => {
                let least = Division::least(file, options);
                (least, least.plans(file, options)?)
            }
        };
        let budgets =
            plans.iter().map(|plan| plan.budget(options.memory)).collect::<Result<_, _>>()?;
        let payload = plans.first().map_or(0, NodePlan::payload);
        let (patience, bundle_age) = pace(payload + PacketHeader::BYTES);
        let settings = Settings {
            schedule: options.schedule,
            shadow: options.shadow,
            points: options.points,
            placement,
            refusals: options.refusals,
            prefetch: options.prefetch,
            order: options.order,
            patience,
            bundle_age,
            group: options.group,
            deaths_told: false,
        };
        Ok(Self { settings, plans, budgets, block_bytes: file.limits().block_bytes })
    }

    /// Side of a tile.
    #[must_use]
    pub fn side(&self) -> u32 {
        self.plans.first().map_or(1, |plan| plan.side as u32)
    }

    /// The options, with what was found where nothing was said: packet, tile, top of the tree.
    #[must_use]
    pub fn resolved(&self, options: &MeshOptions) -> MeshOptions {
        MeshOptions {
            packet: self.packet(),
            tile: Some(self.side() as u16),
            top: Some(self.settings.placement.top),
            ..*options
        }
    }

    /// Greatest packet, header included \[bytes\].
    #[must_use]
    pub fn packet(&self) -> u16 {
        let payload = self.plans.first().map_or(0, NodePlan::payload);
        (payload + PacketHeader::BYTES).min(usize::from(u16::MAX)) as u16
    }

    /// Bytes of a block.
    #[must_use]
    pub const fn block_bytes(&self) -> usize {
        self.block_bytes
    }

    /// The blocks that a node reads in place.
    #[must_use]
    pub fn rom<'a>(&self, file: &KiloView<'a>, here: NodeId) -> Rom<'a> {
        Rom::of_file(file.block_section(), self.block_bytes, self.settings.placement, here)
    }

    /// How many blocks a node reads in place.
    #[must_use]
    pub fn owned(&self, here: NodeId) -> u32 {
        self.settings.placement.held(here)
    }

    /// The host's end of the network.
    #[must_use]
    pub fn host_router(&self, mesh: &Mesh) -> RouterSize {
        let (depth, payload) =
            self.plans.first().map_or((1, 1), |plan| (plan.router.depth, plan.router.payload));
        RouterSize::new(mesh, HOST, depth, payload).with_host(mesh, HOST, HOST_DEPTH)
    }

    /// The ledger of a picture of these options that nobody has begun.
    ///
    /// # Errors
    /// [`PictureError::Size`] for a picture that cannot be.
    pub fn ledger(
        &self,
        file: &KiloView<'_>,
        options: &MeshOptions,
    ) -> Result<Ledger, PictureError> {
        let &MeshOptions { width, height, settings, .. } = options;
        let unit = Shader::new(Tables::of(file), settings).unit();
        let ledger =
            Ledger::new(width, height, self.side(), settings.seed, unit, settings.samples)?;
        Ok(ledger.with_askers(self.askers()))
    }

    /// Who asks the host for tiles.
    fn askers(&self) -> u32 {
        let nodes = self.plans.len() as u32;
        match self.settings.group {
            0 => nodes,
            group => nodes.div_ceil(u32::from(group)),
        }
    }
}

/// What is chosen for a memory where nobody asks for something else.
#[derive(Clone, Copy)]
struct Division {
    placement: Placement,
    side: u32,
    /// Greatest payload of a packet, and packets in each buffer: 0 for what suits the memory.
    payload: usize,
    depth: u16,
}

impl Division {
    /// What suits the memory.
    fn suiting(file: &KiloView<'_>, options: &MeshOptions) -> Self {
        let side = options.tile.map_or_else(|| side(options), u32::from).max(1);
        let payload = usize::from(options.packet).saturating_sub(PacketHeader::BYTES);
        Self { placement: options.placement(file), side, payload, depth: 0 }
    }

    /// What takes the least memory.
    fn least(file: &KiloView<'_>, options: &MeshOptions) -> Self {
        let none = MeshOptions { memory: 0, ..*options };
        let Self { placement, side, payload, .. } = Self::suiting(file, &none);
        let payload = match payload {
            0 => NodePlan::packet_min(file.limits().block_bytes),
            asked => asked,
        };
        Self { placement, side, payload, depth: 1 }
    }

    /// The memory of each node.
    fn plans(
        &self,
        file: &KiloView<'_>,
        options: &MeshOptions,
    ) -> Result<Vec<NodePlan>, BudgetError> {
        let mesh = Mesh::new(options.topology);
        let block_bytes = file.limits().block_bytes;
        let tables = Tables::of(file);
        let splits = Shader::new(tables, options.settings).splits(0);
        let plan = |here: NodeId, packet: usize| {
            let owned = self.placement.held(here) as usize;
            let needs = NodeNeeds {
                mesh,
                here,
                block_bytes,
                remote: file.blocks() as usize - owned,
                owned: if options.owned_in_arena {
                    Arena::bytes_of::<u8>(owned * block_bytes) + tables.arena_bytes()
                } else {
                    0
                },
                splits,
                schedule: options.schedule,
                shadow: options.shadow,
                points: options.points,
                group: options.group,
                side: self.side as usize,
                packet,
                depth: self.depth,
                host_depth: HOST_DEPTH,
            };
            NodePlan::new(options.memory, &needs)
        };
        let all = || (0..mesh.nodes()).map(NodeId);
        let mut plans =
            all().map(|here| plan(here, self.payload)).collect::<Result<Vec<_>, _>>()?;
        // One with fewer links, or fewer blocks in its memory, would take longer packets than its neighbours have room for.
        let least = plans.iter().map(NodePlan::payload).min().unwrap_or(0);
        for (agreed, here) in plans.iter_mut().zip(all()) {
            if agreed.payload() != least {
                *agreed = plan(here, least)?;
            }
        }
        Ok(plans)
    }
}

/// How many blocks every node has.
fn top(file: &KiloView<'_>, options: &MeshOptions) -> u32 {
    let suits = file.blocks() / TOP_PART;
    let fits = options.memory / TOP_MEMORY_PART / file.limits().block_bytes.max(1);
    let fits = fits as u32;
    if options.owned_in_arena { suits.min(fits) } else { suits.max(fits) }
}

/// The greatest side with which every node has some tiles, and which the memory holds.
fn side(options: &MeshOptions) -> u32 {
    let fits = |side: &u32| options.has_tiles(*side, TILES_PER_NODE);
    SIDES.into_iter().find(fits).unwrap_or(SIDES[SIDES.len() - 1])
}

impl MeshOptions {
    /// Whether the picture has so many tiles of this side for each node, whose sums the memory holds.
    #[must_use]
    pub fn has_tiles(&self, side: u32, per_node: u32) -> bool {
        let (area, nodes) = (u64::from(side) * u64::from(side), self.topology.nodes());
        let pixels = u64::from(self.width) * u64::from(self.height);
        let sums = area * size_of::<shade::Sum>() as u64;
        pixels >= area * u64::from(per_node) * u64::from(nodes)
            && sums <= (self.memory / TILE_PART) as u64
    }
}
