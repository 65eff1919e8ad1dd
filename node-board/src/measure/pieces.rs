//! What a node on its own does not do in a picture: copying, checking, messages.
use core::hint::black_box;

use kiloray_core::block::KiloView;
use kiloray_core::network::{
    Channel, Mesh, NodeId, PacketHeader, Port, Router, RouterSize, Topology,
};
use kiloray_core::protocol::{Items, Message, write};
use kiloray_core::store::{Arena, Chunk};
use semihosting::println;

use crate::ticks;

/// How often each is done.
const TIMES: u64 = 256;
/// Payload of a packet on a board [bytes].
const PAYLOAD: usize = 200;

/// Prints how many ticks each took, how often it was done, and in how many parts.
pub(crate) fn print(file: &KiloView<'_>) {
    println!("piece copied {} {}", TIMES * PAYLOAD as u64, ticks_of(copy));
    let blocks = u64::from(file.blocks());
    let check = || {
        for block in 0..file.blocks() {
            black_box(file.check_block(block).is_ok());
        }
    };
    println!("piece checked {} {}", blocks * u64::from(file.header().block_bytes), ticks_of(check));
    let mut memory = [Chunk::ZERO; 64];
    if let Some(ticks) = messages(&mut memory) {
        println!("piece messages {} {ticks}", 2 * TIMES);
    }
}

fn ticks_of(mut what: impl FnMut()) -> u64 {
    let begin = ticks::now();
    what();
    ticks::now() - begin
}

/// Payloads of packets, as they go from buffer to buffer.
fn copy() {
    let (from, mut to) = ([1_u8; PAYLOAD], [0_u8; PAYLOAD]);
    for _ in 0..TIMES {
        black_box(&mut to).copy_from_slice(black_box(&from));
    }
}

/// A short message: written, put into a packet, over a link, and read. Of a node it is one message out, of the other one in.
fn messages(memory: &mut [Chunk]) -> Option<u64> {
    let mesh = Mesh::new(Topology::Full { nodes: 2 });
    let (here, there) = (NodeId(0), NodeId(1));
    let port = (0..mesh.ports(here)).map(Port).find(|&p| mesh.neighbour(here, p) == Some(there))?;
    let back = mesh.reverse(here, port)?;
    let mut arena = Arena::new(memory);
    let size = |node| RouterSize::new(&mesh, node, 1, 64);
    let mut near = Router::new(&mut arena, mesh, here, size(here)).ok()?;
    let mut far = Router::new(&mut arena, mesh, there, size(there)).ok()?;
    let (mut payload, mut packet) = ([0; 64], [0; 64 + PacketHeader::BYTES]);
    let mut read = 0;
    let begin = ticks::now();
    for number in 0..TIMES {
        let message = Message::Grant { number: number as u32, first: 1, count: 1, wait: 0 };
        let len = write(&mut payload, 0, &message)?;
        near.inject(there, Channel::Reply, 3, payload.get(..len)?).ok()?;
        let len = near.transmit(port, &mut packet)?;
        far.receive(back, packet.get(..len)?, |_| false);
        let (_, payload) = far.arrived(Channel::Reply)?;
        read += Items::new(payload).count() as u64;
        far.consume(Channel::Reply);
        if let Some(len) = far.transmit(back, &mut packet) {
            near.receive(port, packet.get(..len)?, |_| false);
        }
    }
    let ticks = ticks::now() - begin;
    (read == TIMES).then_some(ticks)
}
