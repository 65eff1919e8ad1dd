use super::Grid;

/// Most nodes of a mesh.
pub const NODES_MAX: u32 = 1 << 15;

/// The number of a node: 0 to the number of nodes less one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct NodeId(pub u16);

/// The number of a link at a node. A port may be unused: a corner of a mesh has no neighbour there.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Port(pub u16);

/// One step of a route.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Hop {
    /// The port to leave by.
    pub port: Port,
    /// Which of the channel's buffers at the far end the packet takes: below [`Topology::classes`].
    pub class: u8,
}

/// Who is next to whom, and which way a packet goes.
///
/// Routes are shortest, a function of place and destination alone, and free of deadlock: grids route in
/// order of dimensions, wrapping ones with a dateline (Dally & Seitz 1987, "Deadlock-free message
/// routing in multiprocessor interconnection networks"), trees up and then down (rule 2 of the mesh).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Topology {
    /// Line, ring, mesh, torus and hypercube.
    Grid(Grid),
    /// Node 0 is the root, the children of `i` are `arity * i + 1` and the `arity - 1` after it.
    Tree {
        /// Number of nodes.
        nodes: u16,
        /// Children of a node.
        arity: u16,
    },
    /// Each is next to each.
    Full {
        /// Number of nodes.
        nodes: u16,
    },
}

impl Topology {
    /// Number of nodes, at least 1.
    #[must_use]
    pub fn nodes(&self) -> u16 {
        match *self {
            Self::Grid(grid) => grid.nodes(),
            Self::Tree { nodes, .. } | Self::Full { nodes } => nodes,
        }
    }

    /// Buffers per channel and link that deadlock freedom needs: 2 where routes wrap round, else 1.
    #[must_use]
    pub fn classes(&self) -> u8 {
        match self {
            Self::Grid(grid) => 1 + u8::from(grid.wraps()),
            Self::Tree { .. } | Self::Full { .. } => 1,
        }
    }

    /// Ports of a node, used or not.
    #[must_use]
    pub fn ports(&self) -> u16 {
        match *self {
            Self::Grid(grid) => grid.ports(),
            Self::Tree { arity, .. } => arity.saturating_add(1),
            Self::Full { nodes } => nodes,
        }
    }

    /// The node at the other end of a port.
    #[must_use]
    pub fn neighbour(&self, node: NodeId, Port(port): Port) -> Option<NodeId> {
        let nodes = self.nodes();
        if node.0 >= nodes {
            return None;
        }
        match *self {
            Self::Grid(grid) => grid.neighbour(node, port),
            Self::Tree { arity, .. } if port == 0 => parent(node, arity),
            Self::Tree { arity, .. } => {
                let child = u32::from(node.0) * u32::from(arity) + u32::from(port);
                let is_child = port <= arity && child < u32::from(nodes);
                is_child.then_some(NodeId(child as u16))
            }
            Self::Full { .. } => (port < nodes && port != node.0).then_some(NodeId(port)),
        }
    }

    /// The port of the far node that leads back over the same link.
    #[must_use]
    pub fn reverse(&self, node: NodeId, port: Port) -> Option<Port> {
        let far = self.neighbour(node, port)?;
        Some(match *self {
            Self::Grid(_) => Port(port.0 ^ 1),
            Self::Tree { .. } if port.0 != 0 => Port(0),
            Self::Tree { arity, .. } => child_port(node, far, arity),
            Self::Full { .. } => Port(node.0),
        })
    }

    /// The next step from `here` towards `to`; `None` on arrival, or where one of them does not exist.
    #[must_use]
    pub fn route(&self, here: NodeId, to: NodeId) -> Option<Hop> {
        if here == to || here.0 >= self.nodes() || to.0 >= self.nodes() {
            return None;
        }
        match *self {
            Self::Grid(grid) => grid.route(here, to),
            Self::Tree { arity, .. } => {
                let mut below = to;
                let port = loop {
                    match parent(below, arity) {
                        Some(p) if p == here => break child_port(below, here, arity),
                        Some(p) if p.0 > here.0 => below = p,
                        // An ancestor has a lesser number: `to` is not below this node.
                        _ => break Port(0),
                    }
                };
                Some(Hop { port, class: 0 })
            }
            Self::Full { .. } => Some(Hop { port: Port(to.0), class: 0 }),
        }
    }

    /// Steps from `a` to `b`; 0 where one of them does not exist.
    #[must_use]
    pub fn distance(&self, a: NodeId, b: NodeId) -> u16 {
        if a == b || a.0 >= self.nodes() || b.0 >= self.nodes() {
            return 0;
        }
        match *self {
            Self::Grid(grid) => grid.distance(a, b),
            Self::Tree { arity, .. } => {
                let (mut a, mut b, mut steps) = (a, b, 0_u16);
                // The greater number is no less deep: it climbs, until both have met.
                while a != b {
                    let deeper = if a > b { &mut a } else { &mut b };
                    let Some(above) = parent(*deeper, arity) else { break };
                    *deeper = above;
                    steps = steps.saturating_add(1);
                }
                steps
            }
            Self::Full { .. } => 1,
        }
    }

    /// A node as far from node 0 as any.
    #[must_use]
    pub fn antipode(&self) -> NodeId {
        match *self {
            Self::Grid(grid) => grid.antipode(),
            Self::Tree { nodes, .. } | Self::Full { nodes } => NodeId(nodes.saturating_sub(1)),
        }
    }
}

fn parent(node: NodeId, arity: u16) -> Option<NodeId> {
    Some(NodeId(node.0.checked_sub(1)?.checked_div(arity)?))
}

/// The port by which `parent` reaches `child`.
fn child_port(child: NodeId, parent: NodeId, arity: u16) -> Port {
    let first = u32::from(parent.0) * u32::from(arity);
    Port(u32::from(child.0).saturating_sub(first) as u16)
}
