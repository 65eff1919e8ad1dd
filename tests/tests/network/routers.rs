//! Routers joined by wires: with one buffer to a lane and every wire full, all packets arrive, and in a network that
//! loses, doubles and reorders, none arrives twice and the buffers come free.

use std::collections::BTreeMap;

use kiloray_core::network::{
    Channel, Fifo, NodeId, PacketHeader, Port, PortState, Received, Router, RouterMemory,
    RouterSize, Slot, Topology,
};
use proptest::prelude::*;

/// Longest payload.
const PAYLOAD: u16 = 8;

struct Mesh<'a> {
    topology: Topology,
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
    slots: Vec<Slot>,
    fifos: Vec<Fifo>,
    ports: Vec<PortState>,
    bytes: Vec<u8>,
}

impl Memory {
    fn new(topology: &Topology, size: &RouterSize) -> Self {
        let lent = |_| Lent {
            slots: vec![bytemuck::Zeroable::zeroed(); size.slots()],
            fifos: vec![Fifo::default(); size.queues()],
            ports: vec![bytemuck::Zeroable::zeroed(); usize::from(size.ports)],
            bytes: vec![0; size.bytes()],
        };
        Self((0..topology.nodes()).map(lent).collect())
    }
}

impl<'a> Mesh<'a> {
    fn new(topology: Topology, size: RouterSize, memory: &'a mut Memory, packets: usize) -> Self {
        let routers = memory.0.iter_mut().zip(0..).map(|(lent, node)| {
            let Lent { slots, fifos, ports, bytes } = lent;
            let memory = RouterMemory { slots, fifos, ports, bytes };
            Router::new(topology, NodeId(node), size, memory).expect("the memory has the size")
        });
        Self {
            topology,
            routers: routers.collect(),
            wires: BTreeMap::new(),
            arrived: vec![0; packets],
        }
    }

    /// Moves what can move on every wire and into every node; whether anything did.
    fn step(&mut self, mut fault: impl FnMut() -> Fault) -> bool {
        let mut moved = false;
        for node in 0..self.topology.nodes() {
            for port in 0..self.topology.ports() {
                let mut out = [0; PacketHeader::BYTES + PAYLOAD as usize];
                let router = &mut self.routers[usize::from(node)];
                while let Some(len) = router.transmit(Port(port), &mut out) {
                    moved = true;
                    let wire = self.wires.entry((node, port)).or_default();
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
            let far = self.topology.neighbour(node, port).expect("a wire has two ends");
            let back = self.topology.reverse(node, port).expect("a wire has two ends");
            for packet in packets {
                moved = true;
                let received = self.routers[usize::from(far.0)].receive(back, &packet, |_| false);
                assert!(received != Received::Bad);
            }
        }
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
    let size = RouterSize::new(&topology, depth, PAYLOAD);
    let mut memory = Memory::new(&topology, &size);
    let mut mesh = Mesh::new(topology, size, &mut memory, traffic.len());
    let mut waiting: Vec<u32> = (0..traffic.len() as u32).rev().collect();
    let nodes = topology.nodes();
    // Far more rounds than any of these takes: a mesh that is stuck is found, not waited for.
    for _ in 0..20_000 {
        waiting.retain(|&id| {
            let (from, to, reply) = traffic[id as usize];
            let channel = if reply { Channel::Reply } else { Channel::Request };
            let router = &mut mesh.routers[usize::from(from % nodes)];
            router.inject(NodeId(to % nodes), channel, (id % 5) as u8, &id.to_le_bytes()).is_err()
        });
        if !mesh.step(&mut fault) {
            if waiting.is_empty() && mesh.buffered() == 0 {
                break;
            }
            mesh.routers.iter_mut().for_each(Router::remind);
        }
    }
    assert!(waiting.is_empty(), "{} packets never left", waiting.len());
    (mesh.arrived.clone(), mesh.buffered())
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
        let size = RouterSize::new(&topology, 2, PAYLOAD);
        let mut memory = Memory::new(&topology, &size);
        let mut mesh = Mesh::new(topology, size, &mut memory, 0);
        for mut packet in packets {
            // Half of them look like packets, so that more than the first check is reached.
            if let [k, l, ..] = packet.as_mut_slice() && *k % 2 == 0 {
                (*k, *l) = (kind, lane);
            }
            mesh.routers[4].receive(Port(1), &packet, |node| node.0 == 7);
            prop_assert!(mesh.routers[4].buffered() <= 2 * 4);
        }
    }
}

#[test]
fn packets_for_the_dead_are_dropped_and_their_buffers_free() {
    let topology = Topology::parse("line", 3).expect("a shape that exists");
    let size = RouterSize::new(&topology, 3, PAYLOAD);
    let mut memory = Memory::new(&topology, &size);
    let mut mesh = Mesh::new(topology, size, &mut memory, 3);
    let router = &mut mesh.routers[0];
    for (id, to) in [(0_u32, 2), (1, 1), (2, 2)] {
        router.inject(NodeId(to), Channel::Request, 0, &id.to_le_bytes()).expect("there is room");
    }
    assert_eq!(router.forget(NodeId(2)), 2);
    assert_eq!((router.buffered(), router.room(Channel::Request)), (1, 2));
    while mesh.step(|| Fault::None) {}
    assert_eq!(mesh.arrived, [0, 1, 0]);
}
