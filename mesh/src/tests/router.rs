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
    /// The host has room for one packet more.
    fn new(here: NodeId, depth: u16) -> Self {
        let size = RouterSize::new(&mesh(), here, depth, PAYLOAD);
        let size = size.with_host(&mesh(), here, depth + 1);
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

/// What is not to be waited for: requests, and room.
fn waits() -> (Next, Next) {
    [Lack::Tiles, Lack::Credit].map(|lack| Next::Wait { until: Time::NEVER, lack }).into()
}

/// A packet of eight requests for a tile.
fn asks(first: u32) -> Vec<u8> {
    let asks = (first..first + 8).map(|number| Message::Ask { number, count: 1 });
    payload(&asks.collect::<Vec<_>>())
}

/// Takes what has come to a node: number and place of grants, packet by packet.
fn take_grants(node: &mut Router<'_>) -> Vec<Vec<(u32, u32)>> {
    let mut packets = Vec::new();
    while let Some((from, payload)) = node.arrived(Channel::Reply) {
        assert_eq!(from, HOST);
        let grants = Items::new(payload).map(|message| match message {
            Message::Grant { number, first, count: 1, .. } => (number, first),
            other => panic!("{other:?}"),
        });
        packets.push(grants.collect());
        node.consume(Channel::Reply);
    }
    packets
}

#[test]
fn packets_are_answered_as_there_is_room() {
    let (mut here, mut there) = (Memory::new(HOST, 1), Memory::new(NODE, 1));
    let (mut host, mut node) = (here.router(HOST), there.router(NODE));
    let mut ledger = Ledger::new(64, 64, 8, 0, Unit::new(1.0), 1).unwrap().with_askers(64);
    let (idle, full) = waits();
    assert_eq!(ledger.poll(Time(0), &mut host), idle);

    // Sixteen grants need six short packets, and the router has two buffers.
    for first in [0, 8] {
        assert!(node.inject(HOST, Channel::Request, 3, &asks(first)).is_ok());
        carry(&mut node, &mut host);
        assert_eq!(ledger.poll(Time(0), &mut host), full);
    }
    // The next packet does not wait for them.
    let lost = payload(&[Message::Lost { block: 4 }]);
    assert!(node.inject(HOST, Channel::Request, 1, &lost).is_ok());
    carry(&mut host, &mut node);
    carry(&mut node, &mut host);
    assert_eq!(ledger.poll(Time(0), &mut host), full);
    assert_eq!(ledger.lost(), Some(4));
    let mut grants = Vec::new();
    for _ in 0..9 {
        grants.extend(take_grants(&mut node).concat());
        carry(&mut node, &mut host);
        let _ = ledger.poll(Time(0), &mut host);
        carry(&mut host, &mut node);
    }
    assert_eq!(grants, (0..16).map(|n| (n, n)).collect::<Vec<_>>());
    assert_eq!(ledger.poll(Time(0), &mut host), idle);
}

#[test]
fn answers_that_wait_share_packets_and_are_not_without_end() {
    let (mut here, mut there) = (Memory::new(HOST, 1), Memory::new(NODE, 1));
    let (mut host, mut node) = (here.router(HOST), there.router(NODE));
    let mut ledger = Ledger::new(1024, 1024, 8, 0, Unit::new(1.0), 1).unwrap().with_askers(64);
    let (idle, full) = waits();
    // Nobody takes the answers.
    let mut asked = 0;
    while node.inject(HOST, Channel::Request, 3, &asks(8 * asked)).is_ok() {
        asked += 1;
        carry(&mut node, &mut host);
        let _ = ledger.poll(Time(0), &mut host);
        carry(&mut host, &mut node);
        assert!(asked < 10_000);
    }
    assert_eq!(ledger.poll(Time(0), &mut host), full);
    assert!(host.arrived(Channel::Request).is_some());
    // Now it does: all come, in their order, as many in a packet as there is room for.
    let mut packets = Vec::new();
    while ledger.poll(Time(0), &mut host) != idle || node.arrived(Channel::Reply).is_some() {
        packets.extend(take_grants(&mut node));
        carry(&mut node, &mut host);
        carry(&mut host, &mut node);
    }
    packets.extend(take_grants(&mut node));
    let numbers: Vec<_> = packets.concat().into_iter().map(|(number, _)| number).collect();
    assert_eq!(numbers, (0..8 * asked).collect::<Vec<_>>());
    let most = packets.iter().map(Vec::len).max().unwrap();
    assert!(most > 1 && packets.len() < numbers.len().div_ceil(most) + 8, "{most}");
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
