//! How long nodes wait for blocks, answers and tiles, as packets show.

mod histogram;

use kiloray_core::network::{HOST, NodeId};
use kiloray_core::path::PathKey;
use kiloray_core::protocol::{Items, Message, RayMessage, ReturnAddress};

use histogram::Recorder;
pub use histogram::{Histogram, HistogramBucket, Latencies};
use rustc_hash::FxHashMap;
use serde::{Deserialize, Serialize};

/// Looks on at what nodes send and receive, and takes down how long they wait: nodes themselves do not keep it.
///
/// A wait begins when the first request enters a link, and ends when its answer is at the node that asked, however
/// often it had to ask.
#[derive(Debug)]
pub struct Watch {
    /// Whoever asks for a block has it with all of its bytes.
    block_bytes: u32,
    /// Blocks that are asked for. Entries of these maps are looked up, never listed.
    fetches: FxHashMap<(u16, u32), Fetch>,
    /// Rays that are away, by the slot that waits for them.
    rays: FxHashMap<(u16, u16), (PathKey, u64)>,
    /// Tiles that are given out.
    tiles: FxHashMap<u32, u64>,
    /// Fetches that have ended, and how many of them are kept.
    flows: Vec<TraceFlow>,
    flows_max: usize,
    waits: Waits,
}

/// What was taken down of how long things took. It can be sent, and put together with what others have taken down.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(default)]
pub struct Waits {
    fetch: Recorder,
    fetch_request: Recorder,
    fetch_owner: Recorder,
    fetch_reply: Recorder,
    ray: Recorder,
    tile: Recorder,
}

impl Waits {
    /// Whether nothing was taken down.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }

    /// Takes over what another has taken down.
    pub fn add(&mut self, other: &Self) {
        let Self { fetch, fetch_request, fetch_owner, fetch_reply, ray, tile } = self;
        for (all, other) in [
            (fetch, &other.fetch),
            (fetch_request, &other.fetch_request),
            (fetch_owner, &other.fetch_owner),
            (fetch_reply, &other.fetch_reply),
            (ray, &other.ray),
            (tile, &other.tile),
        ] {
            all.add(other);
        }
    }

    /// In figures.
    #[must_use]
    pub fn latencies(&self) -> Latencies {
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

/// The way of a request for a block, and of the block.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct TraceFlow {
    /// The block.
    pub block: u32,
    /// The node that asked for it.
    pub asker: u16,
    /// The node that sent it.
    pub owner: u16,
    /// When the asker's last step went on or had ended, as the request left \[ns\].
    pub asked_ns: u64,
    /// When the owner's last step went on or had ended, as the first piece left \[ns\].
    pub served_ns: u64,
    /// When the last piece was there \[ns\].
    pub arrived_ns: u64,
}

/// What is to be seen of a packet at one of its ends.
#[derive(Debug, Clone, Copy)]
pub struct Sight(Seen);

#[derive(Debug, Clone, Copy)]
enum Seen {
    /// A request for a block leaves, made in the step that ends, or has ended, at `step`.
    Asks { asker: u16, block: u32, owner: u16, step: u64 },
    /// It has come to who is to send the block.
    IsAsked { asker: u16, block: u32 },
    /// A piece of a block leaves.
    Serves { asker: u16, block: u32, owner: u16, step: u64 },
    /// A piece is where it was asked for.
    HasPart { asker: u16, block: u32, offset: u32, bytes: u32 },
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
    pub fn leaving(
        from: NodeId,
        to: NodeId,
        step: u64,
        payload: &[u8],
    ) -> impl Iterator<Item = Self> {
        let (asker, owner) = (to.0, from.0);
        let seen = Items::new(payload).filter_map(move |message| match message {
            Message::Fetch { block, .. } => {
                Some(Seen::Asks { asker: from.0, block, owner: to.0, step })
            }
            Message::Part { block, .. } => Some(Seen::Serves { asker, block, owner, step }),
            Message::Ray(ray) => {
                let RayMessage { reply, .. } = RayMessage::read(ray);
                let (slot, key) = slot(&reply);
                (reply.node() == from).then_some(Seen::RayLeaves { slot, key })
            }
            Message::Grant { first, count, .. } if from == HOST => {
                Some(Seen::Grant { first, count })
            }
            Message::Accepted { tile } => Some(Seen::Accepted { tile }),
            _ => None,
        });
        seen.map(Self)
    }

