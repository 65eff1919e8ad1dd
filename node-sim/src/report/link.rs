use kiloray_core::network::{Mesh, Topology};
use serde::Serialize;

/// The mesh of a run.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct MeshReport {
    /// `grid`, `tree` or `full`.
    pub shape: &'static str,
    /// Sizes of a grid's dimensions, the first counting fastest; else the number of nodes.
    pub sizes: Vec<u16>,
    /// Whether the ends of a grid's dimensions are joined.
    pub wraps: bool,
    /// Children of a node of a tree; else 0.
    pub arity: u16,
    /// Number of nodes.
    pub nodes: u16,
    /// The nodes that the host is attached to.
    pub attached: Vec<u16>,
}

impl MeshReport {
    /// Of a mesh.
    #[must_use]
    pub fn new(mesh: &Mesh) -> Self {
        let nodes = mesh.nodes();
        let (shape, sizes, wraps, arity) = match mesh.topology() {
            Topology::Grid(grid) => ("grid", grid.sizes().collect(), grid.wraps(), 0),
            Topology::Tree { arity, .. } => ("tree", vec![nodes], false, *arity),
            Topology::Full { .. } => ("full", vec![nodes], false, 0),
        };
        let attached = mesh.attached().iter().map(|node| node.0).collect();
        Self { shape, sizes, wraps, arity, nodes, attached }
    }
}

/// One direction of a link.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct LinkReport {
    /// The node that sends; `None` is the host.
    pub from: Option<u16>,
    /// The node that receives; `None` is the host.
    pub to: Option<u16>,
    /// The port that it leaves by.
    pub port: u16,
    /// Packets sent, control packets not counted.
    pub packets: u64,
    /// Packets sent that bring credit only.
    pub control_packets: u64,
    /// Bytes sent, headers included.
    pub bytes: u64,
    /// Time in which it carried something \[ns\].
    pub busy_ns: u64,
    /// Most packets held at once by the buffers at its end.
    pub buffers_peak: u32,
    /// Packets that the buffers at its end can hold.
    pub buffers: u32,
}
