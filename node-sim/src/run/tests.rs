use super::*;
use crate::{Crash, CrashReport, NodeTime, Rate, Slow, Switching};
use kiloray_core::network::{Channel, PacketHeader, Router, RouterSize, Topology};
use kiloray_core::node::{Lack, Next, Progress, Time, Work};
use kiloray_core::store::{Arena, CHUNK_BYTES, Chunk};
use proptest::prelude::*;
use std::convert::Infallible;

/// Something to send.
#[derive(Debug, Clone, Copy)]
struct Letter {
    at: u64,
    from: u16,
    to: u16,
    channel: Channel,
    len: u16,
}

/// An actor that sends letters, and takes down what arrives.
struct Toy<'m> {
    router: Router<'m>,
    /// The next is the last.
    letters: Vec<(u32, Letter)>,
    /// When, from whom, which.
    arrived: Vec<(u64, NodeId, u32)>,
    /// Work for each letter.
    work: u32,
}

impl<'m> Actor<'m> for Toy<'m> {
    fn poll(&mut self, now: Time) -> Progress {
        let mut work = Work::default();
        for channel in Channel::ALL {
            while let Some((from, payload)) = self.router.arrived(channel) {
                let id = u32::from_le_bytes(payload[..4].try_into().expect("four bytes"));
                self.arrived.push((now.0, from, id));
                self.router.consume(channel);
            }
        }
        while let Some((id, letter)) = self.letters.last().filter(|(_, l)| l.at <= now.0) {
            let mut payload = vec![0; usize::from(letter.len)];
            payload[..4].copy_from_slice(&id.to_le_bytes());
            let to = NodeId(letter.to);
            if self.router.inject(to, letter.channel, 0, &payload).is_err() {
                break;
            }
            self.letters.pop();
            work.messages += self.work;
        }
        let until = self.letters.last().map_or(Time::NEVER, |(_, letter)| Time(letter.at));
        let until = if until.0 <= now.0 { Time::NEVER } else { until };
        // What it has sent to itself is here already.
        let mail = Channel::ALL.into_iter().any(|c| self.router.arrived(c).is_some());
        let next = if mail { Next::Now } else { Next::Wait { until, lack: Lack::Tiles } };
        Progress { work, next }
    }

    fn router(&mut self) -> &mut Router<'m> {
        &mut self.router
    }

    fn stored(&self) -> u32 {
        self.letters.len() as u32
    }
}

struct Lent {
    size: RouterSize,
    chunks: Vec<Chunk>,
}

const PAYLOAD: u16 = 1000;

/// One nanosecond for a byte; a microsecond for a step on the way.
fn settings() -> RunSettings {
    RunSettings {
        link: Link { bandwidth: 1_000_000_000, latency: 1000, ..Link::default() },
        profile: Profile { message: 1.0, ..Profile::PC },
        faults: Faults::default(),
        seed: 1,
        packet: PAYLOAD + PacketHeader::BYTES as u16,
        block_bytes: 1024,
        trace: 0,
    }
}

/// What came of a run: arrivals by place, the end, the hash of events, bytes on links, and what is left in buffers.
#[derive(Debug, PartialEq)]
struct Seen {
    arrived: Vec<Vec<(u64, NodeId, u32)>>,
    end: u64,
    fingerprint: u64,
    events: u64,
    bytes: u64,
    busiest: u64,
    left: u32,
    faults: FaultReport,
    times: Vec<NodeTime>,
}

impl Seen {
    fn all(&self) -> usize {
        self.arrived.iter().map(Vec::len).sum()
    }
}

fn run(shape: &str, nodes: u32, depth: u16, letters: &[Letter], settings: RunSettings) -> Seen {
    run_with_work(shape, nodes, depth, letters, settings, 0, 1)
}

