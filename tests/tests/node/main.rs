//! The actor as a process or a board runs it: [`run`] over links and a clock.
//!
//! Two nodes and the host are joined by links in memory that lose and double packets. The executor polls a task only when it was woken, and lets time
//! pass only when none was: who forgets to wake another is found out.

mod executor;
mod link;

use executor::{Tasks, TestClock};
use kiloray_core::block::KiloView;
use kiloray_core::network::{HOST, Mesh, NodeId, PacketHeader, Port, Router, RouterSize, Topology};
use kiloray_core::node::{
    Actor, Clock, Dealing, Joint, Next, Node, NodeNeeds, NodePlan, Picture, Placement, PointHome,
    Prefetch, Rom, Schedule, Settings, ShadowPolicy, TaskOrder, Time, run,
};
use kiloray_core::render::Tiling;
use kiloray_core::shade::{SPLITS, Shader, Tables};
use kiloray_core::store::{Arena, CHUNK_BYTES, Chunk};
use kiloray_core::trace::Scalar;
use kiloray_core::view::Camera;
use kiloray_mesh::Ledger;
use kiloray_scene::kilo::KiloFile;
use kiloray_scene::{builtin, compile};
use link::{Chance, Link};
use std::cell::Cell;
use std::sync::atomic::AtomicBool;

const WIDTH: u32 = 24;
const HEIGHT: u32 = 20;
const SIDE: u32 = 4;
const BLOCK_BYTES: usize = 1024;
const MEMORY: usize = 64 << 10;
/// Far more than is spent waiting for tiles that there are no more.
const PATIENCE: Time = Time(1_000_000_000);

fn scene() -> KiloFile {
    let model = builtin::build("glass").expect("a scene that exists");
    let options = compile::Options::blocks_of(BLOCK_BYTES);
    let compiled = compile::compile(&model, &options, &mut ());
    KiloFile::from_compiled(compiled.expect("it compiles"))
}

fn settings() -> kiloray_core::shade::Settings {
    kiloray_core::shade::Settings { samples: 1, shadow_samples: 2, ..Default::default() }
}

/// The picture by one thread over the file.
fn reference(file: &KiloFile) -> kiloray_render::Picture {
    let options = kiloray_render::Options::new(WIDTH, HEIGHT, file.view().views()[0]);
    let options = kiloray_render::Options { settings: settings(), threads: 1, ..options };
    let control = kiloray_render::Control { cancel: &AtomicBool::new(false), progress: &|_, _| {} };
    kiloray_render::render(&file.view(), &options, &control).expect("it renders").picture
}

struct Host<'m, 'c> {
    router: Router<'m>,
    ledger: Ledger,
    complete: &'c Cell<bool>,
}

impl<'m> Actor<'m> for Host<'m, '_> {
    fn poll(&mut self, now: Time) -> Next {
        let next = self.ledger.poll(now, &mut self.router);
        self.complete.set(self.ledger.is_complete());
        next
    }

    fn router(&mut self) -> &mut Router<'m> {
        &mut self.router
    }
}

