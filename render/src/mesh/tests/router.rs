//! The ledger at a router.

use crate::Ledger;
use kiloray_core::network::{
    Channel, HOST, Mesh, NodeId, PacketHeader, Port, Received, Router, RouterSize, Topology,
};
use kiloray_core::node::{Figures, Lack, Next, Time};
use kiloray_core::protocol::{Items, Message, write};
use kiloray_core::shade::Unit;
use kiloray_core::store::{Arena, CHUNK_BYTES, Chunk};

const PAYLOAD: u16 = 96;
/// The only one.
const NODE: NodeId = NodeId(0);

/// What a router is lent.
struct Memory {
    size: RouterSize,
    chunks: Vec<Chunk>,
}

impl Memory {
    fn new(here: NodeId, depth: u16) -> Self {
        let size = RouterSize::new(&mesh(), here, depth, PAYLOAD);
        Self { size, chunks: vec![Chunk::ZERO; size.arena_bytes() / CHUNK_BYTES] }
    }

    fn router(&mut self, here: NodeId) -> Router<'_> {
        Router::new(&mut Arena::new(&mut self.chunks), mesh(), here, self.size).unwrap()
    }
}

fn mesh() -> Mesh {
    Mesh::new(Topology::parse("line", 1).unwrap())
}

/// The ports of a node and the host that lead to each other.
fn ports() -> (Port, Port) {
    let host = Port(0);
    assert_eq!(mesh().neighbour(HOST, host), Some(NODE));
    (mesh().reverse(HOST, host).unwrap(), host)
}

/// Moves all packets from one router to the other.
fn carry(from: &mut Router<'_>, to: &mut Router<'_>) {
    let (node, host) = ports();
    let (far, near) = if from.here() == HOST { (host, node) } else { (node, host) };
    let mut packet = [0; PacketHeader::BYTES + PAYLOAD as usize];
    while let Some(len) = from.transmit(far, &mut packet) {
        assert_ne!(to.receive(near, &packet[..len], |_| false), Received::Bad);
    }
}

fn payload(messages: &[Message<'_>]) -> Vec<u8> {
    let mut bytes = vec![0; usize::from(PAYLOAD)];
    let len = messages.iter().fold(0, |len, message| write(&mut bytes, len, message).unwrap());
    bytes.truncate(len);
    bytes
}

#[test]
fn packets_are_answered_one_by_one_as_there_is_room() {
    let (mut here, mut there) = (Memory::new(HOST, 1), Memory::new(NODE, 1));
    let (mut host, mut node) = (here.router(HOST), there.router(NODE));
    let mut ledger = Ledger::new(64, 64, 8, 0, Unit::new(1.0), 1).unwrap().with_askers(64);
    let (idle, full) =
        [Lack::Tiles, Lack::Credit].map(|lack| Next::Wait { until: Time::NEVER, lack }).into();
    assert_eq!(ledger.poll(Time(0), &mut host), idle);

    // Eight asks in a packet: their grants need two packets of that size, and the router has one buffer.
    let asks: Vec<_> = (0..8).map(|number| Message::Ask { number, count: 1 }).collect();
    assert!(node.inject(HOST, Channel::Request, 3, &payload(&asks)).is_ok());
    carry(&mut node, &mut host);
    assert_eq!(ledger.poll(Time(0), &mut host), full);
    // The next packet waits.
    let lost = payload(&[Message::Lost { block: 4 }]);
    assert!(node.inject(HOST, Channel::Request, 1, &lost).is_ok());
    carry(&mut host, &mut node);
    carry(&mut node, &mut host);
    let mut grants = Vec::new();
    for _ in 0..6 {
        assert!(ledger.poll(Time(0), &mut host) != Next::Now);
        while let Some((from, payload)) = node.arrived(Channel::Reply) {
            assert_eq!(from, HOST);
            grants.extend(Items::new(payload).map(|message| match message {
                Message::Grant { number, first, count: 1, .. } => (number, first),
                other => panic!("{other:?}"),
            }));
            node.consume(Channel::Reply);
        }
        carry(&mut host, &mut node);
        carry(&mut node, &mut host);
    }
    assert_eq!(grants, (0..8).map(|n| (n, n)).collect::<Vec<_>>());
    assert_eq!(ledger.lost(), Some(4));
    assert_eq!(ledger.poll(Time(0), &mut host), idle);
}

#[test]
fn what_cannot_be_read_or_answered_holds_nothing_up() {
    let (mut here, mut there) = (Memory::new(HOST, 2), Memory::new(NODE, 2));
    let (mut host, mut node) = (here.router(HOST), there.router(NODE));
    let mut ledger = Ledger::new(64, 64, 8, 0, Unit::new(1.0), 1).unwrap();
    // A good ask, then half of one.
    let mut damaged = payload(&[Message::Ask { number: 0, count: 1 }; 2]);
    damaged.truncate(damaged.len() - 6);
    assert!(node.inject(HOST, Channel::Request, 3, &damaged).is_ok());
    let mut packet = [0; PacketHeader::BYTES + PAYLOAD as usize];
    let len = node.transmit(ports().0, &mut packet).unwrap();
    // From a node that does not exist.
    let mut header: PacketHeader = bytemuck::pod_read_unaligned(&packet[..PacketHeader::BYTES]);
    header.from = 77;
    packet[..PacketHeader::BYTES].copy_from_slice(bytemuck::bytes_of(&header));
    assert_eq!(host.receive(ports().1, &packet[..len], |_| false), Received::Buffered);
    // A reply to a host.
    let reply = payload(&[Message::Accepted { tile: 0 }]);
    assert!(node.inject(HOST, Channel::Reply, 3, &reply).is_ok());
    carry(&mut node, &mut host);
    let _ = ledger.poll(Time(0), &mut host);
    let counts = ledger.counts();
    assert_eq!((counts.messages, counts.damaged, counts.unexpected), (1, 1, 1));
    assert_eq!(host.buffered(), 0);
}

#[test]
fn what_nodes_tell_of_themselves_is_kept() {
    let mut ledger = Ledger::new(64, 64, 8, 0, Unit::new(1.0), 1).unwrap();
    let mut reply = |_, _: &Message<'_>| panic!("it is no question");
    let mut bytes = [0; Figures::BYTES];
    bytes[0] = 9;
    let figures = Figures::parse(&bytes).unwrap();
    for (node, figures) in [(5, &bytes[..]), (5, &bytes), (6, &bytes[4..])] {
        ledger.on_message(Time(0), NodeId(node), &Message::Told { figures }, &mut reply);
    }
    assert_eq!(ledger.told().iter().collect::<Vec<_>>(), [(&5, &figures)]);
    assert_eq!((ledger.counts().messages, ledger.counts().bad), (2, 1));
}
