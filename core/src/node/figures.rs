use super::{Counts, Node, Time, World};
use crate::network::HOST;
use crate::protocol::{Item, Message};
use crate::store::{Line, LineBudget};
use bytemuck::{Pod, Zeroable};

/// What a node tells of itself when the host asks ([`Message::Tell`]): its memory, line by line, and what it did.
///
/// Plain little-endian words, 168 bytes: any packet has room for them. A count too great for its word is the greatest that fits.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct Figures {
    /// The memory that it divides \[bytes\].
    pub memory: u32,
    /// Capacity \[items\], bytes, and peak \[items\] of each line, in the order of [`Line::ALL`].
    lines: [[u32; 3]; Line::ALL.len()],
    /// Some of its counts, in the order of `told`.
    counts: [u32; COUNTS],
}

const COUNTS: usize = 17;
const _: () = assert!(Figures::BYTES + Item::BYTES <= super::plan::PAYLOAD_MIN);

/// The counts that are told.
fn told(counts: &mut Counts) -> [&mut u64; COUNTS] {
    [
        &mut counts.shade.primary,
        &mut counts.shade.shadow,
        &mut counts.shade.specular,
        &mut counts.cache.hits,
        &mut counts.cache.misses,
        &mut counts.cache.evictions,
        &mut counts.cache.fetched,
        &mut counts.tiles,
        &mut counts.migrated,
        &mut counts.refused,
        &mut counts.run_at_home,
        &mut counts.rays_again,
        &mut counts.fetches_again,
        &mut counts.tiles_again,
        &mut counts.unasked,
        &mut counts.damaged,
        &mut counts.blocks_refused,
    ]
}

impl Figures {
    /// Its length.
    pub const BYTES: usize = size_of::<Self>();

    /// Reads figures; `None` if they are of another length.
    #[must_use]
    pub fn parse(bytes: &[u8]) -> Option<Self> {
        bytemuck::try_pod_read_unaligned(bytes).ok()
    }

    /// The lines that take anything.
    pub fn lines(&self) -> impl Iterator<Item = LineBudget> {
        let lines = Line::ALL.into_iter().zip(self.lines);
        lines.filter(|(_, [_, bytes, _])| *bytes > 0).map(|(line, words)| {
            let [capacity, bytes, peak] = words.map(|word| word as usize);
            LineBudget { line, capacity, bytes, peak }
        })
    }

    /// Bytes in use when each line was fullest.
    #[must_use]
    pub fn peak_bytes(&self) -> usize {
        self.lines().fold(0, |sum, line| sum.saturating_add(line.peak_bytes()))
    }

    /// What it did; counts that are not told are 0.
    #[must_use]
    pub fn counts(&self) -> Counts {
        let mut counts = Counts::default();
        for (count, word) in told(&mut counts).into_iter().zip(self.counts) {
            *count = word.into();
        }
        counts
    }
}

impl<W: World> Node<'_, W> {
    /// What it tells of itself.
    #[must_use]
    pub fn figures(&self) -> Figures {
        let budget = self.budget();
        let mut figures = Figures { memory: budget.memory() as u32, ..Figures::zeroed() };
        for (words, line) in figures.lines.iter_mut().zip(budget.lines()) {
            *words = [line.capacity, line.bytes, line.peak].map(|size| size as u32);
        }
        for (word, count) in figures.counts.iter_mut().zip(told(&mut self.counts())) {
            *word = (*count).min(u32::MAX.into()) as u32;
        }
        figures
    }

    /// Tells the host, if there is room: it asks again. Apart from what traces, whose calls are the deepest.
    #[inline(never)]
    pub(super) fn tell(&mut self, now: Time) {
        let figures = self.figures();
        let told = Message::Told { figures: bytemuck::bytes_of(&figures) };
        let _ = self.push(HOST, &told, now);
    }
}
