//! What comes over a link: packets, and rays of other nodes.

use std::sync::LazyLock;

use bytemuck::Zeroable;
use kiloray_core::block::{BlockSource, BlockView, KiloView};
use kiloray_core::geometry::Hit;
use kiloray_core::network::{
    Channel, HOST, Mesh, NodeId, PacketHeader, Port, Router, RouterSize, Topology,
};
use kiloray_core::node::Time;
use kiloray_core::path::PathKey;
use kiloray_core::protocol::{Items, Message, RayMessage, ReturnAddress, write};
use kiloray_core::shade::{PackedHit, Path, PathRay, Sum, Unit};
use kiloray_core::store::{Arena, CHUNK_BYTES, Chunk};
use kiloray_core::trace::{Cursor, Scalar, TraceError, Tracer, Trail};
use kiloray_core::view::Camera;
use kiloray_mesh::Ledger;
use kiloray_scene::builtin;
use kiloray_scene::compile::{Options, compile};
use kiloray_scene::kilo::KiloFile;

/// Longest payload of a packet.
const PAYLOAD: usize = 2048;

/// Packets of all messages: for a node, for the host, and for one that it passes on.
pub(crate) fn packets() -> Vec<Vec<u8>> {
    let to = ReturnAddress::new(NodeId(1), 2, PathKey { path: 3, sample: 4 });
    let bytes = [7; 192];
    let messages = [
        Message::Ask { number: 0, count: 3 },
        Message::Pixels { tile: 0, first: 0, width: 8, sums: &bytes },
        Message::Pixels { tile: 1, first: 8, width: 4, sums: &bytes },
        Message::Ask { number: 1, count: 1 },
        Message::Lost { block: 9 },
        Message::Fetch { block: 1, offset: 0, request: 0 },
        Message::Part { block: 1, offset: 64, request: 0, bytes: &bytes },
        Message::Grant { number: 0, first: 0, count: 2, wait: 0 },
        Message::Accepted { tile: 0 },
        Message::Ray(&[0; RayMessage::BYTES]),
        Message::Answer { to, sum: Sum([1, 2, 3]) },
        Message::Refusal { to },
        Message::AtWork { to },
        Message::Idle,
        Message::Gone,
        Message::Tell,
        Message::Told { figures: &[3; 168] },
    ];
    let packet = |kind, to: NodeId, lane, messages: &[Message<'_>]| {
        let header = PacketHeader { kind, lane, to: to.0, from: 1, ..PacketHeader::zeroed() };
        let header = PacketHeader { sent: [1; 4], limits: [8; 4], ..header };
        let mut packet = vec![0; PacketHeader::BYTES + PAYLOAD];
        packet[..PacketHeader::BYTES].copy_from_slice(bytemuck::bytes_of(&header));
        let len = messages.iter().fold(PacketHeader::BYTES, |len, message| {
            write(&mut packet, len, message).expect("a packet holds them")
        });
        packet.truncate(len);
        packet
    };
    let mut packets = vec![
        packet(PacketHeader::CONTROL, NodeId(0), 0, &[]),
        packet(PacketHeader::DATA, HOST, 0, &messages[..5]),
        packet(PacketHeader::DATA, NodeId(0), 2, &messages),
        packet(PacketHeader::DATA, NodeId(2), 0, &messages[5..6]),
    ];
    packets.extend(
        messages.iter().map(|m| {
            packet(PacketHeader::DATA, HOST, 2 * m.channel() as u8, std::slice::from_ref(m))
        }),
    );
    packets
}

/// A packet comes to a node and to the host, and what it holds is read.
pub(crate) fn feed_packet(input: &[u8]) -> String {
    let mesh = Mesh::new(Topology::parse("mesh:2x2", 4).expect("a mesh"));
    let mut answer = String::new();
    for here in [NodeId(0), HOST] {
        let size = RouterSize::new(&mesh, here, 2, PAYLOAD as u16);
        let mut memory = vec![Chunk::ZERO; size.arena_bytes() / CHUNK_BYTES];
        let router = Router::new(&mut Arena::new(&mut memory), mesh, here, size);
        let mut router = router.expect("the memory has its size");
        let mut ledger = Ledger::new(8, 8, 4, 0, Unit::new(1.0), 1).expect("a small picture");
        // Twice: a packet may be doubled.
        for _ in 0..2 {
            let received = router.receive(Port(0), input, |node| node == NodeId(3));
            answer += &format!("{received:?} ");
        }
        let held = router.buffered();
        assert!(held <= 2, "{held} packets of one that came twice");
        for channel in Channel::ALL {
            if let Some((_, payload)) = router.arrived(channel) {
                answer += &kinds(payload);
            }
        }
        let _ = ledger.poll(Time(1), &mut router);
        answer += if ledger.lost().is_some() { "lost " } else { "" };
        assert!(ledger.pixels_done() <= ledger.pixels());
        let mut out = vec![0; PacketHeader::BYTES + PAYLOAD];
        for port in (0..mesh.ports(here)).map(Port) {
            for sent in 0.. {
                let Some(len) = router.transmit(port, &mut out) else { break };
                assert!(sent < 32 && PacketHeader::split(&out[..len]).is_some());
            }
        }
    }
    answer
}

