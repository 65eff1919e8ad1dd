//! Runs in which a seed chooses what happens next, with time.

use super::super::slots::{FetchSlot, RaySlot, Stage};
use super::super::{Figures, Node, Time, World as _, fetch};
use super::mesh::{Action, Setup, World, memory};
use super::toy::{NO_ENDS, Toy};
use super::{POINTS, SCHEDULES, Schedule};
use crate::network::{Channel, HOST, NodeId, Port};
use crate::protocol::{Item, Message, ReturnAddress, write};
use crate::store::Line;

fn setup(topology: (&str, u32), schedule: Schedule) -> Setup {
    let toy = Toy {
        tiles: 6,
        blocks: 7,
        way: 4,
        splits: 2,
        tail: 1,
        shadows: 3,
        block_bytes: 1024,
        seed: 5,
        ends: NO_ENDS,
    };
    Setup { timed: true, fused: false, ..super::setup(topology, schedule, toy) }
}

/// Runs a mesh, choosing among all that can happen by a seed: the number of steps.
fn run(setup: &Setup, seed: u64, loss: u32, double: u32, crash: Option<(u16, u32)>) -> u32 {
    let (mut chunks, blocks) = memory(setup);
    let mut world = World::new(setup, &mut chunks, &blocks);
    let mut random = fastrand::Rng::with_seed(seed);
    for step in 0..3_000_000 {
        if let Some((node, at)) = crash
            && step == at
        {
            world.act(Action::Crash(node));
        }
        assert!(!world.wrong, "seed {seed}");
        if world.is_complete() {
            return step;
        }
        let actions = world.actions();
        if actions.is_empty() {
            let nodes = world.summary();
            panic!("seed {seed}: nothing can happen after {step} steps: {nodes:#?}");
        }
        let action = actions[random.usize(..actions.len())];
        let action = match action {
            Action::Deliver(n, p) if loss > 0 && random.u32(..loss) == 0 => Action::Lose(n, p),
            Action::Deliver(n, p) if double > 0 && random.u32(..double) == 0 => {
                Action::Double(n, p)
            }
            other => other,
        };
        world.act(action);
    }
    panic!("seed {seed}: not complete: {:#?}", world.summary());
}

#[test]
fn all_is_rendered_in_the_least_memory() {
    for topology in [("line", 1), ("line", 2), ("ring", 4), ("mesh:2x2", 4), ("torus:3x3", 9)] {
        for schedule in SCHEDULES {
            for seed in 0..10 {
                let points = POINTS[seed as usize % 2];
                run(&Setup { points, ..setup(topology, schedule) }, seed, 0, 0, None);
            }
        }
    }
}

#[test]
fn lost_and_doubled_packets_cost_time_only() {
    for topology in [("line", 2), ("ring", 4), ("mesh:2x2", 4)] {
        for schedule in SCHEDULES {
            for seed in 0..10 {
                let points = POINTS[seed as usize % 2];
                run(&Setup { points, ..setup(topology, schedule) }, seed, 20, 20, None);
            }
        }
    }
}

#[test]
fn a_dead_node_costs_time_only_while_its_blocks_live_elsewhere() {
    for schedule in SCHEDULES {
        for seed in 0..20 {
            let points = POINTS[seed as usize / 3 % 2];
            let setup = Setup { replicas: 2, points, ..setup(("ring", 4), schedule) };
            run(&setup, seed, 0, 0, Some((1 + (seed % 3) as u16, 40 * seed as u32)));
        }
    }
}

#[test]
fn a_block_whose_holders_are_dead_is_named_within_a_few_time_limits() {
    for (schedule, replicas) in SCHEDULES.into_iter().flat_map(|s| [(s, 1), (s, 2)]) {
        for seed in 0..5 {
            let setup = Setup { replicas, ..setup(("ring", 4), schedule) };
            let (mut chunks, blocks) = memory(&setup);
            let mut world = World::new(&setup, &mut chunks, &blocks);
            let mut random = fastrand::Rng::with_seed(seed);
            // Between them they hold all copies of what lies with either.
            world.act(Action::Crash(1));
            world.act(Action::Crash(3));
            while world.lost.is_none() {
                let actions = world.actions();
                world.act(actions[random.usize(..actions.len())]);
            }
            let patience = world.nodes[0].settings.patience;
            assert!(
                world.now.0 < 4 * patience.0,
                "{schedule:?} {replicas} {seed}: {:?}",
                world.now
            );
        }
    }
}