fn run_with_work(
    shape: &str,
    nodes: u32,
    depth: u16,
    letters: &[Letter],
    settings: RunSettings,
    work: u32,
    threads: usize,
) -> Seen {
    let mesh = Mesh::new(Topology::parse(shape, nodes).expect("a shape that exists"));
    let places = || (0..mesh.nodes()).map(NodeId).chain([HOST]);
    let mut memory: Vec<Lent> = places()
        .map(|here| {
            let size = RouterSize::new(&mesh, here, depth, PAYLOAD);
            Lent { size, chunks: vec![Chunk::ZERO; size.arena_bytes() / CHUNK_BYTES] }
        })
        .collect();
    let mut toys: Vec<Toy<'_>> = memory
        .iter_mut()
        .zip(places())
        .map(|(lent, here)| {
            let mut arena = Arena::new(&mut lent.chunks);
            let router =
                Router::new(&mut arena, mesh, here, lent.size).expect("the memory has the size");
            let mine = (0..).zip(letters.iter().copied()).filter(|(_, l)| l.from == here.0);
            let mut letters: Vec<(u32, Letter)> = mine.collect();
            letters.sort_by_key(|(_, letter)| std::cmp::Reverse(letter.at));
            Toy { router, letters, arrived: Vec::new(), work }
        })
        .collect();
    let host = toys.pop().expect("the host is the last");
    let toys = toys.into_iter().map(Ok::<_, Infallible>);
    let Ok(mut run) = Run::new(&mesh, toys, host, settings, threads);
    while run.advance() {
        assert!(run.events < 1_000_000, "it does not come to an end");
    }
    run.settle();
    let links = run.take_links();
    let mut seen = Seen {
        arrived: Vec::new(),
        end: run.now,
        fingerprint: run.fingerprint(),
        events: run.events,
        bytes: links.iter().map(|link| link.bytes).sum(),
        busiest: links.iter().map(|link| link.busy_ns).max().unwrap_or(0),
        left: 0,
        faults: run.faults(),
        times: Vec::new(),
    };
    for Place { actor: toy, state, .. } in run.nodes.into_iter().chain([run.host]) {
        seen.times.push(state.time);
        seen.left += toy.router.buffered() + toy.letters.len() as u32;
        seen.arrived.push(toy.arrived);
    }
    seen
}

fn letter(at: u64, from: u16, to: u16, len: u16) -> Letter {
    Letter { at, from, to, channel: Channel::Reply, len }
}

#[test]
fn a_single_transfer_takes_what_was_worked_out() {
    // 100 bytes and a header of 24 over three links.
    let letters = [letter(500, 0, 3, 100)];
    let at = |switching| {
        let mut settings = settings();
        settings.link.switching = switching;
        let seen = run("line", 4, 2, &letters, settings);
        assert_eq!(seen.arrived[3].len(), 1);
        seen.arrived[3][0]
    };
    let stored = at(Switching::StoreAndForward);
    assert_eq!(stored, (500 + 3 * (1000 + 124), NodeId(0), 0));
    let cut_through = at(Switching::CutThrough);
    assert_eq!(cut_through, (500 + 3 * 1000 + 24 + 24 + 124, NodeId(0), 0));
}

#[test]
fn work_delays_what_it_makes() {
    let letters = [letter(500, 0, 1, 100)];
    let seen = run_with_work("line", 2, 2, &letters, settings(), 77, 1);
    assert_eq!(seen.arrived[1][0].0, 500 + 77 + 1000 + 124);
    assert_eq!((seen.times[0].messages, seen.times[0].busy()), (77, 77));
    assert!(seen.times.iter().all(|time| time.busy() + time.idle() == seen.end));
}

#[test]
fn a_link_carries_no_more_than_its_bandwidth() {
    // A hundred packets of 1024 bytes, one after the other; credit comes back before it is needed.
    let letters: Vec<Letter> = (0..100).map(|_| letter(0, 0, 1, PAYLOAD)).collect();
    let seen = run("line", 2, 8, &letters, settings());
    assert_eq!(seen.arrived[1].len(), 100);
    assert_eq!(seen.arrived[1].last().map(|a| a.0), Some(100 * 1024 + 1000));
    // With one buffer, each waits for the credit of the last: there and back.
    let seen = run("line", 2, 1, &letters, settings());
    assert_eq!(seen.arrived[1].last().map(|a| a.0), Some(99 * (1024 + 1000 + 24 + 1000) + 2024));
    assert_eq!(seen.busiest, 100 * 1024);
}

