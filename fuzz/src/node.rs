//! A node of a mesh, to which the host and another node say anything.

use kiloray_core::network::{
    Channel, HOST, LANES, Lane, Mesh, NodeId, PacketHeader, Port, Topology,
};
use kiloray_core::node::{
    Dealing, Next, Node, NodeNeeds, NodePlan, Picture, Placement, PointHome, Prefetch, Rom,
    Schedule, Settings, ShadowPolicy, TaskOrder, Time,
};
use kiloray_core::protocol::{Items, Message, RayMessage, write};
use kiloray_core::render::Tiling;
use kiloray_core::shade::{self, SPLITS, Shader, Tables};
use kiloray_core::store::{Arena, CHUNK_BYTES, Chunk};
use kiloray_core::trace::Scalar;
use kiloray_core::view::Camera;

use crate::mesh::{SCENE, rays};

/// Memory of the node: few rays and frames, so that they run out.
const MEMORY: usize = 24 << 10;
const HERE: NodeId = NodeId(0);
const OTHER: NodeId = NodeId(1);
/// Steps after a packet at most.
const STEPS: u32 = 256;
/// Between two steps [ns].
const STEP: u64 = 20_000;

/// What an input is made of: who speaks, on which channel, and the payload behind its length.
const RECORD_BYTES: usize = 4;

fn record(stream: &mut Vec<u8>, from: NodeId, channel: Channel, payload: &[u8]) {
    let is_host = u8::from(from == HOST);
    stream.extend([is_host, channel as u8]);
    stream.extend((payload.len() as u16).to_le_bytes());
    stream.extend(payload);
}

/// A node, and the far ends of its links.
struct Bench<'a> {
    node: Node<'a, Picture<'a, Scalar>>,
    mesh: Mesh,
    payload: usize,
    now: Time,
    /// Packets that were brought to it, by port and lane.
    brought: [[u16; LANES]; 4],
    /// Buffers at either end of a link.
    depth: u16,
    /// Packets that it was given credit for.
    limits: [[u16; LANES]; 4],
    /// What it has said: to whom, and the payload.
    said: Vec<(NodeId, Vec<u8>)>,
}

impl<'a> Bench<'a> {
    fn plan(schedule: Schedule) -> (NodePlan, Settings, Mesh) {
        let file = SCENE.view();
        let mesh = Mesh::new(Topology::parse("line", 2).expect("a line"));
        let placement = Placement {
            dealing: Dealing::RoundRobin,
            blocks: file.blocks(),
            nodes: 2,
            top: 1,
            replicas: 1,
        };
        let block_bytes = file.limits().block_bytes;
        let owned = Rom::of_file(&[], block_bytes, placement, HERE).len();
        let needs = NodeNeeds {
            mesh,
            here: HERE,
            block_bytes,
            remote: file.blocks() as usize - owned,
            owned: 0,
            splits: SPLITS as usize,
            schedule,
            shadow: ShadowPolicy::Steal,
            points: PointHome::Owner,
            group: 0,
            side: 4,
            packet: 0,
            depth: 0,
            host_depth: 0,
        };
        let plan = NodePlan::new(MEMORY, &needs).expect("a plan");
        let settings = Settings {
            schedule,
            shadow: ShadowPolicy::Steal,
            points: PointHome::Owner,
            placement,
            refusals: 1,
            prefetch: Prefetch::All,
            order: TaskOrder::Ready,
            patience: Time(1 << 20),
            bundle_age: Time(1 << 12),
            group: 0,
            deaths_told: false,
        };
        (plan, settings, mesh)
    }

