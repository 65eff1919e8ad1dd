use super::leases::{Given, Leases};
use super::outbox::Outbox;
use kiloray_core::network::{Channel, NodeId, Router};
use kiloray_core::node::{Figures, Lack, Next, Time};
use kiloray_core::protocol::{Items, Message, unpack};
use kiloray_core::render::{Tile, Tiling};
use kiloray_core::shade::{Sum, Unit};
use kiloray_render::{Picture, PictureError, filled};
use std::collections::BTreeMap;

/// The picture of a mesh and the tiles that it is rendered in, as the host outside keeps them.
///
/// It only answers: it has no timers, and a reply that is lost is asked for again.
#[derive(Debug)]
pub struct Ledger {
    tiling: Tiling,
    seed: u64,
    unit: Unit,
    samples: u32,
    width: u32,
    height: u32,
    /// Of the pixels of the picture, row by row; `None` until they are there.
    sums: Vec<Option<Sum>>,
    done: u64,
    /// Pixels that are missing, by place of their tile.
    missing: Vec<u32>,
    leases: Leases,
    lost: Option<u32>,
    counts: LedgerCounts,
    /// What nodes have told of themselves, by number.
    told: BTreeMap<u16, Figures>,
    outbox: Outbox,
}

/// What a ledger heard and did.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct LedgerCounts {
    /// Pixels that are there.
    pub pixels: u64,
    /// Messages that were answered or entered.
    pub messages: u64,
    /// Tiles given for the first time.
    pub given: u64,
    /// Tiles that were out for long, and were given to another node as well.
    pub given_again: u64,
    /// Asks that came again, and had the same answer again.
    pub repeated: u64,
    /// Pixels that were there already.
    pub duplicates: u64,
    /// Of those, pixels with another sum: there are none, as long as nodes are sound.
    pub differing: u64,
    /// Messages about tiles, pixels or numbers that do not exist.
    pub bad: u64,
    /// Messages of kinds that are not for a host.
    pub unexpected: u64,
    /// Packets that could not be read to their end.
    pub damaged: u64,
}

/// Least bytes of a sum in [`Message::Pixels`].
const SUM_BYTES_MIN: u64 = 3;

impl Ledger {
    /// The ledger of a picture that nobody has begun: `width × height` pixels in tiles of `side × side`, given out in the
    /// [random order](Tiling::shuffled) of `seed`, with `samples` camera paths a pixel.
    ///
    /// # Errors
    /// [`PictureError::Size`] for a picture that cannot be.
    pub fn new(
        width: u32,
        height: u32,
        side: u32,
        seed: u64,
        unit: Unit,
        samples: u32,
    ) -> Result<Self, PictureError> {
        let sums = filled(width, height, None)?;
        let tiling = Tiling::new(width, height, side);
        let area = |place| tiling.shuffled(place, seed).map_or(0, |t| t.width * t.height);
        let missing = (0..tiling.len()).map(area).collect();
        let leases = Leases::new(tiling.len());
        Ok(Self {
            tiling,
            seed,
            unit,
            samples,
            width,
            height,
            sums,
            done: 0,
            missing,
            leases,
            lost: None,
            counts: LedgerCounts::default(),
            told: BTreeMap::new(),
            outbox: Outbox::default(),
        })
    }

    /// Says how many nodes ask for tiles, so that the first does not take what belongs to all.
    #[must_use]
    pub fn with_askers(mut self, askers: u32) -> Self {
        self.leases.expect(askers);
        self
    }

