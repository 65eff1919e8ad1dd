use std::collections::HashMap;

use kiloray_core::network::{HOST, NodeId};
use kiloray_core::path::PathKey;
use kiloray_core::protocol::{Items, Message, ReturnAddress};

use crate::report::Recorder;
use crate::{Latencies, TraceFlow};

/// Looks on at what nodes send and receive, and takes down how long they wait: nodes themselves do not keep it.
///
/// A wait begins when the first request enters a link, and ends when its answer is at the node that asked, however
/// often it had to ask.
#[derive(Debug)]
pub(crate) struct Watch {
    /// Whoever asks for a block has it with its last byte.
    block_bytes: u32,
    /// Blocks that are asked for. Entries of these maps are looked up, never listed.
    fetches: HashMap<(u16, u32), Fetch>,
    /// Rays that are away, by the slot that waits for them.
    rays: HashMap<(u16, u16), (PathKey, u64)>,
    /// Tiles that are given out.
    tiles: HashMap<u32, u64>,
    /// Fetches that have ended, and how many of them are kept.
    flows: Vec<TraceFlow>,
    flows_max: usize,
    fetch: Recorder,
    fetch_request: Recorder,
    fetch_owner: Recorder,
    fetch_reply: Recorder,
    ray: Recorder,
    tile: Recorder,
}

/// A block that is asked for.
#[derive(Debug, Clone, Copy)]
struct Fetch {
    /// When the first request entered a link.
    since: u64,
    /// When a request came to the owner, and when the first piece left it; 0 before.
    asked: u64,
    served: u64,
    /// Who sent it.
    owner: u16,
    /// The ends of the steps in which the request and the first piece were made.
    asked_in: u64,
    served_in: u64,
}

impl Watch {
    /// Nothing is under way. Of so many fetches it is taken down between whom they were.
    pub(crate) fn new(block_bytes: usize, flows_max: usize) -> Self {
        Self {
            block_bytes: block_bytes as u32,
            fetches: HashMap::new(),
            rays: HashMap::new(),
            tiles: HashMap::new(),
            flows: Vec::new(),
            flows_max,
            fetch: Recorder::new(),
            fetch_request: Recorder::new(),
            fetch_owner: Recorder::new(),
            fetch_reply: Recorder::new(),
            ray: Recorder::new(),
            tile: Recorder::new(),
        }
    }

    /// A packet leaves the place that has made it, in the step that ends, or has ended, at `step`.
    pub(crate) fn departs(
        &mut self,
        (now, step): (u64, u64),
        from: NodeId,
        to: NodeId,
        payload: &[u8],
    ) {
        for message in Items::new(payload) {
            match message {
                Message::Fetch { block, .. } => {
                    let fetch = Fetch {
                        since: now,
                        asked: 0,
                        served: 0,
                        owner: to.0,
                        asked_in: step,
                        served_in: 0,
                    };
                    self.fetches.entry((from.0, block)).or_insert(fetch);
                }
                Message::Part { block, .. } => {
                    if let Some(fetch) = self.fetches.get_mut(&(to.0, block))
                        && fetch.served == 0
                    {
                        (fetch.served, fetch.served_in, fetch.owner) = (now, step, from.0);
                    }
                }
                Message::Ray(ray) if ray.reply.node() == from => {
                    let (slot, key) = slot(&ray.reply);
                    let entry = self.rays.entry(slot).or_insert((key, now));
                    if entry.0 != key {
                        *entry = (key, now);
                    }
                }
                Message::Grant { first, count, .. } if from == HOST => {
                    for tile in first..first.saturating_add(count) {
                        self.tiles.entry(tile).or_insert(now);
                    }
                }
                Message::Accepted { tile } => {
                    if let Some(since) = self.tiles.remove(&tile) {
                        self.tile.record(now - since);
                    }
                }
                _ => {}
            }
        }
    }

    /// A packet is where it belongs.
    pub(crate) fn arrives(&mut self, now: u64, from: NodeId, at: NodeId, payload: &[u8]) {
        for message in Items::new(payload) {
            match message {
                Message::Fetch { block, .. } => {
                    if let Some(fetch) = self.fetches.get_mut(&(from.0, block))
                        && fetch.asked == 0
                    {
                        fetch.asked = now;
                    }
                }
                Message::Part { block, offset, bytes }
                    if offset.saturating_add(bytes.len() as u32) >= self.block_bytes =>
                {
                    if let Some(fetch) = self.fetches.remove(&(at.0, block)) {
                        let Fetch { since, asked, served, owner, asked_in, served_in } = fetch;
                        if self.flows.len() < self.flows_max {
                            self.flows.push(TraceFlow {
                                block,
                                asker: at.0,
                                owner,
                                asked_ns: asked_in,
                                served_ns: served_in,
                                arrived_ns: now,
                            });
                        }
                        self.fetch.record(now - since);
                        self.fetch_request.record(asked.saturating_sub(since));
                        self.fetch_owner.record(served.saturating_sub(asked));
                        self.fetch_reply.record(now - served);
                    }
                }
                Message::Answer { to, .. } => {
                    let (slot, key) = slot(&to);
                    if let Some(&(of, since)) = self.rays.get(&slot)
                        && of == key
                    {
                        self.rays.remove(&slot);
                        self.ray.record(now - since);
                    }
                }
                _ => {}
            }
        }
    }

    /// The fetches that were taken down.
    pub(crate) fn take_flows(&mut self) -> Vec<TraceFlow> {
        std::mem::take(&mut self.flows)
    }

    /// What was taken down.
    pub(crate) fn latencies(&self) -> Latencies {
        Latencies {
            fetch: self.fetch.histogram(),
            fetch_request: self.fetch_request.histogram(),
            fetch_owner: self.fetch_owner.histogram(),
            fetch_reply: self.fetch_reply.histogram(),
            ray: self.ray.histogram(),
            tile: self.tile.histogram(),
        }
    }
}

fn slot(address: &ReturnAddress) -> ((u16, u16), PathKey) {
    ((address.node().0, address.slot()), address.key())
}
