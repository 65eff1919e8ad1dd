//! Routers joined by wires: with one buffer to a lane and every wire full, all packets arrive, and in a network that
//! loses, doubles and reorders, none arrives twice and the buffers come free.

use std::collections::BTreeMap;

use kiloray_core::network::{
    Channel, HOST, Mesh, NodeId, PacketHeader, Port, Received, Router, RouterSize, Topology,
};
use kiloray_core::store::{Arena, CHUNK_BYTES, Chunk};
use proptest::prelude::*;

/// Longest payload.
const PAYLOAD: u16 = 8;

struct Network<'a> {
    mesh: Mesh,
    /// The last is the host's.
    routers: Vec<Router<'a>>,
    /// Packets on their way, by node and port that they leave by.
    wires: BTreeMap<(u16, u16), Vec<Vec<u8>>>,
    /// How often each packet has arrived.
    arrived: Vec<u32>,
}

/// Memory for the routers of a mesh.
struct Memory(Vec<Lent>);

/// What one router is lent.
struct Lent {
    size: RouterSize,
    chunks: Vec<Chunk>,
}

impl Memory {
    fn new(mesh: &Mesh, depth: u16) -> Self {
        let lent = |here| {
            // Of the host as in a run: deeper than of nodes.
            let size = RouterSize::new(mesh, here, depth, PAYLOAD).with_host(mesh, here, depth + 2);
            Lent { size, chunks: vec![Chunk::ZERO; size.arena_bytes() / CHUNK_BYTES] }
        };
        Self(places(mesh).map(lent).collect())
    }
}

/// All nodes, and the host.
fn places(mesh: &Mesh) -> impl Iterator<Item = NodeId> + use<> {
    (0..mesh.nodes()).map(NodeId).chain([HOST])
}

impl<'a> Network<'a> {
    fn new(mesh: Mesh, memory: &'a mut Memory, packets: usize) -> Self {
        let routers = memory.0.iter_mut().zip(places(&mesh)).map(|(lent, here)| {
            let mut arena = Arena::new(&mut lent.chunks);
            Router::new(&mut arena, mesh, here, lent.size).expect("the memory has the size")
        });
        Self { mesh, routers: routers.collect(), wires: BTreeMap::new(), arrived: vec![0; packets] }
    }

    fn router(&mut self, at: NodeId) -> &mut Router<'a> {
        let last = self.routers.len() - 1;
        &mut self.routers[usize::from(at.0).min(last)]
    }

    /// Moves what can move on every wire and into every node; whether anything did.
    fn step(&mut self, fault: impl FnMut() -> Fault) -> bool {
        let mut moved = self.carry(fault);
        for router in &mut self.routers {
            for channel in Channel::ALL {
                while let Some((_, payload)) = router.arrived(channel) {
                    moved = true;
                    let id = u32::from_le_bytes(payload.try_into().expect("four bytes"));
                    self.arrived[id as usize] += 1;
                    router.consume(channel);
                }
            }
        }
        moved
    }

    /// Moves what can move on every wire; whether anything did.
    fn carry(&mut self, mut fault: impl FnMut() -> Fault) -> bool {
        let mut moved = false;
        for node in places(&self.mesh) {
            for port in 0..self.mesh.ports(node) {
                let mut out = [0; PacketHeader::BYTES + PAYLOAD as usize];
                while let Some(len) = self.router(node).transmit(Port(port), &mut out) {
                    moved = true;
                    let wire = self.wires.entry((node.0, port)).or_default();
                    match fault() {
                        Fault::None => wire.push(out[..len].to_vec()),
                        Fault::Lose => {}
                        Fault::Double => wire.extend([out[..len].to_vec(), out[..len].to_vec()]),
                        Fault::Overtake => wire.insert(0, out[..len].to_vec()),
                    }
                }
            }
        }
        for ((node, port), packets) in std::mem::take(&mut self.wires) {
            let (node, port) = (NodeId(node), Port(port));
            let far = self.mesh.neighbour(node, port).expect("a wire has two ends");
            let back = self.mesh.reverse(node, port).expect("a wire has two ends");
            for packet in packets {
                moved = true;
                let received = self.router(far).receive(back, &packet, |_| false);
                assert!(received != Received::Bad);
            }
        }
        moved
    }

    fn buffered(&self) -> u32 {
        self.routers.iter().map(Router::buffered).sum()
    }
}

