//! Toy nodes and a network that loses, doubles, delays and lets messages overtake each other; time is virtual.

use crate::Ledger;
use kiloray_core::network::NodeId;
use kiloray_core::node::Time;
use kiloray_core::protocol::{Items, Message, pack, write};
use kiloray_core::render::Tiling;
use kiloray_core::shade::{Sum, Unit};
use proptest::prelude::*;
use std::collections::{BTreeMap, BTreeSet, VecDeque};

const HOST: NodeId = NodeId(u16::MAX);
/// A tile of a node of usual speed [ns].
const TILE: u64 = 5_000_000;
/// When a node asks again at first [ns].
const PATIENCE: u64 = 2_000_000;
/// More than any run takes [ns].
const END: Time = Time(3_600_000_000_000);
const SEED: u64 = 3;

/// What a network does to a message, in 1/1000.
#[derive(Debug, Clone, Copy)]
struct Faults {
    lose: u32,
    double: u32,
    /// Delay of a message above 0.1 ms [ns].
    jitter: u64,
}

const HEALTHY: Faults = Faults { lose: 0, double: 0, jitter: 50_000 };

#[derive(Debug, Clone)]
struct Node {
    id: NodeId,
    /// Parts of [`TILE`], from 1/8.
    eighths: u64,
    dies: Time,
    /// Tiles that it asks for.
    wants: u32,
    number: u32,
    ask_at: Time,
    asked: u32,
    queue: VecDeque<u32>,
    work: Option<(u32, Time)>,
    /// Tiles that wait for their acceptance: when they are sent again, and how often they were.
    sent: BTreeMap<u32, (Time, u32)>,
    rendered: Vec<u32>,
}

impl Node {
    fn new(id: u16, eighths: u64, wants: u32) -> Self {
        Self {
            id: NodeId(id),
            eighths,
            dies: Time::NEVER,
            wants,
            number: 0,
            ask_at: Time(0),
            asked: 0,
            queue: VecDeque::new(),
            work: None,
            sent: BTreeMap::new(),
            rendered: Vec::new(),
        }
    }

    fn is_dead(&self, now: Time) -> bool {
        now >= self.dies
    }

    /// When it has something to do.
    fn next(&self) -> Time {
        let ask = if self.queue.is_empty() { self.ask_at } else { Time::NEVER };
        let work = self.work.map_or(Time::NEVER, |(_, done)| done);
        let send = self.sent.values().map(|&(at, _)| at).min().unwrap_or(Time::NEVER);
        let next = ask.min(work).min(send);
        if self.is_dead(next) { Time::NEVER } else { next }
    }

    fn on_message(&mut self, now: Time, message: &Message<'_>) {
        match *message {
            Message::Grant { number, first, count, wait } if number == self.number => {
                self.number += 1;
                self.asked = 0;
                self.ask_at = now.after(Time(u64::from(wait) * 1000));
                let known = |p: &u32| self.queue.contains(p) || self.sent.contains_key(p);
                let working = self.work.map(|(tile, _)| tile);
                let new: Vec<_> =
                    (first..first + count).filter(|p| !known(p) && working != Some(*p)).collect();
                self.queue.extend(new);
            }
            Message::Grant { .. } => {}
            Message::Accepted { tile } => drop(self.sent.remove(&tile)),
            _ => panic!("{message:?} is not for a node"),
        }
    }

    fn act(&mut self, now: Time, picture: &Expected, net: &mut Net) {
        if let Some((tile, done)) = self.work
            && done <= now
        {
            self.work = None;
            self.rendered.push(tile);
            let _ = self.sent.insert(tile, (now, 0));
        }
        for (&tile, (at, tries)) in self.sent.iter_mut().filter(|(_, (at, _))| *at <= now) {
            let sums = picture.tile(tile);
            for (k, run) in sums.chunks(picture.run).enumerate() {
                let mut run = run.to_vec();
                let width = pack(&mut run);
                let sums = &bytemuck::cast_slice(&run)[..3 * usize::from(width) * run.len()];
                let first = (k * picture.run) as u32;
                net.send(now, self.id, HOST, &Message::Pixels { tile, first, width, sums });
            }
            *at = now.after(Time(PATIENCE << (*tries).min(20)));
            *tries += 1;
        }
        if self.work.is_none()
            && let Some(tile) = self.queue.pop_front()
        {
            let took = TILE / 8 * self.eighths * net.rng.u64(4..=12) / 8;
            self.work = Some((tile, now.after(Time(took))));
        }
        // It asks ahead: while it renders its last.
        if self.queue.is_empty() && self.ask_at <= now {
            net.send(now, self.id, HOST, &Message::Ask { number: self.number, count: self.wants });
            self.ask_at = now.after(Time(PATIENCE << self.asked.min(20)));
            self.asked += 1;
        }
    }
}

/// The right sums, from nothing but the place in the picture.
#[derive(Debug)]
struct Expected {
    width: u32,
    height: u32,
    side: u32,
    /// Pixels in a message.
    run: usize,
}

impl Expected {
    fn sum(x: u32, y: u32) -> Sum {
        let v = i64::from(x) << 40 | i64::from(y) << 20 | 1;
        Sum([v, v * 3, v << 4])
    }

    fn tile(&self, place: u32) -> Vec<Sum> {
        let tile = Tiling::new(self.width, self.height, self.side).shuffled(place, SEED).unwrap();
        (0..tile.width * tile.height)
            .map(|i| Self::sum(tile.x + i % tile.width, tile.y + i / tile.width))
            .collect()
    }
}

struct Net {
    rng: fastrand::Rng,
    faults: Faults,
    wire: BTreeMap<(Time, u64), (NodeId, NodeId, Vec<u8>)>,
    sent: u64,
}

