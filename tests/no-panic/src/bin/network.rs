//! Topologies of any size and the credits of a link, for packets of any number.
#![no_std]
#![no_main]

use core::hint::black_box;
use kiloray_core::network::{
    Channel, CreditReceiver, CreditSender, Grid, Mesh, NodeId, Port, Router, Sequence, Topology,
};
use kiloray_core::store::{Arena, Chunk};
use kiloray_no_panic::{any, any_bytes, any_room, any_router_size, entry, print};

#[inline(never)]
fn topology(topology: &Topology) {
    black_box((topology.nodes(), topology.classes(), topology.ports()));
    black_box((
        topology.neighbour(NodeId(any()), Port(any())),
        topology.reverse(NodeId(any()), Port(any())),
    ));
    black_box((
        topology.route(NodeId(any()), NodeId(any())),
        topology.distance(NodeId(any()), NodeId(any())),
    ));
}

#[inline(never)]
fn mesh(mesh: &Mesh) {
    black_box((mesh.nodes(), mesh.classes(), mesh.ports(NodeId(any())), mesh.attached().len()));
    black_box((
        mesh.neighbour(NodeId(any()), Port(any())),
        mesh.reverse(NodeId(any()), Port(any())),
    ));
    black_box((
        mesh.route(NodeId(any()), NodeId(any())),
        mesh.distance(NodeId(any()), NodeId(any())),
    ));
}

#[inline(never)]
fn credits() {
    let (mut sender, mut receiver) = (CreditSender::new(any()), CreditReceiver::new(any()));
    for _ in 0..any::<u32>() {
        black_box((sender.available(), sender.probe(), sender.take()));
        sender.grant(Sequence(any()));
        black_box((receiver.receive(Sequence(any())), receiver.probe(Sequence(any()))));
        receiver.release();
        black_box(receiver.limit());
    }
}

#[inline(never)]
fn router(mesh: Mesh, memory: &mut [Chunk]) {
    let size = any_router_size().with_host(&mesh, NodeId(any()), any());
    let router = Router::new(&mut Arena::new(memory), mesh, NodeId(any()), size);
    let Ok(mut router) = router else { return };
    for _ in 0..any::<u32>() {
        for channel in Channel::ALL {
            black_box(router.inject(NodeId(any()), channel, any(), any_bytes()).is_ok());
            black_box((router.room(channel), router.arrived(channel)));
            router.consume(channel);
        }
        black_box(router.receive(Port(any()), any_bytes(), |node| node.0 == any::<u16>()));
        black_box(router.transmit(Port(any()), any_room(&mut [0; 64])));
        black_box((router.forget(NodeId(any())), router.buffered()));
        black_box(router.cut(Port(any())));
        router.renew(Port(any()));
        black_box((router.remind(), router.peak(Port(any())), router.buffers(Port(any()))));
        black_box((router.take_changed(), router.take_news()));
        black_box(router.may_send(Port(any())));
        router.discard();
        router.hold();
        router.release();
    }
}

entry!({
    topology(&Topology::Tree { nodes: any(), arity: any() });
    topology(&Topology::Full { nodes: any() });
    mesh(&Mesh::new(Topology::Tree { nodes: any(), arity: any() }));
    router(Mesh::new(Topology::Full { nodes: any() }), any_room(&mut [Chunk::ZERO; 64]));
    if let Some(grid) = Grid::new(any_room(&mut [1; 4]), any::<u8>() == 0) {
        topology(&Topology::Grid(grid));
        mesh(&Mesh::new(Topology::Grid(grid)));
    }
    if let Ok(text) = core::str::from_utf8(any_bytes()) {
        match Topology::parse(text, any()) {
            Ok(parsed) => topology(&parsed),
            Err(error) => print(&error),
        }
    }
    credits();
});
