use bytemuck::{Pod, Zeroable};

use super::{
    Node, NodeNeeds, NodePlan, Picture, PointHome, Prefetch, Schedule, Settings, ShadowPolicy,
    Share, TaskOrder, Time,
};
use crate::network::{Grid, Mesh, Topology};
use crate::render::Tiling;
use crate::scene::Needs;
use crate::shade::{self, SPLITS, Shader, Tables};
use crate::store::{Arena, ArenaFull, BudgetError, Chunk};
use crate::trace::Tracer;
use crate::view::Camera;

/// What every node of a run is told before it begins: the mesh, the picture, and how to work. With its [`Share`] of the scene it is all that a
/// node needs. Little-endian, the same on all machines.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Setup {
    /// [`VERSION`](Self::VERSION).
    pub version: u32,
    /// The scene that is meant ([`Share::scene`]).
    pub scene: u32,
    /// Sizes of the topology: see [`Setup::with_topology`].
    pub sizes: [u16; 15],
    /// Which topology.
    pub topology: u8,
    /// Who traces what: see [`Setup::code`].
    pub policy: u8,
    /// See [`shade::Settings`].
    pub seed: u64,
    /// See [`Settings::patience`].
    pub patience: Time,
    /// See [`Settings::bundle_age`].
    pub bundle_age: Time,
    /// At which intervals overdue credit is asked for ([`run`](super::run)).
    pub reminder: Time,
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// See [`shade::Settings`].
    pub samples: u32,
    /// See [`shade::Settings`].
    pub shadow_samples: u16,
    /// See [`shade::Settings`].
    pub lights: u16,
    /// Pixels along a tile.
    pub side: u16,
    /// Greatest payload of a packet.
    pub payload: u16,
    /// Packets in each buffer of a link.
    pub depth: u16,
    /// See [`Settings::group`].
    pub group: u16,
    /// See [`Settings::prefetch`]; `u16::MAX` for all.
    pub prefetch: u16,
    /// See [`shade::Settings`].
    pub bounces: u8,
    /// See [`Settings::refusals`].
    pub refusals: u8,
    /// The camera, prepared for these columns and rows.
    pub camera: Camera,
}

/// Why a node cannot begin.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum SetupError {
    /// The setup is of another version, or has a number that cannot be.
    Setup,
    /// It is of another scene, or of another number of nodes, than the share.
    Scene,
    /// The memory is too small.
    Memory(BudgetError),
    /// The memory is not what was planned.
    Arena(ArenaFull),
}

const GRID: u8 = 0;
const WRAPPING_GRID: u8 = 1;
const TREE: u8 = 2;
const FULL: u8 = 3;

impl Setup {
    /// The version of this layout: whatever changes it raises it. (1 had a view in place of the camera, and a schedule alone as its policy; 2
    /// did not say where points live, and rays did not say in which block they hit; 3 had a camera that did not divide
    /// pixels among their samples; 4 did not say how many lights a point asks; 5 did not number requests; 6 made other shadow rays, 7 had other
    /// units of very bright and very dim scenes, 9 other light behind balls of glass and on polished surfaces, 10 other
    /// ways to the host, 12 sums of eight bytes a channel, 13 blocks with their nodes first.)
    pub const VERSION: u32 = 14;
    /// Its length.
    pub const BYTES: usize = size_of::<Self>();

    /// Reads a setup; `None` if it is of another length or version, or of a mesh that cannot be.
    #[must_use]
    pub fn parse(bytes: &[u8]) -> Option<Self> {
        let setup: Self = bytemuck::try_pod_read_unaligned(bytes).ok()?;
        let sound = setup.version == Self::VERSION && setup.mesh().is_some();
        sound.then_some(setup)
    }

    /// The same for a mesh: of a grid the sizes of its dimensions, 0 beyond the last; of a tree its nodes and children, of a full mesh its nodes.
    #[must_use]
    pub fn with_topology(mut self, topology: &Topology) -> Self {
        self.sizes = [0; 15];
        let mut put = |sizes: &mut dyn Iterator<Item = u16>| {
            self.sizes.iter_mut().zip(sizes).for_each(|(place, size)| *place = size);
        };
        self.topology = match *topology {
            Topology::Grid(grid) => {
                put(&mut grid.sizes());
                if grid.wraps() { WRAPPING_GRID } else { GRID }
            }
            Topology::Tree { nodes, arity } => {
                put(&mut [nodes, arity].into_iter());
                TREE
            }
            Topology::Full { nodes } => {
                put(&mut [nodes].into_iter());
                FULL
            }
        };
        self
    }

    /// The mesh, and the host beside it.
    #[must_use]
    pub fn mesh(&self) -> Option<Mesh> {
        let [nodes, arity, ..] = self.sizes;
        let topology = match self.topology {
            GRID | WRAPPING_GRID => {
                let len = self.sizes.iter().position(|&size| size == 0);
                let sizes = self.sizes.get(..len.unwrap_or(self.sizes.len()))?;
                Topology::Grid(Grid::new(sizes, self.topology == WRAPPING_GRID)?)
            }
            TREE if arity > 0 && arity <= nodes => Topology::Tree { nodes, arity },
            FULL if nodes > 0 => Topology::Full { nodes },
            _ => return None,
        };
        Some(Mesh::new(topology))
    }

