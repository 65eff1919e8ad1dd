//! Where to cut a set of primitives in two: the surface-area heuristic.
//!
//! MacDonald & Booth 1990; many primitives in bins (Wald 2007), few by a full sweep. Counts are
//! rounded up to whole records, so that records come out full. A cut always exists: where planes
//! cannot tell the primitives apart, they are halved by count.

use kiloray_core::block::format::RECORD_PRIMITIVES;

use super::bounds::{Bounds, Item};

/// Bins per axis.
const BINS: usize = 32;
/// Up to so many primitives are swept.
pub(crate) const SWEEP_MAX: usize = 64;

/// A cut along one axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Cut {
    /// Area times records, summed over both sides; of the whole where this axis cannot tell them apart.
    pub(crate) cost: f32,
    at: At,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum At {
    /// So many go below, in the order of centres.
    Count(usize),
    /// Bins up to this one go below.
    Bin { last: u32, min: f32, scale: f32 },
}

/// Records that `count` primitives fill.
fn records(count: usize) -> f32 {
    count.div_ceil(RECORD_PRIMITIVES) as f32
}

/// The cut into halves by count.
pub(crate) fn halves(items: &[Item]) -> Cut {
    Cut { cost: f32::INFINITY, at: At::Count(items.len() / 2) }
}

/// The best cut of each axis. There are at least two items.
pub(crate) fn cuts(items: &[Item]) -> [Cut; 3] {
    if items.len() > SWEEP_MAX {
        return bins(items);
    }
    let mut records = Records::new(items);
    [0, 1, 2].map(|axis| sweep(items, axis, &mut records))
}

/// A key that orders items along an axis: by centre, then by position in the slice.
fn key(item: &Item, axis: usize, index: usize) -> u64 {
    let bits = (item.center2(axis) + 0.0).to_bits();
    let ordered = if bits >> 31 == 0 { bits | 1 << 31 } else { !bits };
    u64::from(ordered) << 32 | index as u64
}

/// Records as items are added: a record holds items of one group.
struct Records {
    /// Of each item, the first item of its group.
    group: [u8; SWEEP_MAX],
    /// Items so far, by the first of their group.
    counts: [u8; SWEEP_MAX],
    records: u32,
}

impl Records {
    fn new(items: &[Item]) -> Self {
        let mut group = [0; SWEEP_MAX];
        for (i, item) in items.iter().enumerate() {
            // Most sets are of one group.
            let first = items.iter().position(|other| other.group == item.group);
            group[i] = first.unwrap_or(i) as u8;
        }
        Self { group, counts: [0; SWEEP_MAX], records: 0 }
    }

    fn clear(&mut self) {
        self.counts = [0; SWEEP_MAX];
        self.records = 0;
    }

    /// Adds an item; returns the records of all so far.
    fn add(&mut self, item: usize) -> f32 {
        let count = &mut self.counts[usize::from(self.group[item])];
        self.records += u32::from(usize::from(*count).is_multiple_of(RECORD_PRIMITIVES));
        *count += 1;
        self.records as f32
    }
}

fn sweep(items: &[Item], axis: usize, records: &mut Records) -> Cut {
    let n = items.len();
    let mut keys = [0; SWEEP_MAX];
    let keys = &mut keys[..n];
    for (i, (key_, item)) in keys.iter_mut().zip(items).enumerate() {
        *key_ = key(item, axis, i);
    }
    keys.sort_unstable();
    let item = |rank: usize| keys[rank] as u32 as usize;
    let mut above = [0.0; SWEEP_MAX];
    let mut bounds = Bounds::EMPTY;
    records.clear();
    for rank in (1..n).rev() {
        bounds.grow(items[item(rank)].lanes());
        above[rank] = bounds.area() * records.add(item(rank));
    }
    let mut best = Cut { cost: f32::INFINITY, at: At::Count(n / 2) };
    let mut off_middle = n;
    let mut bounds = Bounds::EMPTY;
    records.clear();
    for (rank, above) in above.iter().enumerate().take(n).skip(1) {
        bounds.grow(items[item(rank - 1)].lanes());
        let cost = bounds.area() * records.add(item(rank - 1)) + above;
        // Where all cuts cost the same, as in a heap of equal boxes, the middle makes the shallowest tree.
        let off = rank.abs_diff(n / 2);
        if cost < best.cost || cost == best.cost && off < off_middle {
            best = Cut { cost, at: At::Count(rank) };
            off_middle = off;
        }
    }
    best
}

