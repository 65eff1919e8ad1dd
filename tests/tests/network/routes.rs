//! Every route is shortest, and no set of routes can close a cycle of waiting buffers.

use std::collections::VecDeque;

use kiloray_core::network::{NodeId, Port, Topology};
use petgraph::{algo::is_cyclic_directed, graphmap::DiGraphMap};

/// Small meshes of every shape, with odd and even sizes, flat and single ones.
const SHAPES: &[(&str, u32)] = &[
    ("line", 1),
    ("line", 7),
    ("ring", 2),
    ("ring", 3),
    ("ring", 4),
    ("ring", 9),
    ("mesh:4x5", 20),
    ("mesh:3x1x4", 12),
    ("torus:2x2", 4),
    ("torus:4x4", 16),
    ("torus:5x3", 15),
    ("torus:8x8", 64),
    ("torus:3x4x2", 24),
    ("torus:4x4x4", 64),
    ("hypercube", 1),
    ("hypercube", 2),
    ("hypercube", 64),
    ("tree", 1),
    ("tree", 31),
    ("tree:3", 23),
    ("full", 1),
    ("full", 9),
];

fn shapes() -> impl Iterator<Item = (&'static str, Topology)> {
    SHAPES.iter().map(|&(name, nodes)| (name, Topology::parse(name, nodes).unwrap()))
}

fn ids(topology: &Topology) -> impl Iterator<Item = NodeId> + use<> {
    (0..topology.nodes()).map(NodeId)
}

fn neighbours(topology: &Topology, node: NodeId) -> impl Iterator<Item = (Port, NodeId)> {
    (0..topology.ports()).map(Port).filter_map(move |p| Some((p, topology.neighbour(node, p)?)))
}

/// Steps from `from` to every node, by a search that knows only who is next to whom.
fn distances(topology: &Topology, from: NodeId) -> Vec<Option<u16>> {
    let mut found = vec![None; usize::from(topology.nodes())];
    found[usize::from(from.0)] = Some(0);
    let mut queue = VecDeque::from([from]);
    while let Some(node) = queue.pop_front() {
        for (_, next) in neighbours(topology, node) {
            if found[usize::from(next.0)].is_none() {
                found[usize::from(next.0)] = found[usize::from(node.0)].map(|d| d + 1);
                queue.push_back(next);
            }
        }
    }
    found
}

#[test]
fn links_lead_both_ways() {
    for (name, topology) in shapes() {
        for node in ids(&topology) {
            for (port, far) in neighbours(&topology, node) {
                let back = topology.reverse(node, port).unwrap();
                assert_eq!(topology.neighbour(far, back), Some(node), "{name} {node:?} {port:?}");
                assert_eq!(topology.reverse(far, back), Some(port), "{name} {node:?} {port:?}");
            }
        }
    }
}

#[test]
fn routes_are_shortest() {
    for (name, topology) in shapes() {
        for from in ids(&topology) {
            for (to, shortest) in ids(&topology).zip(distances(&topology, from)) {
                assert_eq!(Some(topology.distance(from, to)), shortest, "{name} {from:?} {to:?}");
            }
        }
    }
}

/// Dally & Seitz 1987, theorem 1: routes are free of deadlock if the graph of channels, with an arrow from each to
/// the one that a packet may take next, has no cycle.
fn channels(topology: &Topology, classes: bool) -> DiGraphMap<(u16, u16, u8), ()> {
    let mut graph = DiGraphMap::new();
    for from in ids(topology) {
        for to in ids(topology) {
            let (mut here, mut held) = (from, None);
            while let Some(hop) = topology.route(here, to) {
                assert!(hop.class < topology.classes());
                let channel = (here.0, hop.port.0, if classes { hop.class } else { 0 });
                graph.add_node(channel);
                if let Some(held) = held.replace(channel) {
                    graph.add_edge(held, channel, ());
                }
                here = topology.neighbour(here, hop.port).unwrap();
            }
        }
    }
    graph
}

#[test]
fn no_cycle_of_channels() {
    for (name, topology) in shapes() {
        assert!(!is_cyclic_directed(&channels(&topology, true)), "{name}");
    }
}

#[test]
fn without_classes_a_ring_has_a_cycle() {
    let ring = Topology::parse("ring", 4).unwrap();
    assert!(is_cyclic_directed(&channels(&ring, false)));
}

#[test]
fn what_does_not_exist_has_no_route() {
    for (name, topology) in shapes() {
        let outside = NodeId(topology.nodes());
        assert_eq!(topology.route(NodeId(0), outside), None, "{name}");
        assert_eq!(topology.route(outside, NodeId(0)), None, "{name}");
        assert_eq!(topology.route(NodeId(0), NodeId(0)), None, "{name}");
        assert_eq!(topology.neighbour(outside, Port(0)), None, "{name}");
        assert_eq!(topology.neighbour(NodeId(0), Port(u16::MAX)), None, "{name}");
    }
}
