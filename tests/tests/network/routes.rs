//! Every route is shortest, and no set of routes can close a cycle of waiting buffers.

use std::collections::{BTreeMap, VecDeque};

use kiloray_core::network::{HOST, Hop, Mesh, NodeId, Port, Topology};
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

fn shapes() -> impl Iterator<Item = (&'static str, Mesh)> {
    SHAPES.iter().map(|&(name, nodes)| (name, Mesh::new(Topology::parse(name, nodes).unwrap())))
}

/// All nodes, and the host.
fn places(mesh: &Mesh) -> impl Iterator<Item = NodeId> + use<> {
    (0..mesh.nodes()).map(NodeId).chain([HOST])
}

fn neighbours(mesh: &Mesh, node: NodeId) -> impl Iterator<Item = (Port, NodeId)> {
    (0..mesh.ports(node)).map(Port).filter_map(move |p| Some((p, mesh.neighbour(node, p)?)))
}

/// The steps of a route, each from its node.
fn walk(mesh: &Mesh, from: NodeId, to: NodeId) -> Vec<(NodeId, Hop)> {
    let mut here = from;
    let mut steps = Vec::new();
    while let Some(hop) = mesh.route(here, to) {
        steps.push((here, hop));
        here = mesh.neighbour(here, hop.port).expect("a route takes links");
    }
    assert_eq!(here, to);
    steps
}

/// Steps from `from` to every place, by a search that knows only who is next to whom. The host passes nothing on.
fn distances(mesh: &Mesh, from: NodeId) -> BTreeMap<NodeId, u16> {
    let mut found = BTreeMap::from([(from, 0)]);
    let mut queue = VecDeque::from([from]);
    while let Some(node) = queue.pop_front() {
        if node == HOST && from != HOST {
            continue;
        }
        for (_, next) in neighbours(mesh, node) {
            let distance = found[&node] + 1;
            found.entry(next).or_insert_with(|| {
                queue.push_back(next);
                distance
            });
        }
    }
    found
}

#[test]
fn links_lead_both_ways() {
    for (name, mesh) in shapes() {
        for node in places(&mesh) {
            for (port, far) in neighbours(&mesh, node) {
                let back = mesh.reverse(node, port).unwrap();
                assert_eq!(mesh.neighbour(far, back), Some(node), "{name} {node:?} {port:?}");
                assert_eq!(mesh.reverse(far, back), Some(port), "{name} {node:?} {port:?}");
            }
        }
    }
}

#[test]
fn routes_are_shortest() {
    for (name, mesh) in shapes() {
        for from in places(&mesh) {
            for (to, shortest) in distances(&mesh, from) {
                let steps = walk(&mesh, from, to).len();
                assert_eq!(steps, usize::from(shortest), "{name} {from:?} {to:?}");
                assert_eq!(mesh.distance(from, to), shortest, "{name} {from:?} {to:?}");
            }
        }
    }
}

#[test]
fn the_host_is_attached_at_both_ends() {
    for (name, mesh) in shapes() {
        let farthest = (0..mesh.nodes()).map(|n| mesh.topology().distance(NodeId(0), NodeId(n)));
        let [first, rest @ ..] = mesh.attached() else { panic!() };
        assert_eq!(*first, NodeId(0), "{name}");
        assert_eq!(rest.len(), usize::from(mesh.nodes() > 1), "{name}");
        for far in rest {
            assert_eq!(Some(mesh.topology().distance(*first, *far)), farthest.clone().max());
        }
    }
}

/// Dally & Seitz 1987, theorem 1: routes are free of deadlock if the graph of channels, with an arrow from each to
/// the one that a packet may take next, has no cycle.
fn channels(mesh: &Mesh, classes: bool) -> DiGraphMap<(u16, u16, u8), ()> {
    let mut graph = DiGraphMap::new();
    for from in places(mesh) {
        for to in places(mesh) {
            let mut held = None;
            for (here, hop) in walk(mesh, from, to) {
                assert!(hop.class < mesh.classes());
                let channel = (here.0, hop.port.0, if classes { hop.class } else { 0 });
                graph.add_node(channel);
                if let Some(held) = held.replace(channel) {
                    graph.add_edge(held, channel, ());
                }
            }
        }
    }
    graph
}

#[test]
fn no_cycle_of_channels() {
    for (name, mesh) in shapes() {
        assert!(!is_cyclic_directed(&channels(&mesh, true)), "{name}");
    }
}

#[test]
fn without_classes_a_ring_has_a_cycle() {
    let ring = Mesh::new(Topology::parse("ring", 4).unwrap());
    assert!(is_cyclic_directed(&channels(&ring, false)));
}

#[test]
fn what_does_not_exist_has_no_route() {
    for (name, mesh) in shapes() {
        let outside = NodeId(mesh.nodes());
        for inside in [NodeId(0), HOST] {
            assert_eq!(mesh.route(inside, outside), None, "{name}");
            assert_eq!(mesh.route(outside, inside), None, "{name}");
            assert_eq!(mesh.distance(inside, outside), 0, "{name}");
            assert_eq!(mesh.route(inside, inside), None, "{name}");
            assert_eq!(mesh.neighbour(inside, Port(u16::MAX)), None, "{name}");
        }
        assert_eq!(mesh.neighbour(outside, Port(0)), None, "{name}");
    }
}
