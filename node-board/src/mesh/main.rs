//! A node of a mesh: the actor of the core over serial links, with its share of the scene in flash.
//!
//! It asks its neighbours for the setup of the run, divides its memory by it, and works until it is
//! switched off. Another board is a file of drivers beside `uart/cmsdk.rs`, and its clock in `time.rs`.
#![no_std]
#![no_main]

mod executor;
mod share;
#[cfg(feature = "stack")]
#[path = "../stack.rs"]
mod stack;
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

use text::{Of, fail, say};
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
/// Rooms of each link: what is in the task would pass over the stack.
static ROOMS: ConstStaticCell<[[[u8; ROOM_BYTES]; 3]; uart::COUNT]> =
    ConstStaticCell::new([[[0; ROOM_BYTES]; 3]; uart::COUNT]);

#[entry]
fn main() -> ! {
    #[cfg(feature = "stack")]
    stack::paint();
    executor::run(|spawner| match node() {
        Ok(token) => {
            spawner.spawn(token);
            #[cfg(feature = "stack")]
            spawner.spawn(watch().unwrap_or_else(|_| fail("executor", &"it is there already")));
        }
        Err(_) => fail("executor", &"the task is there already"),
    })
}

/// Says how deep the stack has run.
#[cfg(feature = "stack")]
#[embassy_executor::task]
async fn watch() {
    let mut most = 0;
    loop {
        embassy_time::Timer::after_millis(50).await;
        let used = stack::used_bytes();
        if used > most {
            most = used;
            text::say_number("stack", used);
        }
    }
}

#[embassy_executor::task]
async fn node() {
    time::start();
    let share = open();
    let here = share.here();
    let tallies = [const { Tally::new() }; uart::COUNT];
    let uarts = uart::start();
    let mut rooms = ROOMS
        .take()
        .each_mut()
        .map(|rooms| rooms.each_mut().map(<[u8; _]>::as_mut_slice))
        .into_iter();
    let mut links = array::from_fn::<_, { uart::COUNT }, _>(|k| {
        let rooms = rooms.next().unwrap_or_default();
        Link::new(uarts[k], uarts[k], rooms, &tallies[k])
    });
    let setup = match ask(links.each_mut(), &Ticks, ASK_EVERY).await {
        Ok(setup) => setup,
        Err(error) => fail("setup", &error),
    };
    if usize::from(setup.payload) > PAYLOAD_BYTES {
        fail("longer packets than fit", &Of(setup.payload.into(), PAYLOAD_BYTES));
    }
    // Used where it was made: moved, it would lie on the stack too.
    let mut made = setup.node(&share, Scalar, ARENA.take());
    let node = match &mut made {
        Ok(node) => node,
        Err(error) => fail("setup", error),
    };
    say("node", &Of(here.0.into(), share.placement().nodes.into()));
    // Of this node; a UART that nothing is joined to is at no port.
    let mesh = *node.router().mesh();
    let mut ports = mesh.joined(here);
    let joints = links.each_mut().map(|link| link.joint(ports.next().unwrap_or(NOWHERE), &setup));
    match run(node, joints, &Ticks, setup.reminder).await {}
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