    fn new(memory: &'a mut [Chunk], schedule: Schedule) -> Self {
        let file = SCENE.view();
        let (plan, settings, mesh) = Self::plan(schedule);
        let view = file.views().first().expect("it has a view");
        let camera = Camera::new(view, 8, 8, 1).expect("it shows something");
        let shading = shade::Settings { samples: 1, ..shade::Settings::default() };
        let tiling = Tiling::new(8, 8, 4);
        let world = Picture::new(
            Scalar,
            Shader::new(Tables::of(&file), shading),
            camera,
            tiling,
            file.limits(),
        );
        let block_bytes = file.limits().block_bytes;
        let rom = Rom::of_file(file.block_section(), block_bytes, settings.placement, HERE);
        let budget = plan.budget(MEMORY).expect("it fits");
        let mut arena = Arena::new(memory);
        let node = Node::new(&mut arena, &plan, budget, settings, rom, mesh, world);
        let depth = plan.router.depth;
        Self {
            node: node.expect("it fits"),
            mesh,
            payload: plan.payload(),
            now: Time(0),
            brought: [[0; LANES]; 4],
            depth,
            limits: [[depth; LANES]; 4],
            said: Vec::new(),
        }
    }

    /// Brings a packet, as the link from its sender would. One without a message comes after a while.
    fn bring(&mut self, from: NodeId, channel: Channel, payload: &[u8]) {
        if payload.is_empty() {
            self.now = self.now.after(Time(1 << 20));
        }
        let ports = (0..self.mesh.ports(HERE)).map(Port);
        let port = ports.into_iter().find(|&port| self.mesh.neighbour(HERE, port) == Some(from));
        let port = port.expect("they are neighbours");
        let at = usize::from(port.0);
        let lane = Lane::new(channel, 0).index();
        self.brought[at][lane] = self.brought[at][lane].wrapping_add(1);
        let header = PacketHeader {
            kind: PacketHeader::DATA,
            lane: lane as u8,
            priority: 3,
            _zero: 0,
            to: HERE.0,
            from: from.0,
            limits: self.limits[at],
            sent: self.brought[at],
        };
        let payload = &payload[..payload.len().min(self.payload)];
        let packet = [bytemuck::bytes_of(&header), payload].concat();
        let _ = self.node.router().receive(port, &packet, |_| false);
    }

    /// The far end has taken all that was sent.
    fn give_credit(&mut self, port: Port) {
        let at = usize::from(port.0);
        let header = PacketHeader {
            kind: PacketHeader::CONTROL,
            lane: 0,
            priority: 0,
            _zero: 0,
            to: 0,
            from: 0,
            limits: self.limits[at],
            sent: self.brought[at],
        };
        let _ = self.node.router().receive(port, bytemuck::bytes_of(&header), |_| false);
    }

    /// Lets it work until it waits, and takes what it says.
    fn run(&mut self) {
        for _ in 0..STEPS {
            let progress = self.node.poll(self.now);
            self.now = self.now.after(Time(STEP));
            let mut packet = vec![0; PacketHeader::BYTES + self.payload];
            for port in 0..self.mesh.ports(HERE) {
                let mut has_sent = false;
                while let Some(len) = self.node.router().transmit(Port(port), &mut packet) {
                    has_sent = true;
                    let (header, payload) =
                        PacketHeader::split(&packet[..len]).expect("it sends packets");
                    let limits = header.sent.map(|sent| sent.wrapping_add(self.depth));
                    self.limits[usize::from(port)] = limits;
                    let mut items = Items::new(payload);
                    while items.next().is_some() {}
                    assert!(!items.is_damaged(), "it says what can be read");
                    if header.kind == PacketHeader::DATA {
                        self.said.push((header.to(), payload.to_vec()));
                    }
                }
                if has_sent {
                    self.give_credit(Port(port));
                }
            }
            if let Next::Wait { until, .. } = progress.next
                && until > self.now
            {
                break;
            }
        }
    }
}