/// The messages of a payload, by kind.
fn kinds(payload: &[u8]) -> String {
    let mut items = Items::new(payload);
    let mut kinds: Vec<_> = items
        .by_ref()
        .take(4)
        .map(|message| {
            let text = format!("{message:?}");
            text.split([' ', '(']).next().unwrap_or_default().to_owned()
        })
        .collect();
    if items.is_damaged() {
        kinds.push("damaged".to_owned());
    }
    kinds.join(" ")
}

/// A scene of many small blocks, with mirrors, glass and spheres.
pub(crate) static SCENE: LazyLock<KiloFile> = LazyLock::new(|| {
    let model = builtin::build("glass").expect("it is built in");
    let options = Options::blocks_of(1 << 10);
    let compiled = compile(&model, &options, &mut |_, _, _| {}).expect("it compiles");
    KiloFile::from_compiled(compiled)
});

/// Why a block is not here.
#[derive(Debug)]
enum Lack {
    /// It may come.
    Away,
    /// There is no such block.
    Unknown,
}

/// Lacks every second block, as long as there is patience.
struct Patchy<'a> {
    file: KiloView<'a>,
    misses: u32,
}

impl BlockSource for Patchy<'_> {
    type Error = Lack;

    fn block(&mut self, block: u32) -> Result<BlockView<'_>, Lack> {
        if block % 2 == 1 && self.misses > 0 {
            self.misses -= 1;
            return Err(Lack::Away);
        }
        self.file.block(block).map_err(|_| Lack::Unknown)
    }
}

/// Rays that were stopped on their way, as they go from node to node.
pub(crate) fn rays() -> Vec<Vec<u8>> {
    let file = SCENE.view();
    let view = file.views().first().copied().expect("it has a view");
    let camera = Camera::new(&view, 4, 4, 1).expect("it shows something");
    let mut seeds = Vec::new();
    for pixel in 0..16 {
        let key = PathKey::camera(0, pixel, 0);
        let ray = camera.ray(pixel % 4, pixel / 4, key);
        let mut cursor = Cursor::new();
        let mut trail = Trail::START;
        let mut best = None;
        for misses in 0..3 {
            seeds.push(RayMessage {
                reply: ReturnAddress::new(NodeId(1), 0, key),
                ray: PathRay::new(&ray, &Path::camera(key), 0),
                sum: [[0; 2]; 3],
                best: PackedHit::new(best.as_ref()),
                trail,
            });
            let mut source = Patchy { file, misses: 1 + misses };
            let found = Scalar.continue_closest(&mut cursor, &mut source, &ray, best, &trail);
            if found.is_ok() {
                break;
            }
            (trail, best) = (cursor.trail(), cursor.best());
        }
    }
    seeds.iter().map(|seed| bytemuck::bytes_of(seed).to_vec()).collect()
}

/// Goes on with a ray of another node, whatever its bytes say.
pub(crate) fn feed_ray(input: &[u8]) -> String {
    let mut bytes = [0; size_of::<RayMessage>()];
    let len = input.len().min(bytes.len());
    bytes[..len].copy_from_slice(&input[..len]);
    let message: RayMessage = bytemuck::pod_read_unaligned(&bytes);
    let ray = message.ray.ray();
    let file = SCENE.view();
    let mut answer = String::new();
    let mut cursor = Cursor::new();
    let mut source = Patchy { file, misses: 64 };
    let mut best = message.best.get();
    let mut trail = message.trail;
    let found = loop {
        match Scalar.continue_closest(&mut cursor, &mut source, &ray, best, &trail) {
            Err(TraceError::Source(Lack::Away)) => {
                (trail, best) = (cursor.trail(), cursor.best());
            }
            end => break end,
        }
    };
    answer += match found {
        Ok(None) => "nothing",
        Ok(Some(hit)) if is_of(&hit, file) => "hit",
        Ok(Some(_)) => "foreign",
        Err(TraceError::Source(_)) => "unknown",
        Err(TraceError::Corrupt { .. }) => "corrupt",
    };
    let mut hits = 0_u64;
    let every = Scalar.continue_every(&mut cursor, &mut { file }, &ray, &message.trail, |_| {
        hits += 1;
        false
    });
    let any = Scalar.continue_any(&mut cursor, &mut { file }, &ray, &message.trail);
    if every.is_ok() {
        assert_eq!(any.as_ref().ok(), Some(&(hits > 0)), "any hit, and every hit");
    }
    answer += match (every.is_ok(), any) {
        (_, Ok(true)) => " hidden",
        (_, Ok(false)) => " clear",
        (true, Err(_)) => " broken",
        (false, Err(_)) => " corrupt",
    };
    answer
}

/// Whether a hit is of a material of the file.
fn is_of(hit: &Hit, file: KiloView<'_>) -> bool {
    usize::from(hit.material) < file.materials().len()
}