/// What a thread's nodes have said.
#[cfg(feature = "log")]
mod said {
    use std::cell::RefCell;

    thread_local!(static LINES: RefCell<Vec<String>> = const { RefCell::new(Vec::new()) });

    struct ToLines;

    impl log::Log for ToLines {
        fn enabled(&self, _: &log::Metadata<'_>) -> bool {
            true
        }

        fn log(&self, record: &log::Record<'_>) {
            LINES.with_borrow_mut(|lines| {
                lines.push(format!("{} {}", record.level(), record.args()))
            });
        }

        fn flush(&self) {}
    }

    pub(super) fn during(what: impl FnOnce()) -> Vec<String> {
        if log::set_logger(&ToLines).is_ok() {
            log::set_max_level(log::LevelFilter::Trace);
        }
        LINES.take();
        what();
        LINES.take()
    }
}

#[cfg(feature = "log")]
#[test]
fn a_node_says_what_it_sees_go_wrong() {
    let ring = |replicas| Setup { replicas, ..setup(("ring", 4), Schedule::Demand) };
    let quiet = said::during(|| _ = run(&ring(2), 1, 0, 0, None));
    assert!(quiet.iter().all(|line| !line.starts_with("ERROR")), "{quiet:?}");
    let dead = said::during(|| _ = run(&ring(2), 1, 0, 0, Some((1, 40))));
    assert!(dead.iter().any(|line| line.ends_with("node 1 lets a request wait")), "{dead:?}");
    assert!(dead.iter().any(|line| line.contains("is asked for again")), "{dead:?}");
    let lost = said::during(|| {
        let setup = ring(1);
        let (mut chunks, blocks) = memory(&setup);
        let mut world = World::new(&setup, &mut chunks, &blocks);
        let mut random = fastrand::Rng::with_seed(1);
        world.act(Action::Crash(1));
        while world.lost.is_none() {
            let actions = world.actions();
            world.act(actions[random.usize(..actions.len())]);
        }
    });
    let names_a_block =
        |line: &String| line.starts_with("ERROR") && line.contains("answers for block");
    assert!(lost.iter().any(names_a_block), "{lost:?}");
}

#[test]
fn after_a_request_in_vain_the_other_holder_is_asked() {
    let setup = Setup { replicas: 2, ..setup(("ring", 4), Schedule::Demand) };
    let (mut chunks, blocks) = memory(&setup);
    let mut world = World::new(&setup, &mut chunks, &blocks);
    let (placement, node) = (setup.placement(), &mut world.nodes[0]);
    let [a, b] = [0, 1].map(|copy| placement.owner(6, copy).unwrap());
    let near = node.owner_for(6, None, 0).unwrap();
    let far = if near == a { b } else { a };
    node.suspect(near);
    assert_eq!(node.owner_for(6, None, 0), Some(far));
    assert_eq!(node.owner_for(6, Some(near), 0), Some(far));
    assert_eq!(node.owner_for(6, Some(far), 0), Some(near), "though it is suspected");
    assert_eq!(node.owner_for(6, Some(near), 0b01), Some(b), "the first copy is gone");
    assert_eq!(node.owner_for(6, Some(near), 0b11), None);
}

