//! A node of a mesh: the actor of the core over serial links, with its share of the scene in flash.
//!
//! It asks its neighbours for the setup of the run, divides its memory by it, and works until it is
//! switched off. Another board is a file of drivers beside `uart/cmsdk.rs`, and its clock in `time.rs`.
#![no_std]
#![no_main]

mod executor;
mod share;
mod text;
mod time;
mod uart;

use core::array;

use cortex_m_rt::entry;
use kiloray_core::network::{PacketHeader, Port};
use kiloray_core::node::{Setup, Share, Time, run};
use kiloray_core::store::Chunk;
use kiloray_core::trace::Scalar;
use kiloray_link::frame::frame_bytes;
use kiloray_link::{Link, Tally, ask};
use static_cell::ConstStaticCell;

use text::{fail, say};
use time::Ticks;

/// All memory that the actor uses.
#[cfg(feature = "mps2")]
const ARENA_BYTES: usize = 64 << 10;
#[cfg(not(feature = "mps2"))]
const ARENA_BYTES: usize = 32 << 10;

/// Greatest payload of a packet that it can carry; the setup says which it is.
const PAYLOAD_BYTES: usize = 256;
/// Room for the frame of a packet; that of the setup is shorter.
const ROOM_BYTES: usize = frame_bytes(PacketHeader::BYTES + PAYLOAD_BYTES);
const _: () = assert!(ROOM_BYTES >= frame_bytes(1 + Setup::BYTES));
/// A port that no node has.
const NOWHERE: Port = Port(u16::MAX);
/// How often a node that has no setup asks for one.
const ASK_EVERY: Time = Time(250_000_000);

static ARENA: ConstStaticCell<[Chunk; ARENA_BYTES / size_of::<Chunk>()]> =
    ConstStaticCell::new([Chunk::ZERO; ARENA_BYTES / size_of::<Chunk>()]);
#[entry]
fn main() -> ! {
    executor::run(|spawner| match node() {
        Ok(token) => spawner.spawn(token),
        Err(_) => fail("executor", &"the task is there already"),
    })
}

#[embassy_executor::task]
async fn node() {
    time::start();
    let share = open();
    let here = share.here();
    let tallies = [const { Tally::new() }; uart::COUNT];
    let uarts = uart::start();
    let mut links = array::from_fn::<_, { uart::COUNT }, _>(|k| {
        Link::new(uarts[k], uarts[k], [[0; ROOM_BYTES]; 3], &tallies[k])
    });
    let setup = match ask(links.each_mut(), &Ticks, ASK_EVERY).await {
        Ok(setup) => setup,
        Err(error) => fail("setup", &error),
    };
    if usize::from(setup.payload) > PAYLOAD_BYTES {
        fail("setup", &format_args!("packets of {} bytes: {} fit", setup.payload, PAYLOAD_BYTES));
    }
    let mut node = match setup.node(&share, Scalar, ARENA.take()) {
        Ok(node) => node,
        Err(error) => fail("setup", &error),
    };
    say("node", &format_args!("{} of {}", here.0, share.placement().nodes));
    // Of this node; a UART that nothing is joined to is at no port.
    let mesh = *node.router().mesh();
    let mut ports = mesh.joined(here);
    let joints = links.each_mut().map(|link| link.joint(ports.next().unwrap_or(NOWHERE), &setup));
    match run(&mut node, joints, &Ticks, setup.reminder).await {}
}

/// The share of the scene in flash.
fn open() -> Share<'static> {
    let share = match Share::parse(share::bytes()) {
        Ok(share) => share,
        Err(error) => fail("share", &error),
    };
    match share.check_blocks() {
        Ok(()) => share,
        Err(error) => fail("share", &error),
    }
}