    /// Samples, bounces and seed of the picture.
    #[must_use]
    pub const fn shading(&self) -> shade::Settings {
        shade::Settings {
            samples: self.samples,
            shadow_samples: self.shadow_samples,
            lights: self.lights,
            bounces: self.bounces,
            seed: self.seed,
        }
    }

    /// How the nodes work.
    #[must_use]
    pub const fn settings(&self, share: &Share<'_>) -> Settings {
        Settings {
            schedule: self.schedule(),
            shadow: self.shadow(),
            points: self.points(),
            placement: *share.placement(),
            refusals: self.refusals,
            prefetch: match self.prefetch {
                u16::MAX => Prefetch::All,
                blocks => Prefetch::Nearest(blocks),
            },
            order: TaskOrder::Ready,
            patience: self.patience,
            bundle_age: self.bundle_age,
            group: self.group,
            deaths_told: false,
        }
    }

    /// How the memory of a node is divided.
    ///
    /// # Errors
    /// [`SetupError`].
    pub fn plan(&self, share: &Share<'_>, memory: usize) -> Result<NodePlan, SetupError> {
        let mesh = self.mesh().ok_or(SetupError::Setup)?;
        if self.scene != share.scene() || mesh.nodes() != share.placement().nodes {
            return Err(SetupError::Scene);
        }
        let file = share.file();
        let specular = file.needs().bits & Needs::SPECULAR != 0;
        let needs = NodeNeeds {
            mesh,
            here: share.here(),
            block_bytes: file.limits().block_bytes,
            remote: (file.blocks() as usize).saturating_sub(share.rom().len()),
            owned: 0,
            splits: if specular { usize::from(self.bounces.min(SPLITS)) } else { 0 },
            schedule: self.schedule(),
            shadow: self.shadow(),
            points: self.points(),
            group: self.group,
            side: usize::from(self.side),
            packet: usize::from(self.payload),
            depth: self.depth,
            host_depth: 0,
        };
        NodePlan::new(memory, &needs).map_err(SetupError::Memory)
    }

    /// The node, in its memory.
    ///
    /// # Errors
    /// [`SetupError`].
    #[inline(never)]
    pub fn node<'a, T: Tracer>(
        &self,
        share: &Share<'a>,
        tracer: T,
        memory: &'a mut [Chunk],
    ) -> Result<Node<'a, Picture<'a, T>>, SetupError> {
        let bytes = size_of_val(memory);
        let plan = self.plan(share, bytes)?;
        let budget = plan.budget(bytes).map_err(SetupError::Memory)?;
        let file = share.file();
        let shader = Shader::new(Tables::of(file), self.shading());
        let tiling = Tiling::new(self.width, self.height, u32::from(self.side));
        let world = Picture::new(tracer, shader, self.camera, tiling, file.limits());
        let mesh = self.mesh().ok_or(SetupError::Setup)?;
        let settings = self.settings(share);
        Node::new(&mut Arena::new(memory), &plan, budget, settings, *share.rom(), mesh, world)
            .map_err(SetupError::Arena)
    }

    /// What a setup says for these: the number of the first in the lowest two bits, those of the next above it, in the order in which they are declared.
    #[must_use]
    pub const fn code(schedule: Schedule, shadow: ShadowPolicy, points: PointHome) -> u8 {
        let schedule = match schedule {
            Schedule::Hybrid => 0,
            Schedule::Demand => 1,
            Schedule::Data => 2,
        };
        let shadow = match shadow {
            ShadowPolicy::Keep => 0,
            ShadowPolicy::Offer => 1,
            ShadowPolicy::Steal => 2,
        };
        let points = match points {
            PointHome::Finder => 0,
            PointHome::Owner => 1,
        };
        schedule | shadow << 2 | points << 4
    }

    const fn schedule(&self) -> Schedule {
        match self.policy & 3 {
            0 => Schedule::Hybrid,
            1 => Schedule::Demand,
            _ => Schedule::Data,
        }
    }

    const fn shadow(&self) -> ShadowPolicy {
        match self.policy >> 2 & 3 {
            0 => ShadowPolicy::Keep,
            1 => ShadowPolicy::Offer,
            _ => ShadowPolicy::Steal,
        }
    }

    const fn points(&self) -> PointHome {
        match self.policy >> 4 & 3 {
            0 => PointHome::Finder,
            _ => PointHome::Owner,
        }
    }
}

impl core::fmt::Display for SetupError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Setup => f.write_str("the setup is of another version, or damaged"),
            Self::Scene => f.write_str("the node's share is of another scene or mesh"),
            Self::Memory(error) => error.fmt(f),
            Self::Arena(error) => error.fmt(f),
        }
    }
}

impl core::error::Error for SetupError {}