#[test]
fn who_asks_again_gets_a_block_once() {
    let setup = Setup { fused: true, ..setup(("line", 2), Schedule::Demand) };
    let (mut chunks, blocks) = memory(&setup);
    let mut world = World::new(&setup, &mut chunks, &blocks);
    let block = (0..).find(|&b| setup.placement().owner(b, 0) == Some(NodeId(1))).unwrap();
    let (mut requests, mut len) = ([0; 256], 0);
    for _ in 0..3 {
        len = write(&mut requests, len, &Message::Fetch { block, offset: 0, request: 0 }).unwrap();
    }
    world.router(0).inject(NodeId(1), Channel::Request, 1, &requests[..len]).unwrap();
    let there = (0..4).find(|&port| world.router(0).is_ready(Port(port))).unwrap();
    world.act(Action::Hop(0, there));
    for _ in 0..100 {
        world.act(Action::Poll(1));
        for port in 0..4 {
            if world.router(1).is_ready(Port(port)) {
                world.act(Action::Hop(1, port));
            }
        }
        for channel in Channel::ALL {
            world.router(0).consume(channel);
        }
    }
    let (node, sent) = (&world.nodes[1], world.nodes[1].counts.sent.part.count);
    assert!(node.serves.is_empty() && node.outbox.is_empty());
    assert_eq!(sent, setup.toy.block_bytes.div_ceil(node.piece) as u64);
}

#[test]
fn a_ray_runs_at_home_after_its_refusals_however_many_they_may_be() {
    for most in [0, 1, 254, 255] {
        let setup = Setup { refusals: most, ..setup(("line", 2), Schedule::Data) };
        let (mut chunks, blocks) = memory(&setup);
        let mut world = World::new(&setup, &mut chunks, &blocks);
        let node = &mut world.nodes[0];
        let ray = node.world.camera(0, &mut [0; 3]).unwrap();
        let number = node.take_slot(RaySlot::new(ray, 0, 0)).unwrap();
        for refusal in 0..=most {
            let slot = &mut node.rays[usize::from(number)];
            assert_eq!(slot.home, 0, "{refusal} of {most}");
            slot.set_stage(Stage::Away);
            let to = ReturnAddress::new(NodeId(0), number, slot.name());
            node.on_refusal(&to, Time(0));
        }
        assert_eq!(node.rays[usize::from(number)].home, 1, "{most}");
    }
}

#[test]
fn a_request_that_has_not_left_is_not_made_again() {
    let setup = setup(("line", 2), Schedule::Demand);
    let (mut chunks, blocks) = memory(&setup);
    let mut world = World::new(&setup, &mut chunks, &blocks);
    let block = (0..).find(|&b| setup.placement().owner(b, 0) == Some(NodeId(1))).unwrap();
    // Nothing leaves node 0: its own queue fills, then its bundles.
    while world.router(0).room(Channel::Request) > 0 {
        world.router(0).inject(NodeId(1), Channel::Request, 1, &[]).unwrap();
    }
    let node = &mut world.nodes[0];
    node.want(block, Time(0));
    for hour in 0..100 {
        let now = Time(hour << 42);
        node.send_fetches(now);
        node.deadlines(now);
    }
    assert_eq!((node.counts.fetches_again, node.lost), (0, None));
    assert!(node.outbox.asks_for(block, NodeId(1)));
}

/// Blocks are asked for again the sooner the more requests were lost; one that was only late is not rushed.
#[test]
fn time_limits_learn_what_is_lost_and_what_is_late() {
    let setup = setup(("line", 2), Schedule::Demand);
    let (mut chunks, blocks) = memory(&setup);
    let mut world = World::new(&setup, &mut chunks, &blocks);
    let block = (0..).find(|&b| setup.placement().owner(b, 0) == Some(NodeId(1))).unwrap();
    let node = &mut world.nodes[0];
    let mut pieces = (0..).step_by(16);
    // Its request is sent and its time limit passes, so often; then a piece comes that answers the last, or the one before.
    let mut asks = |times: u64, is_late: bool| {
        node.want(block, Time(0));
        for now in (1..=times).map(|hour| Time(hour << 42)) {
            (node.fetches[0].state, node.fetches[0].deadline) = (FetchSlot::SENT, 0);
            node.deadlines(now);
        }
        let request = if is_late { node.fetches[0].request - 1 } else { node.fetches[0].request };
        let Node { blocks, fetches, .. } = node;
        let placed = fetch::place(blocks, fetches, 16, block, pieces.next().unwrap(), &[0; 16]);
        assert!(placed.is_some());
        node.on_piece(placed, request, Time(0));
        node.haste
    };
    assert_eq!([asks(1, false), asks(1, false), asks(2, false)], [1, 2, 3]);
    assert_eq!([asks(1, true), asks(1, false)], [0, 1]);
}