/// A tile, with all that the node is told on the way: blocks in pieces, refusals, a visitor, and what it has not asked.
pub(crate) fn streams() -> Vec<Vec<u8>> {
    [Schedule::Hybrid, Schedule::Demand, Schedule::Data]
        .into_iter()
        .zip(0..)
        .map(|(schedule, number)| {
            let mut stream = vec![number];
            let mut memory = vec![Chunk::ZERO; MEMORY / CHUNK_BYTES];
            let mut bench = Bench::new(&mut memory, schedule);
            let visitor = rays()[5].clone();
            let visitor: RayMessage = bytemuck::pod_read_unaligned(&visitor);
            let mut room = vec![0; bench.payload];
            let mut tell = |channel: Channel, message: &Message<'_>| {
                let len = write(&mut room, 0, message).expect("it fits");
                (OTHER, channel, room[..len].to_vec())
            };
            let mut told = vec![
                tell(Channel::Request, &Message::Ray(visitor.bytes())),
                tell(Channel::Reply, &Message::Refusal { to: visitor.reply }),
            ];
            for _ in 0..200 {
                for (from, channel, payload) in told.drain(..) {
                    record(&mut stream, from, channel, &payload);
                    bench.bring(from, channel, &payload);
                    bench.run();
                }
                let said = std::mem::take(&mut bench.said);
                for (to, payload) in said {
                    for message in Items::new(&payload) {
                        told.extend(
                            answers(&message, bench.payload)
                                .into_iter()
                                .map(|reply| (to, Channel::Reply, reply)),
                        );
                    }
                }
                if told.is_empty() {
                    told.push((HOST, Channel::Reply, Vec::new()));
                }
            }
            stream
        })
        .collect()
}

/// What a host or a node answers, each in a packet of its own.
fn answers(message: &Message<'_>, payload: usize) -> Vec<Vec<u8>> {
    let mut replies = Vec::new();
    let mut reply = |message: &Message<'_>| {
        let mut room = vec![0; payload];
        let len = write(&mut room, 0, message).expect("a reply fits");
        room.truncate(len);
        replies.push(room);
    };
    match *message {
        Message::Ask { number, .. } => {
            reply(&Message::Grant { number, first: number % 4, count: 1, wait: 0 });
        }
        Message::Fetch { block, offset, request } => {
            let bytes = SCENE.view().block_bytes(block).unwrap_or_default();
            let piece = (payload - kiloray_core::protocol::Item::PART_BYTES) / 4 * 4;
            for (k, bytes) in bytes.chunks(piece).enumerate() {
                let at = (k * piece) as u32;
                if at >= offset {
                    reply(&Message::Part { block, offset: at, request, bytes });
                }
            }
        }
        Message::Pixels { tile, .. } => reply(&Message::Accepted { tile }),
        Message::Ray(ray) => {
            reply(&Message::Refusal { to: RayMessage::read(ray).reply });
        }
        _ => {}
    }
    replies
}

/// A node that is told all of this.
pub(crate) fn feed(input: &[u8]) -> String {
    let schedule = match input.first() {
        Some(0) => Schedule::Hybrid,
        Some(1) => Schedule::Demand,
        _ => Schedule::Data,
    };
    let mut memory = vec![Chunk::ZERO; MEMORY / CHUNK_BYTES];
    let mut bench = Bench::new(&mut memory, schedule);
    bench.run();
    let mut rest = input.get(1..).unwrap_or_default();
    while let Some((&[host, channel, low, high], after)) = rest.split_first_chunk::<RECORD_BYTES>()
    {
        let len = usize::from(u16::from_le_bytes([low, high])).min(after.len());
        let (payload, after) = after.split_at(len);
        rest = after;
        let from = if host & 1 == 1 { HOST } else { OTHER };
        let channel = if channel & 1 == 1 { Channel::Reply } else { Channel::Request };
        bench.bring(from, channel, payload);
        bench.run();
    }
    // Its time limits pass, and nobody answers any more.
    for _ in 0..3 {
        bench.now = bench.now.after(Time(1 << 30));
        bench.run();
    }
    let counts = bench.node.counts();
    let some = |count: u64, name: &str| if count > 0 { format!("{name} ") } else { String::new() };
    [
        some(counts.tiles, "tiles"),
        some(counts.visitors, "visitors"),
        some(counts.migrated, "migrated"),
        some(counts.refused, "refused"),
        some(counts.run_at_home, "home"),
        some(counts.unasked, "unasked"),
        some(counts.damaged, "damaged"),
        some(counts.blocks_refused, "unsound"),
        some(counts.cache.evictions, "evictions"),
        some(counts.stalls, "stalls"),
    ]
    .concat()
}