#[derive(Debug, Clone, Copy)]
enum Fault {
    None,
    Lose,
    Double,
    Overtake,
}

fn topologies() -> impl Strategy<Value = Topology> {
    let shapes = [
        ("line", 5),
        ("ring", 5),
        ("ring", 8),
        ("mesh:3x4", 12),
        ("torus:4x4", 16),
        ("torus:3x3x3", 27),
        ("hypercube", 16),
        ("tree:3", 13),
        ("full", 6),
    ];
    prop::sample::select(shapes.to_vec())
        .prop_map(|(name, nodes)| Topology::parse(name, nodes).expect("a shape that exists"))
}

/// A packet to send: from, to, channel.
fn traffic() -> impl Strategy<Value = Vec<(u16, u16, bool)>> {
    prop::collection::vec(any::<(u16, u16, bool)>(), 1..400)
}

/// Injects all, as fast as the routers take them, and runs until nothing moves.
fn run(
    topology: Topology,
    depth: u16,
    traffic: &[(u16, u16, bool)],
    mut fault: impl FnMut() -> Fault,
) -> (Vec<u32>, u32) {
    let mesh = Mesh::new(topology);
    let mut memory = Memory::new(&mesh, depth);
    let mut network = Network::new(mesh, &mut memory, traffic.len());
    let mut waiting: Vec<u32> = (0..traffic.len() as u32).rev().collect();
    let places: Vec<NodeId> = places(&mesh).collect();
    let place = |number: u16| places[usize::from(number) % places.len()];
    // Far more rounds than any of these takes: a mesh that is stuck is found, not waited for.
    for _ in 0..20_000 {
        waiting.retain(|&id| {
            let (from, to, reply) = traffic[id as usize];
            let channel = if reply { Channel::Reply } else { Channel::Request };
            let router = network.router(place(from));
            router.inject(place(to), channel, (id % 5) as u8, &id.to_le_bytes()).is_err()
        });
        if !network.step(&mut fault) {
            if waiting.is_empty() && network.buffered() == 0 {
                break;
            }
            let overdue = network.routers.iter_mut().map(|router| u32::from(router.remind()));
            let overdue: u32 = overdue.sum();
            assert!(overdue > 0, "{} packets wait for nothing", network.buffered());
        }
    }
    assert!(waiting.is_empty(), "{} packets never left", waiting.len());
    (network.arrived.clone(), network.buffered())
}

proptest! {
    #[test]
    fn all_arrive_with_one_buffer_to_a_lane(
        topology in topologies(),
        depth in 1_u16..3,
        traffic in traffic(),
    ) {
        let (arrived, left) = run(topology, depth, &traffic, || Fault::None);
        prop_assert!(arrived.iter().all(|&n| n == 1));
        prop_assert_eq!(left, 0);
    }

    #[test]
    fn none_arrives_twice_and_credit_heals(
        topology in topologies(),
        depth in 1_u16..4,
        traffic in traffic(),
        faults in prop::collection::vec(0_u8..8, 1..500),
    ) {
        let mut next = faults.iter().chain(std::iter::repeat(&7));
        let (arrived, left) = run(topology, depth, &traffic, || match next.next() {
            Some(0 | 1) => Fault::Lose,
            Some(2) => Fault::Double,
            Some(3) => Fault::Overtake,
            _ => Fault::None,
        });
        prop_assert!(arrived.iter().all(|&n| n <= 1));
        prop_assert_eq!(left, 0);
    }

    #[test]
    fn any_bytes_are_survived(
        packets in prop::collection::vec(prop::collection::vec(any::<u8>(), 0..48), 1..40),
        kind in 0_u8..2,
        lane in 0_u8..4,
    ) {
        let topology = Topology::parse("torus:3x3", 9).expect("a shape that exists");
        let mesh = Mesh::new(topology);
        let mut memory = Memory::new(&mesh, 2);
        let mut network = Network::new(mesh, &mut memory, 0);
        for mut packet in packets {
            // Half of them look like packets, so that more than the first check is reached.
            if let [k, l, ..] = packet.as_mut_slice() && *k % 2 == 0 {
                (*k, *l) = (kind, lane);
            }
            network.routers[4].receive(Port(1), &packet, |node| node.0 == 7);
            prop_assert!(network.routers[4].buffered() <= 2 * 4);
        }
    }
}

