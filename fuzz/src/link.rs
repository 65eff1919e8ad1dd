//! What comes over a serial line, and what lies in a node's flash.

use std::future::pending;
use std::task::Poll;

use bytemuck::Zeroable;
use embassy_futures::poll_once;
use kiloray_core::network::{NodeId, Port};
use kiloray_core::node::{Clock, Dealing, Joint, Placement, Receive, Setup, Share, Time};
use kiloray_core::store::Chunk;
use kiloray_core::trace::Scalar;
use kiloray_core::view::Camera;
use kiloray_link::frame::{CRC_BYTES, Decoder, encode, frame_bytes};
use kiloray_link::{Link, Tally, ask};
use kiloray_scene::kilo;

use crate::mesh::{SCENE, packets};

/// Longest packet that the line carries.
const PACKET: usize = 600;
/// Memory of the node.
const MEMORY: usize = 24 << 10;

fn placement() -> Placement {
    let dealing = Dealing::Subtrees;
    Placement { dealing, blocks: SCENE.view().blocks(), nodes: 3, top: 1, replicas: 1 }
}

fn setup() -> Setup {
    let file = SCENE.view();
    let setup = Setup {
        version: Setup::VERSION,
        scene: file.header().crc,
        sizes: [3; 15],
        topology: 3,
        width: 16,
        height: 16,
        samples: 1,
        side: 4,
        payload: 256,
        depth: 1,
        bounces: 4,
        refusals: 1,
        camera: Camera::new(&file.views()[0], 16, 16, 1).expect("the view shows something"),
        ..Setup::zeroed()
    };
    assert!(setup.mesh().is_some());
    setup
}

/// Frames of packets, one behind the other.
pub(crate) fn streams() -> Vec<Vec<u8>> {
    packets().chunks(3).map(|packets| packets.iter().flat_map(|p| framed(p)).collect()).collect()
}

fn framed(packet: &[u8]) -> Vec<u8> {
    let mut frame = vec![0; frame_bytes(packet.len())];
    let len = encode(packet, &mut frame).expect("there is room");
    frame.truncate(len);
    frame
}

/// A line brings any bytes: frames that come out can be sent again, and come out again.
pub(crate) fn feed_frames(input: &[u8]) -> String {
    let (mut decoder, mut into) = (Decoder::new(), vec![0; PACKET + CRC_BYTES]);
    let (mut sound, mut damaged) = (0, 0);
    for &byte in input {
        match decoder.push(byte, &mut into) {
            Some(Ok(len)) => {
                sound += 1;
                let packet = &into[..len];
                let mut frame = vec![0; frame_bytes(len)];
                let end = encode(packet, &mut frame).expect("there is room");
                let (mut again, mut other) = (Decoder::new(), vec![0; len + CRC_BYTES]);
                let last = frame[..end].iter().filter_map(|&b| again.push(b, &mut other)).last();
                assert_eq!(last, Some(Ok(len)));
                assert_eq!(&other[..len], packet);
            }
            Some(Err(_)) => damaged += 1,
            None => {}
        }
    }
    ["sound "].repeat(sound.min(4)).concat() + &["damaged "].repeat(damaged.min(4)).concat()
}

/// A setup and a share of the scene, as `feed_begin` reads them.
pub(crate) fn beginnings() -> Vec<Vec<u8>> {
    let share = |node| kilo::share(&SCENE, &placement(), NodeId(node));
    (0..2).map(|node| [bytemuck::bytes_of(&setup()), &share(node)[..]].concat()).collect()
}

/// A node begins with any setup and any share.
pub(crate) fn feed_begin(input: &[u8]) -> String {
    let Some((setup, share)) = input.split_at_checked(Setup::BYTES) else { return "short".into() };
    let mut lines = vec![[0_u64; 8]; share.len().div_ceil(64)];
    bytemuck::cast_slice_mut(&mut lines)[..share.len()].copy_from_slice(share);
    let share = match Share::parse(&bytemuck::cast_slice(&lines)[..share.len()]) {
        Ok(share) => share,
        Err(error) => return error.to_string(),
    };
    let Some(setup) = Setup::parse(setup) else { return "no setup".into() };
    let mut memory = vec![Chunk::ZERO; MEMORY / size_of::<Chunk>()];
    let begun = match setup.node(&share, Scalar, &mut memory) {
        Ok(node) => format!("begun {}", node.budget().lines().is_empty()),
        Err(error) => error.to_string().chars().filter(|c| !c.is_ascii_digit()).collect(),
    };
    format!("{begun} {:?}", share.check_blocks().is_ok())
}

/// All that is said about a setup, between other packets.
pub(crate) fn starts() -> Vec<Vec<u8>> {
    let (mut question, mut answer) = (Vec::new(), Vec::new());
    asks(&[], &mut question);
    has_setup(&question, &mut answer);
    let packet = framed(&packets()[0]);
    vec![[&packet, &question, &packet[..]].concat(), [&packet, &answer, &question[..]].concat()]
}

/// A line brings any bytes to one that asks for the setup, and to one that has it: it says no more than it is asked for.
pub(crate) fn feed_start(input: &[u8]) -> String {
    let mut said = Vec::new();
    let is_told = asks(input, &mut said);
    said.clear();
    let packets = has_setup(input, &mut said);
    let answer = framed(&[0; 1 + Setup::BYTES]).len();
    // The shortest question is seven bytes: a length, what it is and its checksum, two zeros.
    assert!(said.len() <= input.len().div_ceil(7) * (answer + 2), "{}", said.len());
    let count = |count: usize, name: &str| name.repeat(count.min(4));
    format!("{is_told} {}{}", count(packets, "packet "), count(said.len() / answer, "answer "))
}

/// One that asks for the setup: whether it has got one.
fn asks(mut line: &[u8], said: &mut Vec<u8>) -> bool {
    let (tally, rooms) = (Tally::new(), [(); 3].map(|()| vec![0_u8; frame_bytes(PACKET)]));
    let mut link = Link::new(&mut line, said, rooms, &tally);
    poll_once(ask([&mut link], &Still, Time(1))).is_ready()
}

/// One that has it: how many packets reach it.
fn has_setup(mut line: &[u8], said: &mut Vec<u8>) -> usize {
    let (tally, rooms) = (Tally::new(), [(); 3].map(|()| vec![0_u8; frame_bytes(PACKET)]));
    let mut link = Link::new(&mut line, said, rooms, &tally);
    let setup = setup();
    let Joint { mut receive, incoming, .. } = link.joint(Port(0), &setup);
    let mut packets = 0;
    // The line ends: it waits for ever then.
    let _: Poll<()> = poll_once(async {
        loop {
            let len = receive.receive(incoming).await;
            assert!(len <= incoming.len());
            packets += 1;
        }
    });
    packets
}

/// Time stands still.
struct Still;

impl Clock for Still {
    fn now(&self) -> Time {
        Time(0)
    }

    async fn wait(&self, _: Time) {
        pending().await
    }
}
