//! Topologies of any size and the credits of a link, for packets of any number.
#![no_std]
#![no_main]

use core::hint::black_box;
use kiloray_core::network::{CreditReceiver, CreditSender, Grid, NodeId, Port, Sequence, Topology};
use kiloray_no_panic::{any, any_bytes, any_room, entry, print};

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

entry!({
    topology(&Topology::Tree { nodes: any(), arity: any() });
    topology(&Topology::Full { nodes: any() });
    if let Some(grid) = Grid::new(any_room(&mut [1; 4]), any::<u8>() == 0) {
        topology(&Topology::Grid(grid));
    }
    if let Ok(text) = core::str::from_utf8(any_bytes()) {
        match Topology::parse(text, any()) {
            Ok(parsed) => topology(&parsed),
            Err(error) => print(&error),
        }
    }
    credits();
});
