//! What comes over a serial line, and what lies in a node's flash.

use bytemuck::Zeroable;
use kiloray_core::network::NodeId;
use kiloray_core::node::{Dealing, Placement, Setup, Share};
use kiloray_core::store::Chunk;
use kiloray_core::trace::Scalar;
use kiloray_core::view::Camera;
use kiloray_link::frame::{CRC_BYTES, Decoder, encode, frame_bytes};
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
        camera: Camera::new(&file.views()[0], 16, 16).expect("the view shows something"),
        ..Setup::zeroed()
    };
    assert!(setup.mesh().is_some());
    setup
}

/// Frames of packets, one behind the other.
pub(crate) fn streams() -> Vec<Vec<u8>> {
    let framed = |packet: &Vec<u8>| {
        let mut frame = vec![0; frame_bytes(packet.len())];
        let len = encode(packet, &mut frame).expect("there is room");
        frame.truncate(len);
        frame
    };
    packets().chunks(3).map(|packets| packets.iter().flat_map(framed).collect()).collect()
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