#[test]
fn packets_for_the_dead_are_dropped_and_their_buffers_free() {
    let topology = Topology::parse("line", 3).expect("a shape that exists");
    let mesh = Mesh::new(topology);
    let mut memory = Memory::new(&mesh, 3);
    let mut network = Network::new(mesh, &mut memory, 3);
    let router = &mut network.routers[0];
    for (id, to) in [(0_u32, 2), (1, 1), (2, 2)] {
        router.inject(NodeId(to), Channel::Request, 0, &id.to_le_bytes()).expect("there is room");
    }
    assert_eq!(router.forget(NodeId(2)), 2);
    assert_eq!((router.buffered(), router.room(Channel::Request)), (1, 2));
    while network.step(|| Fault::None) {}
    assert_eq!(network.arrived, [0, 1, 0]);
}

#[test]
fn a_link_to_a_new_router_has_all_its_credit() {
    let mesh = Mesh::new(Topology::parse("line", 3).unwrap());
    let mut memory = Memory::new(&mesh, 2);
    let mut another = Memory::new(&mesh, 2);
    let mut network = Network::new(mesh, &mut memory, 0);
    let ends = [NodeId(0), NodeId(1)].map(|node| {
        let leads = |port: &u16| mesh.neighbour(node, Port(*port)) == Some(NodeId(1 - node.0));
        (node, Port((0..mesh.ports(node)).find(leads).unwrap()))
    });
    let mut out = [0; PacketHeader::BYTES + PAYLOAD as usize];
    // Two packets lie at node 1, one of them for node 2; node 0 has no credit left.
    for to in [1, 2] {
        network.router(NodeId(0)).inject(NodeId(to), Channel::Request, 1, b"old").unwrap();
    }
    for _ in 0..2 {
        let len = network.router(NodeId(0)).transmit(ends[0].1, &mut out).unwrap();
        let received = network.router(NodeId(1)).receive(ends[1].1, &out[..len], |_| false);
        assert_eq!(received, Received::Buffered);
    }
    let Lent { size, chunks } = &mut another.0[0];
    let mut arena = Arena::new(chunks);
    network.routers[0] = Router::new(&mut arena, mesh, NodeId(0), *size).unwrap();
    network.router(NodeId(1)).renew(ends[1].1);
    assert_eq!(network.router(NodeId(1)).buffered(), 0);
    // Both ends have all their credit, and what they send finds room.
    for ((from, by), (to, back)) in [(ends[0], ends[1]), (ends[1], ends[0])] {
        for channel in Channel::ALL {
            for _ in 0..2 {
                network.router(from).inject(to, channel, 1, b"new").unwrap();
                let len = network.router(from).transmit(by, &mut out).unwrap();
                let received = network.router(to).receive(back, &out[..len], |_| false);
                assert_eq!(received, Received::Buffered);
            }
            assert_eq!(network.router(to).arrived(channel), Some((from, &b"new"[..])));
        }
    }
}

#[test]
fn what_was_to_leave_by_a_link_that_is_gone_is_dropped() {
    let mesh = Mesh::new(Topology::parse("line", 3).unwrap());
    let mut memory = Memory::new(&mesh, 2);
    let mut network = Network::new(mesh, &mut memory, 0);
    let port = |node, to| {
        let leads = |port: &u16| mesh.neighbour(NodeId(node), Port(*port)) == Some(NodeId(to));
        Port((0..mesh.ports(NodeId(node))).find(leads).unwrap())
    };
    let mut out = [0; PacketHeader::BYTES + PAYLOAD as usize];
    // From node 0 to node 2, which is gone, and behind it one that stays at node 1.
    for to in [2, 1] {
        network.router(NodeId(0)).inject(NodeId(to), Channel::Request, 1, b"passes").unwrap();
        let len = network.router(NodeId(0)).transmit(port(0, 1), &mut out).unwrap();
        network.router(NodeId(1)).receive(port(1, 0), &out[..len], |_| false);
    }
    let router = network.router(NodeId(1));
    router.inject(NodeId(2), Channel::Request, 1, b"mine").unwrap();
    assert_eq!(router.arrived(Channel::Request), None);
    assert_eq!(router.cut(port(1, 2)), 2);
    assert_eq!(router.cut(port(1, 2)), 0);
    assert_eq!(router.arrived(Channel::Request), Some((NodeId(0), &b"passes"[..])));
    assert_eq!((router.buffered(), router.transmit(port(1, 2), &mut out)), (1, None));
}