impl Net {
    fn send(&mut self, now: Time, from: NodeId, to: NodeId, message: &Message<'_>) {
        let mut bytes = vec![0; 4096];
        let len = write(&mut bytes, 0, message).unwrap();
        bytes.truncate(len);
        if self.rng.u32(..1000) < self.faults.lose {
            return;
        }
        let copies = 1 + u32::from(self.rng.u32(..1000) < self.faults.double);
        for _ in 0..copies {
            let late = 100_000 + self.rng.u64(..=self.faults.jitter);
            self.sent += 1;
            let _ = self.wire.insert((now.after(Time(late)), self.sent), (from, to, bytes.clone()));
        }
    }
}

/// Runs until the picture is complete: the ledger, and when that was.
fn run(picture: &Expected, nodes: &mut [Node], faults: Faults, seed: u64) -> (Ledger, Time) {
    let unit = Unit::new(1000.0);
    let ledger = Ledger::new(picture.width, picture.height, picture.side, SEED, unit, 1).unwrap();
    let mut ledger = ledger.with_askers(nodes.len() as u32);
    let mut net =
        Net { rng: fastrand::Rng::with_seed(seed), faults, wire: BTreeMap::new(), sent: 0 };
    let mut now = Time(0);
    while !ledger.is_complete() {
        let wire = net.wire.first_key_value().map_or(Time::NEVER, |(&(at, _), _)| at);
        let node = nodes.iter().map(Node::next).min().unwrap();
        now = now.max(wire.min(node));
        assert!(now < END, "it does not end: {:?} {nodes:?}", ledger.counts());
        while let Some(entry) = net.wire.first_entry().filter(|e| e.key().0 <= now) {
            let (from, to, bytes) = entry.remove();
            let message = Items::new(&bytes).next().unwrap();
            if to == HOST {
                ledger.on_message(now, from, &message, &mut |to, reply| {
                    net.send(now, HOST, to, reply);
                });
            } else if let Some(node) = nodes.iter_mut().find(|n| n.id == to && !n.is_dead(now)) {
                node.on_message(now, &message);
            }
        }
        for node in nodes.iter_mut().filter(|node| !node.is_dead(now)) {
            node.act(now, picture, &mut net);
        }
    }
    let picture_now = ledger.picture();
    for (i, pixel) in picture_now.pixels.iter().enumerate() {
        let (x, y) = (i as u32 % picture.width, i as u32 / picture.width);
        assert_eq!(*pixel, unit.resolve(Expected::sum(x, y), 1).to_array(), "pixel {x} {y}");
    }
    let counts = ledger.counts();
    assert_eq!((counts.differing, counts.bad, counts.unexpected), (0, 0, 0));
    assert_eq!(ledger.pixels_done(), ledger.pixels());
    (ledger, now)
}

fn pictures() -> impl Strategy<Value = Expected> {
    (1_u32..60, 1_u32..60, 3_u32..9, 1_usize..40).prop_map(|(width, height, side, run)| Expected {
        width,
        height,
        side,
        run,
    })
}

/// Nodes of these speeds, in eighths of the time of a tile.
fn meshes(eighths: std::ops::Range<u64>) -> impl Strategy<Value = Vec<Node>> {
    let node = (eighths, prop_oneof![1_u32..6, 1_u32..40]);
    prop::collection::vec(node, 1..14).prop_map(|nodes| {
        (0..).zip(nodes).map(|(id, (eighths, wants))| Node::new(id, eighths, wants)).collect()
    })
}

proptest! {
    #[test]
    fn every_picture_is_completed_whatever_the_network_does(
        picture in pictures(), mut nodes in meshes(5..12), seed: u64,
        lose in 0_u32..400, double in 0_u32..400, jitter in 0_u64..20_000_000,
    ) {
        let _ = run(&picture, &mut nodes, Faults { lose, double, jitter }, seed);
    }

    #[test]
    fn the_tiles_of_dead_nodes_are_given_again(
        picture in pictures(), mut nodes in meshes(5..12), seed: u64,
        deaths in prop::collection::vec(0..4 * TILE, 13), lose in 0_u32..100,
    ) {
        // All but the last die, most of them with tiles in hand.
        let mortal = nodes.len() - 1;
        for (node, at) in nodes.iter_mut().take(mortal).zip(deaths) {
            node.dies = Time(at);
        }
        let (ledger, end) = run(&picture, &mut nodes, Faults { lose, ..HEALTHY }, seed);
        // What a node had in hand as it died is complete, so it was given to another as well.
        let dead = nodes.iter().filter(|node| node.is_dead(end));
        let in_hand = dead.flat_map(|n| n.queue.iter().copied().chain(n.work.map(|(tile, _)| tile)));
        let in_hand: BTreeSet<u32> = in_hand.collect();
        prop_assert!(ledger.counts().given_again >= in_hand.len() as u64, "{in_hand:?}");
    }

    #[test]
    fn where_all_is_well_hardly_a_tile_is_rendered_twice(
        picture in pictures(), mut nodes in meshes(7..10), seed: u64,
    ) {
        let (ledger, _) = run(&picture, &mut nodes, HEALTHY, seed);
        let counts = ledger.counts();
        // When a tile is overdue is estimated: some that are three times slower than all before them are taken for lost.
        prop_assert!(counts.given_again <= 1 + counts.given / 50, "{counts:?}");
        let rendered: usize = nodes.iter().map(|n| n.rendered.len()).sum();
        let rendered = rendered as u64;
        prop_assert!((counts.given..=counts.given + counts.given_again).contains(&rendered));
    }
}
