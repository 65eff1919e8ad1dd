use super::{Hop, NodeId, Port, Topology};

/// The host: it holds the picture, hands out its tiles, and is no node.
pub const HOST: NodeId = NodeId(u16::MAX);

/// A topology and the host outside of it.
///
/// The host is a leaf with a link to node 0 and another to one [as far from it](Topology::antipode) as any; where there is
/// one node only, it has one link. An attached node has one port more than the topology gives it, the last; the ports of the
/// host are numbered as the nodes it is attached to.
///
/// What goes to the host leaves by the attached node nearest to its sender, what it sends enters by the one nearest
/// to its destination; the first of both where they are alike. Nothing passes through a leaf, so routes stay free of deadlock.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Mesh {
    topology: Topology,
    attached: [NodeId; 2],
}

impl Mesh {
    /// A host attached to a topology.
    #[must_use]
    pub fn new(topology: Topology) -> Self {
        Self { topology, attached: [NodeId(0), topology.antipode()] }
    }

    /// How the nodes are joined.
    #[must_use]
    pub const fn topology(&self) -> &Topology {
        &self.topology
    }

    /// The nodes that the host is attached to: one or two.
    #[must_use]
    pub fn attached(&self) -> &[NodeId] {
        let [first, second] = &self.attached;
        if first == second { core::slice::from_ref(first) } else { &self.attached }
    }

    /// Number of nodes, at least 1; the host is none.
    #[must_use]
    pub fn nodes(&self) -> u16 {
        self.topology.nodes()
    }

    /// Whether there is such a node, or it is the host.
    #[must_use]
    pub fn contains(&self, node: NodeId) -> bool {
        node == HOST || node.0 < self.nodes()
    }

    /// Buffers per channel and link that deadlock freedom needs: 2 where routes wrap round, else 1.
    #[must_use]
    pub fn classes(&self) -> u8 {
        self.topology.classes()
    }

    /// Ports of a node, used or not.
    #[must_use]
    pub fn ports(&self, node: NodeId) -> u16 {
        let attached = self.attached();
        if node == HOST {
            attached.len() as u16
        } else {
            self.topology.ports().saturating_add(u16::from(attached.contains(&node)))
        }
    }

    /// The node at the other end of a port.
    #[must_use]
    pub fn neighbour(&self, node: NodeId, port: Port) -> Option<NodeId> {
        if node == HOST {
            self.attached().get(usize::from(port.0)).copied()
        } else if port == self.exit() {
            self.attached().contains(&node).then_some(HOST)
        } else {
            self.topology.neighbour(node, port)
        }
    }

    /// The ports of a node that lead somewhere, in order.
    pub fn joined(&self, node: NodeId) -> impl Iterator<Item = Port> {
        (0..self.ports(node)).map(Port).filter(move |&port| self.neighbour(node, port).is_some())
    }

    /// The port of the far node that leads back over the same link.
    #[must_use]
    pub fn reverse(&self, node: NodeId, port: Port) -> Option<Port> {
        if node == HOST {
            self.neighbour(node, port).map(|_| self.exit())
        } else if port == self.exit() {
            self.entry(node)
        } else {
            self.topology.reverse(node, port)
        }
    }

    /// The next step from `here` towards `to`; `None` on arrival, or where one of them does not exist.
    #[must_use]
    pub fn route(&self, here: NodeId, to: NodeId) -> Option<Hop> {
        if here == to || !self.contains(here) || !self.contains(to) {
            return None;
        }
        if here == HOST {
            // Both classes are free of cycles here: what goes to different nodes need not wait for each other.
            let class = if self.classes() > 1 { (to.0 & 1) as u8 } else { 0 };
            return Some(Hop { port: self.entry(self.nearest(to)?)?, class });
        }
        if to != HOST {
            return self.topology.route(here, to);
        }
        let leave = self.nearest(here)?;
        if leave == here {
            return Some(Hop { port: self.exit(), class: 0 });
        }
        self.topology.route(here, leave)
    }

    /// Steps from `a` to `b`; 0 where one of them does not exist.
    #[must_use]
    pub fn distance(&self, a: NodeId, b: NodeId) -> u16 {
        let node = match (a == HOST, b == HOST) {
            (false, false) => return self.topology.distance(a, b),
            (true, true) => return 0,
            (true, false) => b,
            (false, true) => a,
        };
        let exists = node.0 < self.nodes();
        let leave = self.nearest(node).filter(|_| exists);
        leave.map_or(0, |leave| self.topology.distance(node, leave).saturating_add(1))
    }

    /// The attached node that is nearest to a node. Of two that are next to it one or the other, by its number, so that both links to the host are of use;
    /// farther away the first, as nodes on the way must find the same.
    fn nearest(&self, node: NodeId) -> Option<NodeId> {
        let (&first, others) = self.attached().split_first()?;
        let Some(&second) = others.first() else { return Some(first) };
        let [near, far] = [first, second].map(|attached| self.topology.distance(node, attached));
        let goes_second = far < near || far == 1 && near == 1 && node.0 & 1 == 0;
        Some(if goes_second { second } else { first })
    }

    /// The port of an attached node that leads to the host.
    fn exit(&self) -> Port {
        Port(self.topology.ports())
    }

    /// The port of the host that leads to an attached node.
    fn entry(&self, node: NodeId) -> Option<Port> {
        self.attached().iter().position(|&a| a == node).map(|port| Port(port as u16))
    }
}