#[test]
fn two_streams_share_a_link() {
    // Both need the link from 1 to 2.
    let letters: Vec<Letter> =
        (0..80).map(|i| letter(0, u16::from(i % 2 == 0), 2, PAYLOAD)).collect();
    let seen = run("line", 3, 8, &letters, settings());
    assert_eq!(seen.arrived[2].len(), 80);
    let first_half = &seen.arrived[2][..40];
    let from_one = first_half.iter().filter(|(_, from, _)| from.0 == 1).count();
    assert!((15..=25).contains(&from_one), "{from_one}");
    assert!(seen.end >= 80 * 1024);
}

#[test]
fn what_comes_behind_what_passes_through_is_seen_when_that_has_left() {
    // The link from 1 to 2 is taken, so that what goes on from 0 to 2 waits at 1, and what is for 1 waits behind it.
    let mut letters: Vec<Letter> = (0..4).map(|_| letter(0, 1, 2, PAYLOAD)).collect();
    letters.extend([letter(0, 0, 2, 10), letter(0, 0, 1, 10)]);
    let seen = run("line", 3, 4, &letters, settings());
    assert_eq!((seen.arrived[1].len(), seen.left), (1, 0));
    assert!(seen.arrived[1][0].0 >= 1024, "it did not wait: {:?}", seen.arrived);
}

#[test]
fn what_is_for_the_dead_is_dropped_and_the_rest_goes_on() {
    let mut settings = settings();
    settings.faults.crashes = vec![Crash { node: NodeId(1), at: 5000 }];
    let mut letters = Vec::new();
    for i in 0..40 {
        letters.push(letter(i * 500, 0, 1, 100));
        letters.push(letter(i * 500, 0, 2, 100));
        letters.push(letter(i * 500, 1, 2, 100));
    }
    let seen = run("line", 3, 1, &letters, settings);
    let from = |at: usize, from| seen.arrived[at].iter().filter(|a| a.1 == NodeId(from)).count();
    assert_eq!(from(2, 0), 40, "the router of the dead goes on");
    assert!((1..10).contains(&from(1, 0)) && (1..=11).contains(&from(2, 1)));
    assert_eq!(seen.faults.for_the_dead + from(1, 0) as u64, 40);
    assert_eq!(seen.faults.crashes, [CrashReport { node: 1, at_ns: 5000 }]);
    assert_eq!(seen.times[1].dead, seen.end - 5000);
}

#[test]
fn thousands_of_idle_nodes_cost_nothing() {
    let letters: Vec<Letter> = (0..10).map(|i| letter(i * 1_000_000, 0, HOST.0, 100)).collect();
    let seen = run("torus:64x64", 4096, 1, &letters, settings());
    assert_eq!(seen.all(), 10);
    // A call for each in the beginning, and a few events for each letter.
    assert!(seen.events < 4097 + 10 * 8, "{}", seen.events);
}

#[test]
fn who_waits_for_a_slow_node_asks_it_for_credit_seldom() {
    let slow = |factor| {
        let mut settings = settings();
        settings.faults.loss = Rate { count: 1, of: 1000 };
        settings.faults.slow = vec![Slow { node: NodeId(1), factor }];
        // Node 1 is at its own letter while those of node 0 take up its buffers.
        let letters: Vec<_> =
            (0..4).map(|i| letter(i, 0, 1, 100)).chain([letter(0, 1, 0, 4)]).collect();
        run_with_work("line", 2, 1, &letters, settings, 1, 1)
    };
    let mut before = 0;
    for factor in [1e6, 1e9, 1e12] {
        let seen = slow(factor);
        assert_eq!((seen.all(), seen.left), (5, 0));
        assert!(seen.end as f64 >= factor, "{}", seen.end);
        assert!(seen.events < before + 10_000, "{factor}: {} events", seen.events);
        before = seen.events;
    }
}

