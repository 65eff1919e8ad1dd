use std::sync::atomic::AtomicBool;

use kiloray_core::network::{NodeId, Topology};
use kiloray_core::scene::View;
use kiloray_mesh::MeshOptions;

use crate::Profile;

/// What a person chooses for a run.
#[derive(Debug, Clone, PartialEq)]
pub struct Options {
    /// The picture, and how it is divided among the nodes.
    pub mesh: MeshOptions,
    /// The camera.
    pub view: View,
    /// The links.
    pub link: Link,
    /// Greatest age of messages that wait for others to the same node \[ns\]; [`Link::bundle_age`] where nothing is said.
    pub bundle_age: Option<u64>,
    /// How long operations take.
    pub profile: Profile,
    /// What goes wrong.
    pub faults: Faults,
    /// Of the faults of links; that of the picture is in [`MeshOptions::settings`].
    pub seed: u64,
    /// Most events of a trace to keep, the first ones; 0 for no trace.
    pub trace: usize,
    /// Threads of this machine, 0 for as many as it has processors. The run is the same with any number.
    pub threads: usize,
}

impl Options {
    /// A picture of a view on a mesh, with all else as it is by default.
    #[must_use]
    pub fn new(width: u32, height: u32, view: View, topology: Topology) -> Self {
        Self {
            mesh: MeshOptions::new(width, height, topology),
            view,
            link: Link::default(),
            bundle_age: None,
            profile: Profile::PC,
            faults: Faults::default(),
            seed: 0,
            trace: 0,
            threads: 0,
        }
    }

    /// The same with nodes of another memory \[bytes\].
    #[must_use]
    pub fn with_memory(&self, memory: usize) -> Self {
        Self { mesh: MeshOptions { memory, ..self.mesh }, ..self.clone() }
    }
}

/// The links of a mesh. They are full duplex: each direction has the whole bandwidth.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Link {
    /// Bytes per second, at least 1.
    pub bandwidth: u64,
    /// From a byte's departure to its arrival \[ns\].
    pub latency: u64,
    /// When a router sends on what it receives.
    pub switching: Switching,
}

impl Default for Link {
    /// 1 GB/s and 1 µs; cut-through.
    fn default() -> Self {
        Self { bandwidth: 1_000_000_000, latency: 1_000, switching: Switching::CutThrough }
    }
}

/// When a router sends on what it receives.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Switching {
    /// When the packet is here as a whole.
    StoreAndForward,
    /// When its header is here; where the way on is not free, the packet is stored (virtual cut-through, Kermani & Kleinrock 1979).
    CutThrough,
}

/// What goes wrong. All of it follows from [`Options::seed`].
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Faults {
    /// Of the packets, on each link.
    pub loss: Rate,
    /// Of the packets, on each link: they arrive twice.
    pub duplicate: Rate,
    /// Packets are delayed on each link by up to so much, evenly; one in sixteen can be overtaken by those behind it \[ns\].
    pub jitter: u64,
    /// Nodes whose work takes longer.
    pub slow: Vec<Slow>,
    /// Nodes that die.
    pub crashes: Vec<Crash>,
}

impl Faults {
    /// Whether packets can be lost, doubled or overtaken.
    #[must_use]
    pub fn of_links(&self) -> bool {
        self.loss.count > 0 || self.duplicate.count > 0 || self.jitter > 0
    }
}

/// How often something happens: `count` times in `of`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Rate {
    /// So many times.
    pub count: u32,
    /// In so many, at least 1.
    pub of: u32,
}

impl Default for Rate {
    /// Never.
    fn default() -> Self {
        Self { count: 0, of: 1 }
    }
}

/// A node whose work takes longer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Slow {
    /// The node.
    pub node: NodeId,
    /// How many times longer; above 0.
    pub factor: f64,
}

/// A node that dies: its actor and its memory are gone, its router goes on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Crash {
    /// The node.
    pub node: NodeId,
    /// When \[ns\].
    pub at: u64,
}

/// How the caller follows a run, and stops it.
#[derive(Clone, Copy)]
pub struct Control<'a> {
    /// Set from anywhere, it ends the run soon: what is rendered is given, marked as incomplete.
    pub cancel: &'a AtomicBool,
    /// Hears from time to time how far the run is.
    pub progress: &'a (dyn Fn(&Status) + Sync),
}

impl std::fmt::Debug for Control<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Control").field("cancel", self.cancel).finish_non_exhaustive()
    }
}

/// How far a run is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Status {
    /// Pixels that are complete.
    pub pixels: u64,
    /// All pixels.
    pub pixels_all: u64,
    /// Virtual time \[ns\].
    pub virtual_ns: u64,
    /// Events of the simulation so far.
    pub events: u64,
    /// Rays traced so far.
    pub rays: u64,
}