/// The picture by two nodes, which fetch from each other and send each other rays.
fn by_two_nodes(
    file: &KiloView<'_>,
    (loss, double): (Chance, Chance),
    reminder: Time,
) -> (kiloray_render::Picture, Time) {
    let mesh = Mesh::new(Topology::parse("line", 2).expect("a shape that exists"));
    let shader = Shader::new(Tables::of(file), settings());
    let camera = Camera::new(&file.views()[0], WIDTH, HEIGHT, settings().samples).expect("a view");
    let tiling = Tiling::new(WIDTH, HEIGHT, SIDE);
    let placement = Placement {
        dealing: Dealing::Subtrees,
        blocks: file.blocks(),
        nodes: 2,
        top: 1,
        replicas: 1,
    };
    let settings = Settings {
        schedule: Schedule::Hybrid,
        shadow: ShadowPolicy::default(),
        points: PointHome::default(),
        placement,
        refusals: 2,
        prefetch: Prefetch::Nearest(0),
        order: TaskOrder::Made,
        patience: PATIENCE,
        bundle_age: Time(1_000),
        group: 0,
        deaths_told: false,
    };
    let plan = |here| {
        let owned = Rom::of_file(&[], BLOCK_BYTES, placement, here).len();
        let needs = NodeNeeds {
            mesh,
            here,
            block_bytes: BLOCK_BYTES,
            remote: file.blocks() as usize - owned,
            owned: 0,
            splits: usize::from(SPLITS),
            schedule: settings.schedule,
            shadow: settings.shadow,
            points: settings.points,
            group: settings.group,
            side: SIDE as usize,
            packet: 0,
            depth: 0,
            host_depth: 0,
        };
        NodePlan::new(MEMORY, &needs).expect("it fits")
    };
    let mut arenas = [(); 2].map(|()| vec![Chunk::ZERO; MEMORY / CHUNK_BYTES]);
    let mut arenas = arenas.iter_mut();
    let [mut first, mut second] = [NodeId(0), NodeId(1)].map(|here| {
        let plan = plan(here);
        let rom = Rom::of_file(file.block_section(), BLOCK_BYTES, placement, here);
        let world = Picture::new(Scalar, shader, camera, tiling, file.limits());
        let budget = plan.budget(MEMORY).expect("it was planned");
        let mut arena = Arena::new(arenas.next().expect("two"));
        let node = Node::new(&mut arena, &plan, budget, settings, rom, mesh, world);
        node.expect("it fits")
    });
    let complete = Cell::new(false);
    let size = plan(NodeId(0)).router;
    let size = RouterSize::new(&mesh, HOST, size.depth, size.payload);
    let mut host_memory = vec![Chunk::ZERO; MEMORY / CHUNK_BYTES];
    let mut arena = Arena::new(&mut host_memory);
    let ledger = Ledger::new(WIDTH, HEIGHT, SIDE, shader.settings().seed, shader.unit(), 1);
    let mut host = Host {
        router: Router::new(&mut arena, mesh, HOST, size).expect("room"),
        ledger: ledger.expect("a picture").with_askers(2),
        complete: &complete,
    };

    // A link for each direction, named by the end that it begins at.
    let ends: Vec<(NodeId, Port)> = [NodeId(0), NodeId(1), HOST]
        .into_iter()
        .flat_map(|node| (0..mesh.ports(node)).map(move |port| (node, Port(port))))
        .filter(|&(node, port)| mesh.neighbour(node, port).is_some())
        .collect();
    let seeds = 1..;
    let links: Vec<Link> =
        ends.iter().zip(seeds).map(|(_, s)| Link::new(s, loss, double)).collect();
    let link = |end| &links[ends.iter().position(|e| *e == end).expect("a link")];
    let packet = PacketHeader::BYTES + usize::from(size.payload);
    let mut rooms = [[(); 4]; 3].map(|rooms| rooms.map(|()| vec![0_u8; packet]));
    let mut rooms = rooms.iter_mut();
    let mut joints = |node: NodeId| {
        let ports: Vec<_> = ends.iter().filter(|end| end.0 == node).map(|end| end.1).collect();
        let ports: [Port; 2] = ports.try_into().expect("each has two links");
        let [a, b, c, d] = rooms.next().expect("three ends").each_mut();
        let mut rooms = [(a, b), (c, d)].into_iter();
        ports.map(|port| {
            let far = mesh.neighbour(node, port).expect("it is joined");
            let back = mesh.reverse(node, port).expect("it is joined");
            let (incoming, outgoing) = rooms.next().expect("room");
            Joint {
                port,
                receive: link((far, back)),
                transmit: link((node, port)),
                incoming: incoming.as_mut_slice(),
                outgoing: outgoing.as_mut_slice(),
            }
        })
    };
    let clock = TestClock::default();
    let mut tasks = Tasks::new(&clock);
    tasks.add(run(&mut first, joints(NodeId(0)), &clock, reminder));
    tasks.add(run(&mut second, joints(NodeId(1)), &clock, reminder));
    tasks.add(run(&mut host, joints(HOST), &clock, reminder));
    tasks.run_until(|| complete.get());
    drop(tasks);
    let (here, there) = (first.counts(), second.counts());
    assert!(here.cache.fetched > 0 && there.cache.fetched > 0, "they fetch from each other");
    assert!(here.migrated > 0 && there.migrated > 0, "they send each other rays");
    (host.ledger.picture(), clock.now())
}

fn bits(picture: &kiloray_render::Picture) -> Vec<[u32; 3]> {
    picture.pixels.iter().map(|pixel| pixel.map(f32::to_bits)).collect()
}

#[test]
fn two_nodes_over_links_have_the_bits_of_one_machine() {
    let file = scene();
    let expected = bits(&reference(&file));
    let (picture, end) = by_two_nodes(&file.view(), (Chance::NEVER, Chance::NEVER), Time::NEVER);
    assert_eq!(bits(&picture), expected);
    // Time goes on only when all sleep: nobody has slept until a time limit instead of being woken.
    assert!(end < PATIENCE, "{end:?}");
}

#[test]
fn lost_and_doubled_packets_cost_time_only() {
    let file = scene();
    let expected = bits(&reference(&file));
    let often = Chance::one_in(10);
    let (picture, end) = by_two_nodes(&file.view(), (often, often), Time(100_000));
    assert_eq!(bits(&picture), expected);
    assert!(end > PATIENCE, "{end:?}");
}