#[test]
fn what_is_held_leaves_when_it_is_released() {
    let mesh = Mesh::new(Topology::parse("line", 2).expect("a shape that exists"));
    let mut memory = Memory::new(&mesh, 3);
    let mut network = Network::new(mesh, &mut memory, 2);
    let router = &mut network.routers[0];
    let mut send = |id: u32| {
        let sent = router.inject(NodeId(1), Channel::Request, 0, &id.to_le_bytes());
        sent.expect("there is room");
        router.hold();
    };
    send(0);
    send(1);
    while network.step(|| Fault::None) {}
    assert_eq!(network.arrived, [1, 0]);
    network.routers[0].release();
    while network.step(|| Fault::None) {}
    assert_eq!(network.arrived, [1, 1]);
}

/// A packet that is lost, and an answer that is lost: the sender asks again, and then has all its credit.
#[test]
fn who_asks_for_credit_gets_it() {
    let mesh = Mesh::new(Topology::parse("line", 2).expect("a shape that exists"));
    let mut memory = Memory::new(&mesh, 1);
    let mut network = Network::new(mesh, &mut memory, 2);
    assert!(!network.routers[0].remind(), "all credit is here");
    let send = |network: &mut Network<'_>, id: u32| {
        let sent = network.routers[0].inject(NodeId(1), Channel::Request, 0, &id.to_le_bytes());
        sent.expect("there is room");
    };
    send(&mut network, 0);
    while network.step(|| Fault::Lose) {}
    send(&mut network, 1);
    assert!(!network.step(|| Fault::None), "there is no credit");
    for lost in [0, 1] {
        assert!(network.routers[0].remind());
        let mut packets = 0;
        while network.step(|| {
            packets += 1;
            if packets == 1 + lost { Fault::Lose } else { Fault::None }
        }) {}
        assert_eq!(network.arrived[1], 0);
    }
    assert!(network.routers[0].remind());
    while network.step(|| Fault::None) {}
    assert_eq!(network.arrived, [0, 1]);
    assert!(!network.routers[0].remind(), "all credit is here again");
}

/// Both neighbours of a node send all they can, one of them more urgently; the node takes one packet at a time.
#[test]
fn no_link_starves_at_the_node_that_consumes() {
    for priorities in [[0, 0], [4, 0], [0, 4]] {
        let mesh = Mesh::new(Topology::parse("line", 3).expect("a shape that exists"));
        let mut memory = Memory::new(&mesh, 2);
        let mut network = Network::new(mesh, &mut memory, 0);
        let mut taken = [0; 2];
        for _ in 0..400 {
            for (from, priority) in [0, 2].into_iter().zip(priorities) {
                let router = network.router(NodeId(from));
                while router.inject(NodeId(1), Channel::Request, priority, &[]).is_ok() {}
            }
            network.carry(|| Fault::None);
            let node = network.router(NodeId(1));
            let (from, _) = node.arrived(Channel::Request).expect("there always is one");
            taken[usize::from(from.0 / 2)] += 1;
            node.consume(Channel::Request);
        }
        assert!(taken.iter().all(|&taken| taken >= 400 / 6), "{priorities:?}: {taken:?}");
    }
}

/// All nodes of a line send all they can to the first one, which takes one packet at a time: with turns alone, each hop would halve what the nodes behind it get.
#[test]
fn far_nodes_get_their_part() {
    const NODES: u16 = 8;
    let mesh = Mesh::new(Topology::parse("line", NODES.into()).expect("a shape that exists"));
    let mut memory = Memory::new(&mesh, 2);
    let mut network = Network::new(mesh, &mut memory, 0);
    let mut taken = [0; NODES as usize];
    for _ in 0..8000 {
        for from in 1..NODES {
            let router = network.router(NodeId(from));
            while router.inject(NodeId(0), Channel::Request, 0, &[]).is_ok() {}
        }
        network.carry(|| Fault::None);
        let node = network.router(NodeId(0));
        if let Some((from, _)) = node.arrived(Channel::Request) {
            taken[usize::from(from.0)] += 1;
            node.consume(Channel::Request);
        }
    }
    assert!(taken[1..].iter().all(|&taken| taken >= 8000 / 7 / 3), "{taken:?}");
}