#[test]
fn what_cannot_be_read_is_counted_and_dropped() {
    let setup = setup(("line", 2), Schedule::Demand);
    let (mut chunks, blocks) = memory(&setup);
    let mut world = World::new(&setup, &mut chunks, &blocks);
    let mut room = [[0; 64]; 2];
    let fetch = Message::Fetch { block: 1, offset: 0, request: 0 };
    let part = Message::Part { block: 1, offset: 0, request: 0, bytes: &[7; 16] };
    let [fetch_len, part_len] =
        [(&fetch, 0), (&part, 1)].map(|(message, at)| write(&mut room[at], 0, message).unwrap());
    let mut tell = [0; Item::BYTES];
    let _ = write(&mut tell, 0, &Message::Tell).unwrap();
    // Of a kind that there is not; cut short; what only the host may ask; a piece of a block that nobody asked for.
    let packets = [
        (Channel::Request, &[0xff; 40][..]),
        (Channel::Request, &room[0][..fetch_len - 1]),
        (Channel::Request, &tell),
        (Channel::Reply, &room[1][..part_len]),
    ];
    for (channel, bytes) in packets {
        world.router(0).inject(NodeId(1), channel, 1, bytes).unwrap();
        for _ in 0..4 {
            world.act(Action::Poll(1));
            for (from, port) in (0..2).flat_map(|from| (0..4).map(move |port| (from, port))) {
                if world.router(from).is_ready(Port(port)) {
                    world.act(Action::Hop(from, port));
                }
            }
        }
    }
    let counts = world.nodes[1].counts;
    assert_eq!((counts.damaged, counts.unasked), (2, 2));
    assert!(counts.sent.tile.bytes < Figures::BYTES as u64, "it tells the host alone");
}

#[test]
fn a_node_tells_the_host_what_it_has_done() {
    let setup = setup(("line", 1), Schedule::Demand);
    let (mut chunks, blocks) = memory(&setup);
    let mut world = World::new(&setup, &mut chunks, &blocks);
    let node = &mut world.nodes[0];
    (node.counts.shade.primary, node.counts.rays_peak) = (7, 2);
    (node.counts.fetches_again, node.counts.blocks_refused) = (1 << 40, 3);
    let (figures, budget) = (node.figures(), node.budget());
    assert_eq!(Figures::parse(bytemuck::bytes_of(&figures)), Some(figures));
    assert_eq!(Figures::parse(&[0; Figures::BYTES - 4]), None);
    assert_eq!(figures.memory, budget.memory() as u32);
    let lines = budget.lines().iter().filter(|line| line.bytes > 0);
    assert!(figures.lines().eq(lines.copied()) && figures.peak_bytes() == budget.peak_bytes());
    assert_eq!(budget.line(Line::Rays).peak, 2);
    let counts = figures.counts();
    assert_eq!((counts.shade.primary, counts.blocks_refused), (7, 3));
    assert_eq!(counts.fetches_again, u32::MAX.into(), "the greatest that it can tell");
    world.host.inject(NodeId(0), Channel::Request, 3, &[14, 0, 0, 0]).unwrap();
    let (host, there) = (world.index(HOST), world.mesh.joined(HOST).next().unwrap());
    let before = world.nodes[0].counts.sent.tile.bytes;
    world.act(Action::Hop(host, there.0));
    world.act(Action::Poll(0));
    let told = world.nodes[0].counts.sent.tile.bytes - before;
    assert!(told >= (Item::BYTES + Figures::BYTES) as u64, "{told} bytes");
}

#[test]
fn sub_masters_give_tiles_away() {
    for seed in 0..10 {
        run(&Setup { group: 2, ..setup(("mesh:2x2", 4), Schedule::Hybrid) }, seed, 0, 0, None);
    }
}