fn bin_of(center2: f32, min: f32, scale: f32) -> usize {
    (((center2 - min) * scale) as usize).min(BINS - 1)
}

fn bins(items: &[Item]) -> [Cut; 3] {
    let mut centers = Bounds::EMPTY;
    for item in items {
        let c = [item.center2(0), item.center2(1), item.center2(2)];
        centers.grow(&[c[0], c[1], c[2], 0.0, -c[0], -c[1], -c[2], 0.0]);
    }
    let (min, max) = (centers.lo(), centers.hi());
    let scale: [f32; 3] = std::array::from_fn(|i| {
        let scale = BINS as f32 * (1.0 - 1e-6) / (max[i] - min[i]);
        if scale.is_finite() { scale } else { 0.0 }
    });
    let mut bounds = [[Bounds::EMPTY; BINS]; 3];
    let mut counts = [[0_u32; BINS]; 3];
    for item in items {
        for axis in 0..3 {
            let bin = bin_of(item.center2(axis), min[axis], scale[axis]);
            bounds[axis][bin].grow(item.lanes());
            counts[axis][bin] += 1;
        }
    }
    [0, 1, 2].map(|axis| {
        let (bounds, counts) = (&bounds[axis], &counts[axis]);
        let n = items.len();
        let mut above = [f32::INFINITY; BINS];
        let (mut all, mut count) = (Bounds::EMPTY, 0);
        for bin in (1..BINS).rev() {
            all.grow(&bounds[bin].0);
            count += counts[bin] as usize;
            above[bin] = if count > 0 { all.area() * records(count) } else { f32::INFINITY };
        }
        all.grow(&bounds[0].0);
        let mut best = Cut { cost: all.area() * records(n), at: At::Count(n / 2) };
        let (mut all, mut count) = (Bounds::EMPTY, 0);
        for bin in 0..BINS - 1 {
            all.grow(&bounds[bin].0);
            count += counts[bin] as usize;
            let cost = all.area() * records(count) + above[bin + 1];
            if count > 0 && cost < best.cost {
                let at = At::Bin { last: bin as u32, min: min[axis], scale: scale[axis] };
                best = Cut { cost, at };
            }
        }
        best
    })
}

/// Reorders the items so that those below the cut come first, and returns how many they are:
/// at least one, and not all.
pub(crate) fn partition(items: &mut [Item], axis: usize, cut: Cut) -> usize {
    match cut.at {
        At::Count(count) if items.len() <= SWEEP_MAX => {
            let mut sorted = [(0, 0); SWEEP_MAX];
            let sorted = &mut sorted[..items.len()];
            for (i, (entry, item)) in sorted.iter_mut().zip(items.iter()).enumerate() {
                *entry = (key(item, axis, i), i);
            }
            sorted.sort_unstable();
            let mut copy = [bytemuck::Zeroable::zeroed(); SWEEP_MAX];
            for (to, (_, from)) in copy.iter_mut().zip(sorted.iter()) {
                *to = items[*from];
            }
            items.copy_from_slice(&copy[..items.len()]);
            count
        }
        At::Count(count) => {
            let by = |item: &Item| (key(item, axis, 0), item.primitive);
            items.select_nth_unstable_by_key(count, by);
            count
        }
        At::Bin { last, min, scale } => {
            let below = |item: &Item| bin_of(item.center2(axis), min, scale) <= last as usize;
            let (mut low, mut high) = (0, items.len());
            loop {
                while low < high && below(&items[low]) {
                    low += 1;
                }
                while low < high && !below(&items[high - 1]) {
                    high -= 1;
                }
                if low >= high {
                    return low;
                }
                items.swap(low, high - 1);
            }
        }
    }
}
