use crate::protocol::Message;
use crate::shade;
use crate::store::CacheCounts;
use crate::tally::tally;

/// What a node did so far.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Counts {
    /// Rays traced, and what was skipped.
    pub shade: shade::Counts,
    /// What the block cache did.
    pub cache: CacheCounts,
    /// Tiles rendered.
    pub tiles: u64,
    /// Packets that left, apart from those that passed through.
    pub packets: u64,
    /// Messages sent, by kind.
    pub sent: Kinds,
    /// Messages handled, by kind.
    pub received: Kinds,
    /// Rays sent to other nodes.
    pub migrated: u64,
    /// Hits whose shadow rays were given to other nodes.
    pub lights_given: u64,
    /// Hits that were sent to the owners of their blocks.
    pub points_moved: u64,
    /// Rays and hits of other nodes that were run here.
    pub visitors: u64,
    /// Rays that other nodes refused.
    pub refused: u64,
    /// Rays run at home after too many refusals.
    pub run_at_home: u64,
    /// Requests for rays made again after their time limit.
    pub rays_again: u64,
    /// Requests for blocks made again after their time limit.
    pub fetches_again: u64,
    /// Tiles sent to the host again.
    pub tiles_again: u64,
    /// Answers, refusals, blocks that nobody waited for: late, doubled or unknown.
    pub unasked: u64,
    /// Packets that could not be read.
    pub damaged: u64,
    /// Blocks that arrived damaged.
    pub blocks_refused: u64,
    /// Times a step could not go on for want of a frame, a slot, or room to send.
    pub stalls: u64,
    /// Most rays, shadow rays and visitors held at once.
    pub rays_peak: u32,
    /// See `rays_peak`.
    pub shadows_peak: u32,
    /// See `rays_peak`.
    pub visitors_peak: u32,
    /// Most tiles held at once.
    pub tiles_peak: u32,
}

impl Counts {
    /// Adds what another node did. Of peaks the greater is kept.
    pub fn add(&mut self, other: &Self) {
        tally!(self, other, Self {
            sum tiles, packets, migrated, lights_given, points_moved, visitors, refused,
                run_at_home, rays_again, fetches_again, tiles_again, unasked, damaged,
                blocks_refused, stalls;
            max rays_peak, shadows_peak, visitors_peak, tiles_peak;
            parts shade, cache, sent, received;
        });
    }
}

/// Messages by kind.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Kinds {
    /// [`Message::Fetch`].
    pub fetch: Kind,
    /// [`Message::Part`].
    pub part: Kind,
    /// Asks, grants, pixels, acceptances, and who is idle: all about tiles; and what nodes tell of themselves.
    pub tile: Kind,
    /// [`Message::Ray`].
    pub ray: Kind,
    /// [`Message::Answer`].
    pub answer: Kind,
    /// [`Message::Refusal`], [`Message::AtWork`] and [`Message::Gone`].
    pub refusal: Kind,
}

impl Kinds {
    /// Each with its name.
    #[must_use]
    pub const fn named(&self) -> [(&'static str, Kind); 6] {
        let Self { fetch, part, tile, ray, answer, refusal } = *self;
        [
            ("fetch", fetch),
            ("part", part),
            ("tile", tile),
            ("ray", ray),
            ("answer", answer),
            ("refusal", refusal),
        ]
    }

    fn add(&mut self, other: &Self) {
        tally!(self, other, Self { parts fetch, part, tile, ray, answer, refusal; });
    }
}

/// Messages of one kind.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Kind {
    /// How many.
    pub count: u64,
    /// Their bytes, without packet headers.
    pub bytes: u64,
}

impl Kind {
    fn add(&mut self, other: &Self) {
        tally!(self, other, Self { sum count, bytes; });
    }
}

impl Kinds {
    /// Counts a message of so many bytes.
    pub(super) fn note(&mut self, message: &Message<'_>, bytes: usize) {
        let kind = match message {
            Message::Fetch { .. } | Message::Lost { .. } => &mut self.fetch,
            Message::Part { .. } => &mut self.part,
            Message::Ask { .. }
            | Message::Idle
            | Message::Grant { .. }
            | Message::Pixels { .. }
            | Message::Accepted { .. }
            | Message::Tell
            | Message::Told { .. } => &mut self.tile,
            Message::Ray(_) => &mut self.ray,
            Message::Answer { .. } => &mut self.answer,
            Message::Refusal { .. } | Message::AtWork { .. } | Message::Gone => &mut self.refusal,
        };
        kind.count = kind.count.saturating_add(1);
        kind.bytes = kind.bytes.saturating_add(bytes as u64);
    }
}