fn shapes() -> impl Strategy<Value = (&'static str, u32)> {
    prop::sample::select(vec![
        ("line", 1),
        ("line", 5),
        ("ring", 8),
        ("mesh:3x4", 12),
        ("torus:4x4", 16),
        ("torus:3x3x3", 27),
        ("hypercube", 16),
        ("tree:3", 13),
        ("full", 6),
    ])
}

/// Letters between any nodes and the host.
fn letters(nodes: u32) -> impl Strategy<Value = Vec<Letter>> {
    let place = move || (0..=nodes).prop_map(move |p| if p == nodes { HOST.0 } else { p as u16 });
    let letter = (0_u64..100_000, place(), place(), any::<bool>(), 4..=PAYLOAD);
    let letter = letter.prop_map(|(at, from, to, reply, len)| {
        let channel = if reply { Channel::Reply } else { Channel::Request };
        Letter { at, from, to, channel, len }
    });
    prop::collection::vec(letter, 1..300)
}

/// The same letters, as long as buffers of so many packets take: those of requests are shorter.
fn fitting(letters: &[Letter], depth: u16) -> Vec<Letter> {
    let most = |channel| match channel {
        Channel::Reply => PAYLOAD,
        Channel::Request if depth == 1 => 256,
        Channel::Request => 512,
    };
    letters.iter().map(|l| Letter { len: l.len.min(most(l.channel)), ..*l }).collect()
}

fn traffic() -> impl Strategy<Value = ((&'static str, u32), Vec<Letter>)> {
    shapes().prop_flat_map(|shape| (Just(shape), letters(shape.1)))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn all_arrive_once_and_the_same_seed_is_the_same_run_on_any_threads(
        ((shape, nodes), letters) in traffic(),
        depth in 1_u16..4,
        cut_through: bool,
        work in 0_u32..2000,
    ) {
        let letters = fitting(&letters, depth);
        let mut settings = settings();
        if !cut_through {
            settings.link.switching = Switching::StoreAndForward;
        }
        let run = |threads| run_with_work(shape, nodes, depth, &letters, settings.clone(), work, threads);
        let seen = run(1);
        prop_assert_eq!((seen.all(), seen.left), (letters.len(), 0));
        let mut ids: Vec<u32> = seen.arrived.iter().flatten().map(|a| a.2).collect();
        ids.sort_unstable();
        prop_assert!(ids.into_iter().eq(0..letters.len() as u32));
        for (place, time) in seen.times.iter().enumerate() {
            prop_assert_eq!(time.busy() + time.idle(), seen.end, "{}", place);
        }
        prop_assert_eq!(&seen, &run(1));
        prop_assert_eq!(&seen, &run(3));
    }

    #[test]
    fn under_faults_none_arrives_twice_and_the_same_seed_is_the_same_run_on_any_threads(
        ((shape, nodes), letters) in traffic(),
        depth in 1_u16..4,
        seed: u64,
        jitter in 0_u64..5000,
    ) {
        let letters = fitting(&letters, depth);
        let mut settings = settings();
        settings.seed = seed;
        settings.faults.loss = Rate { count: 1, of: 20 };
        settings.faults.duplicate = Rate { count: 1, of: 20 };
        settings.faults.jitter = jitter;
        let run = |threads| run_with_work(shape, nodes, depth, &letters, settings.clone(), 300, threads);
        let seen = run(1);
        let mut ids: Vec<u32> = seen.arrived.iter().flatten().map(|a| a.2).collect();
        let all = ids.len();
        ids.sort_unstable();
        ids.dedup();
        prop_assert_eq!((ids.len(), seen.left), (all, 0));
        prop_assert_eq!(&seen, &run(1));
        prop_assert_eq!(&seen, &run(3));
    }
}
