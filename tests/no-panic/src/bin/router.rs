//! A router of any size, with packets of any bytes from any port.
#![no_std]
#![no_main]

use core::hint::black_box;
use kiloray_core::network::{
    Channel, Fifo, NodeId, Port, PortState, Router, RouterMemory, RouterSize, Slot, Topology,
};
use kiloray_core::store::{Arena, Chunk};
use kiloray_no_panic::{any, any_bytes, any_room, entry};

fn channel() -> Channel {
    if any::<u8>() == 0 { Channel::Request } else { Channel::Reply }
}

#[inline(never)]
fn packets(router: &mut Router<'_>, out: &mut [u8]) {
    for _ in 0..any::<u32>() {
        let _ = black_box(router.inject(NodeId(any()), channel(), any(), any_bytes()));
        black_box(router.receive(Port(any()), any_bytes(), |_| any::<u8>() == 0));
        black_box(router.arrived(channel()));
        router.consume(channel());
        black_box(router.transmit(Port(any()), out));
        router.remind();
        black_box((router.forget(NodeId(any())), router.buffered(), router.room(channel())));
    }
}

entry!({
    let mut memory = [Chunk::ZERO; 8];
    let mut arena = Arena::new(any_room(&mut memory));
    let topology = Topology::Tree { nodes: any(), arity: any() };
    let size = RouterSize::new(&topology, any(), any());
    if let (Ok(slots), Ok(fifos), Ok(ports), Ok(bytes), Ok(out)) = (
        arena.carve::<Slot>(any()),
        arena.carve::<Fifo>(any()),
        arena.carve::<PortState>(any()),
        arena.carve::<u8>(any()),
        arena.carve::<u8>(any()),
    ) {
        let memory = RouterMemory { slots, fifos, ports, bytes };
        if let Some(mut router) = Router::new(topology, NodeId(any()), size, memory) {
            packets(&mut router, out);
        }
    }
});
