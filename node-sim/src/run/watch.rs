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

/// What is to be seen of a packet at one of its ends.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Sight {
    /// A request for a block leaves, made in the step that ends, or has ended, at `step`.
    Asks { asker: u16, block: u32, owner: u16, step: u64 },
    /// It has come to who is to send the block.
    IsAsked { asker: u16, block: u32 },
    /// A piece of a block leaves.
    Serves { asker: u16, block: u32, owner: u16, step: u64 },
    /// A piece is where it was asked for, and ends at this byte.
    HasPart { asker: u16, block: u32, end: u32 },
    /// A ray leaves the slot that waits for it.
    RayLeaves { slot: (u16, u16), key: PathKey },
    /// Its answer has come.
    Answer { slot: (u16, u16), key: PathKey },
    /// Tiles are given out.
    Grant { first: u32, count: u32 },
    /// A tile is complete.
    Accepted { tile: u32 },
}

impl Sight {
    /// Of a packet that leaves the place that has made it, in the step that ends, or has ended, at `step`.
    pub(crate) fn leaving(
        from: NodeId,
        to: NodeId,
        step: u64,
        payload: &[u8],
    ) -> impl Iterator<Item = Self> {
        let (asker, owner) = (to.0, from.0);
        Items::new(payload).filter_map(move |message| match message {
            Message::Fetch { block, .. } => {
                Some(Self::Asks { asker: from.0, block, owner: to.0, step })
            }
            Message::Part { block, .. } => Some(Self::Serves { asker, block, owner, step }),
            Message::Ray(ray) if ray.reply.node() == from => {
                let (slot, key) = slot(&ray.reply);
                Some(Self::RayLeaves { slot, key })
            }
            Message::Grant { first, count, .. } if from == HOST => {
                Some(Self::Grant { first, count })
            }
            Message::Accepted { tile } => Some(Self::Accepted { tile }),
            _ => None,
        })
    }

    /// Of a packet that is where it belongs.
    pub(crate) fn arriving(from: NodeId, at: NodeId, payload: &[u8]) -> impl Iterator<Item = Self> {
        Items::new(payload).filter_map(move |message| match message {
            Message::Fetch { block, .. } => Some(Self::IsAsked { asker: from.0, block }),
            Message::Part { block, offset, bytes } => {
                let end = offset.saturating_add(bytes.len() as u32);
                Some(Self::HasPart { asker: at.0, block, end })
            }
            Message::Answer { to, .. } => {
                let (slot, key) = slot(&to);
                Some(Self::Answer { slot, key })
            }
            _ => None,
        })
    }
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

    /// Takes down what was seen.
    pub(crate) fn see(&mut self, now: u64, sight: Sight) {
        match sight {
            Sight::Asks { asker, block, owner, step } => {
                let fetch =
                    Fetch { since: now, asked: 0, served: 0, owner, asked_in: step, served_in: 0 };
                self.fetches.entry((asker, block)).or_insert(fetch);
            }
            Sight::IsAsked { asker, block } => {
                if let Some(fetch) = self.fetches.get_mut(&(asker, block))
                    && fetch.asked == 0
                {
                    fetch.asked = now;
                }
            }
            Sight::Serves { asker, block, owner, step } => {
                if let Some(fetch) = self.fetches.get_mut(&(asker, block))
                    && fetch.served == 0
                {
                    (fetch.served, fetch.served_in, fetch.owner) = (now, step, owner);
                }
            }
            Sight::HasPart { asker, block, end } => {
                if end >= self.block_bytes {
                    self.has_block(now, asker, block);
                }
            }
            Sight::RayLeaves { slot, key } => {
                let entry = self.rays.entry(slot).or_insert((key, now));
                if entry.0 != key {
                    *entry = (key, now);
                }
            }
            Sight::Answer { slot, key } => {
                if let Some(&(of, since)) = self.rays.get(&slot)
                    && of == key
                {
                    self.rays.remove(&slot);
                    self.ray.record(now - since);
                }
            }
            Sight::Grant { first, count } => {
                for tile in first..first.saturating_add(count) {
                    self.tiles.entry(tile).or_insert(now);
                }
            }
            Sight::Accepted { tile } => {
                if let Some(since) = self.tiles.remove(&tile) {
                    self.tile.record(now - since);
                }
            }
        }
    }

    /// The last byte of a block is where it was asked for.
    fn has_block(&mut self, now: u64, asker: u16, block: u32) {
        let Some(fetch) = self.fetches.remove(&(asker, block)) else { return };
        let Fetch { since, asked, served, owner, asked_in, served_in } = fetch;
        if self.flows.len() < self.flows_max {
            self.flows.push(TraceFlow {
                block,
                asker,
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
