//! A node as a board makes it: of any share of a scene, by any setup.
#![no_std]
#![no_main]

use core::hint::black_box;
use kiloray_core::node::{Setup, Share, Time};
use kiloray_core::store::Chunk;
use kiloray_core::trace::Scalar;
use kiloray_no_panic::{any, any_bytes, any_room, entry, print};

entry!({
    match Share::parse(any_bytes()) {
        Ok(share) => {
            if let Err(error) = share.check_blocks() {
                print(&error);
            }
            black_box((share.scene(), share.here()));
            begin(&share);
        }
        Err(error) => print(&error),
    }
});

#[inline(never)]
fn begin(share: &Share<'_>) {
    let Some(setup) = Setup::parse(any_bytes()) else { return };
    let topology = setup.mesh().map(|mesh| *mesh.topology());
    let setup = topology.map_or(setup, |topology| setup.with_topology(&topology));
    let mut memory = [Chunk::ZERO; 8];
    match setup.node(share, Scalar, any_room(&mut memory)) {
        Ok(mut node) => {
            black_box(node.poll(Time(any())));
            black_box(node.router().remind());
            let here = share.here();
            black_box(node.router().mesh().joined(here).count());
        }
        Err(error) => print(&error),
    }
}