    /// Takes a message, and hands at most one reply to `reply`.
    pub fn on_message(
        &mut self,
        now: Time,
        from: NodeId,
        message: &Message<'_>,
        reply: &mut impl FnMut(NodeId, &Message<'_>),
    ) {
        match *message {
            Message::Ask { number, count } => {
                let Given { first, count, wait } = self.leases.ask(now, from, number, count);
                reply(from, &Message::Grant { number, first, count, wait });
            }
            Message::Pixels { tile, first, width, sums } => {
                match unpack(sums, width).and_then(|sums| self.enter(now, tile, first, sums)) {
                    Some(0) => reply(from, &Message::Accepted { tile }),
                    Some(_) => {}
                    None => {
                        self.counts.bad += 1;
                        return;
                    }
                }
            }
            Message::Lost { block } => {
                let _ = self.lost.get_or_insert(block);
            }
            Message::Told { figures } => match Figures::parse(figures) {
                Some(figures) => drop(self.told.insert(from.0, figures)),
                None => {
                    self.counts.bad += 1;
                    return;
                }
            },
            _ => {
                self.counts.unexpected += 1;
                return;
            }
        }
        self.counts.messages += 1;
    }

    /// Takes the packets that have arrived at the host's router, and sends replies as far as there is room. Those that wait for it share
    /// packets with others to the same node; when very many do, no more packets are taken.
    pub fn poll(&mut self, now: Time, router: &mut Router<'_>) -> Next {
        let wait = |lack| Next::Wait { until: Time::NEVER, lack };
        loop {
            let is_sent = self.outbox.send(router);
            if !is_sent && self.outbox.is_full() {
                return wait(Lack::Credit);
            }
            let arrived = Channel::ALL.into_iter().find(|&c| router.arrived(c).is_some());
            let Some(channel) = arrived else {
                return wait(if is_sent { Lack::Tiles } else { Lack::Credit });
            };
            let Some((from, payload)) = router.arrived(channel) else { continue };
            let room = router.payload_of(Channel::Reply);
            let mut outbox = std::mem::take(&mut self.outbox);
            let mut items = Items::new(payload);
            for message in &mut items {
                self.on_message(now, from, &message, &mut |to, reply| {
                    outbox.push(to, reply, room);
                });
            }
            self.counts.damaged += u64::from(items.is_damaged());
            self.outbox = outbox;
            router.consume(channel);
        }
    }

    /// Whether every pixel is there.
    #[must_use]
    pub const fn is_complete(&self) -> bool {
        self.leases.is_done()
    }

    /// The first block of which a node found no living copy: the picture cannot be completed.
    #[must_use]
    pub const fn lost(&self) -> Option<u32> {
        self.lost
    }

    /// Pixels that are there.
    #[must_use]
    pub const fn pixels_done(&self) -> u64 {
        self.done
    }

    /// Pixels of the picture.
    #[must_use]
    pub const fn pixels(&self) -> u64 {
        self.sums.len() as u64
    }

    /// Messages with the pixels that are missing have at least so many bytes.
    #[must_use]
    pub const fn bytes_missing(&self) -> u64 {
        self.pixels().saturating_sub(self.done).saturating_mul(SUM_BYTES_MIN)
    }

    /// What nodes that were asked have told of themselves, by number.
    #[must_use]
    pub const fn told(&self) -> &BTreeMap<u16, Figures> {
        &self.told
    }

    /// What it heard and did.
    #[must_use]
    pub const fn counts(&self) -> LedgerCounts {
        let leases = self.leases.counts;
        LedgerCounts {
            pixels: self.done,
            given: leases.given,
            given_again: leases.given_again,
            repeated: leases.repeated,
            ..self.counts
        }
    }

    /// The picture as far as it is there; what is not is black.
    #[must_use]
    pub fn picture(&self) -> Picture {
        let pixel = |sum: &Option<Sum>| {
            self.unit.resolve(sum.unwrap_or(Sum::ZERO), self.samples).to_array()
        };
        let pixels = self.sums.iter().map(pixel).collect();
        Picture { width: self.width, height: self.height, pixels }
    }

    /// Pixels whose sum was too great to count.
    #[must_use]
    pub fn overflows(&self) -> u64 {
        self.sums.iter().flatten().filter(|sum| sum.is_full()).count() as u64
    }

    /// Enters a run of pixels of a tile: how many the tile still lacks; `None` if there is no such run.
    fn enter(
        &mut self,
        now: Time,
        place: u32,
        first: u32,
        sums: impl ExactSizeIterator<Item = Sum>,
    ) -> Option<u32> {
        let tile = self.tiling.shuffled(place, self.seed)?;
        let end = (first as usize).checked_add(sums.len())?;
        if end > tile.width as usize * tile.height as usize {
            return None;
        }
        let missing = self.missing.get_mut(place as usize)?;
        for (pixel, sum) in (first..).zip(sums) {
            match self.sums.get_mut(self::index(&tile, pixel, self.width))? {
                Some(here) => {
                    self.counts.duplicates += 1;
                    self.counts.differing += u64::from(*here != sum);
                }
                place => {
                    *place = Some(sum);
                    self.done += 1;
                    *missing -= 1;
                }
            }
        }
        let missing = *missing;
        if missing == 0 {
            self.leases.complete(now, place);
        }
        Some(missing)
    }
}

/// Where a pixel of a tile lies in the picture.
const fn index(tile: &Tile, pixel: u32, width: u32) -> usize {
    let (x, y) = (tile.x + pixel % tile.width, tile.y + pixel / tile.width);
    y as usize * width as usize + x as usize
}