    /// Of a packet that is where it belongs.
    pub fn arriving(from: NodeId, at: NodeId, payload: &[u8]) -> impl Iterator<Item = Self> {
        let seen = Items::new(payload).filter_map(move |message| match message {
            Message::Fetch { block, .. } => Some(Seen::IsAsked { asker: from.0, block }),
            Message::Part { block, offset, bytes, .. } => {
                let bytes = bytes.len() as u32;
                Some(Seen::HasPart { asker: at.0, block, offset, bytes })
            }
            Message::Answer { to, .. } => {
                let (slot, key) = slot(&to);
                Some(Seen::Answer { slot, key })
            }
            _ => None,
        });
        seen.map(Self)
    }
}

/// A block that is asked for.
#[derive(Debug, Clone, Copy, Default)]
struct Fetch {
    /// When the first request entered a link.
    since: u64,
    /// When a request came to the owner, and when the first piece left it; 0 before.
    asked: u64,
    served: u64,
    /// Who sent it.
    owner: u16,
    /// Which pieces are there, and their bytes.
    pieces: u128,
    bytes: u32,
    /// The ends of the steps in which the request and the first piece were made.
    asked_in: u64,
    served_in: u64,
}

impl Fetch {
    /// A piece has come, perhaps once more: whether all are there. A block has [128](kiloray_core::node::NodePlan::packet_min) pieces at most.
    fn has(&mut self, offset: u32, bytes: u32, block_bytes: u32) -> bool {
        let number = u64::from(offset) * 128 / u64::from(block_bytes.max(1));
        let piece = 1_u128.checked_shl(number as u32).unwrap_or(0);
        if self.pieces & piece == 0 {
            self.pieces |= piece;
            self.bytes = self.bytes.saturating_add(bytes);
        }
        self.bytes >= block_bytes
    }
}

impl Watch {
    /// Nothing is under way. Of so many fetches it is taken down between whom they were.
    pub fn new(block_bytes: usize, flows_max: usize) -> Self {
        Self {
            block_bytes: block_bytes as u32,
            fetches: FxHashMap::default(),
            rays: FxHashMap::default(),
            tiles: FxHashMap::default(),
            flows: Vec::new(),
            flows_max,
            waits: Waits::default(),
        }
    }

    /// Takes down what was seen.
    pub fn see(&mut self, now: u64, sight: Sight) {
        match sight.0 {
            Seen::Asks { asker, block, owner, step } => {
                let fetch = Fetch { since: now, owner, asked_in: step, ..Fetch::default() };
                self.fetches.entry((asker, block)).or_insert(fetch);
            }
            Seen::IsAsked { asker, block } => {
                if let Some(fetch) = self.fetches.get_mut(&(asker, block))
                    && fetch.asked == 0
                {
                    fetch.asked = now;
                }
            }
            Seen::Serves { asker, block, owner, step } => {
                if let Some(fetch) = self.fetches.get_mut(&(asker, block))
                    && fetch.served == 0
                {
                    (fetch.served, fetch.served_in, fetch.owner) = (now, step, owner);
                }
            }
            Seen::HasPart { asker, block, offset, bytes } => {
                let Some(fetch) = self.fetches.get_mut(&(asker, block)) else { return };
                if fetch.has(offset, bytes, self.block_bytes) {
                    self.has_block(now, asker, block);
                }
            }
            Seen::RayLeaves { slot, key } => {
                let entry = self.rays.entry(slot).or_insert((key, now));
                if entry.0 != key {
                    *entry = (key, now);
                }
            }
            Seen::Answer { slot, key } => {
                if let Some(&(of, since)) = self.rays.get(&slot)
                    && of == key
                {
                    self.rays.remove(&slot);
                    self.waits.ray.record(now.saturating_sub(since), 1);
                }
            }
            Seen::Grant { first, count } => {
                for tile in first..first.saturating_add(count) {
                    self.tiles.entry(tile).or_insert(now);
                }
            }
            Seen::Accepted { tile } => {
                if let Some(since) = self.tiles.remove(&tile) {
                    self.waits.tile.record(now.saturating_sub(since), 1);
                }
            }
        }
    }

    /// All of a block is where it was asked for.
    fn has_block(&mut self, now: u64, asker: u16, block: u32) {
        let Some(fetch) = self.fetches.remove(&(asker, block)) else { return };
        let Fetch { since, asked, served, owner, asked_in, served_in, .. } = fetch;
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
        self.waits.fetch.record(now.saturating_sub(since), 1);
        // Who sees one end alone does not see what the owner does.
        if asked > 0 && served > 0 {
            self.waits.fetch_request.record(asked.saturating_sub(since), 1);
            self.waits.fetch_owner.record(served.saturating_sub(asked), 1);
            self.waits.fetch_reply.record(now.saturating_sub(served), 1);
        }
    }

    /// The fetches that were taken down.
    pub fn take_flows(&mut self) -> Vec<TraceFlow> {
        std::mem::take(&mut self.flows)
    }

    /// What was taken down.
    #[must_use]
    pub const fn waits(&self) -> &Waits {
        &self.waits
    }
}

fn slot(address: &ReturnAddress) -> ((u16, u16), PathKey) {
    ((address.node().0, address.slot()), address.key())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_block_is_there_with_its_last_missing_piece() {
        for (block, piece) in [(4096, 4096), (4096, 1068), (65_536, 516), (1024, 8)] {
            let offsets: Vec<u32> = (0..block).step_by(piece as usize).collect();
            let mut fetch = Fetch::default();
            let mut has = |offset: u32| fetch.has(offset, piece.min(block - offset), block);
            for &offset in offsets.iter().skip(1).rev() {
                assert!(!has(offset) && !has(offset), "{block} {piece} {offset}");
            }
            assert!(has(0), "{block} {piece}");
        }
    }
}
