//! The binary tree that nodes are made of: cuts by the surface-area heuristic, down to single records.

use kiloray_core::block::format::{LEAF_RECORDS_MAX, RECORD_PRIMITIVES};

use super::bounds::{Bounds, Item};
use super::split::{Cut, cuts, halves, partition};

/// A set of items, cut in two or not.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Part {
    pub(crate) bounds: Bounds,
    /// The first of its items, and how many there are.
    pub(crate) first: u32,
    pub(crate) count: u32,
    /// Its two parts, with greater indices: below the cut, and above. Both 0: it is not cut.
    pub(crate) parts: [u32; 2],
    /// The axis of the cut.
    pub(crate) axis: u8,
    /// Records that a leaf of its items takes; 255: more than a leaf may have.
    pub(crate) records: u8,
}

impl Part {
    /// Its two parts.
    pub(crate) fn cut(&self) -> Option<[u32; 2]> {
        (self.parts != [0; 2]).then_some(self.parts)
    }
}

/// No leaf: too many records.
pub(crate) const TOO_MANY: u8 = u8::MAX;

/// Cuts the items, which are reordered so that each part is a range of them, no more than `levels` times in a row; the parts, a part before
/// its own. There is at least one item. What is not cut can be a leaf; no leaf has more than `leaf_max` items, which are four at least.
///
/// `done` hears how many items lie in parts that are not cut.
pub(crate) fn binary(
    items: &mut [Item],
    leaf_max: usize,
    levels: usize,
    done: &mut dyn FnMut(u64),
) -> Vec<Part> {
    // Records come out three quarters full or better.
    let parts = Vec::with_capacity(items.len() * 2 / 3);
    let mut cutting = Cutting { parts, leaf_max, finished: 0, done };
    cutting.part(items, 0, levels);
    cutting.parts
}

struct Cutting<'a> {
    parts: Vec<Part>,
    leaf_max: usize,
    finished: u64,
    done: &'a mut dyn FnMut(u64),
}

impl Cutting<'_> {
    /// Adds the part of these items, the first of which is number `first`, and all below it; its index.
    fn part(&mut self, items: &mut [Item], first: usize, levels: usize) -> u32 {
        let index = self.parts.len();
        let records = if items.len() > self.leaf_max { TOO_MANY } else { records(items) };
        self.parts.push(Part {
            bounds: bounds(items),
            first: first as u32,
            count: items.len() as u32,
            parts: [0; 2],
            axis: 0,
            records,
        });
        if records == 1 || levels == 0 && records != TOO_MANY {
            self.finish(items.len() as u64);
            return index as u32;
        }
        let (axis, cut) = cheapest(items, levels);
        let below = partition(items, axis, cut);
        let (low, high) = items.split_at_mut(below);
        let left = levels.saturating_sub(1);
        let parts = [self.part(low, first, left), self.part(high, first + below, left)];
        let part = &mut self.parts[index];
        (part.parts, part.axis) = (parts, axis as u8);
        index as u32
    }

    fn finish(&mut self, count: u64) {
        let before = self.finished;
        self.finished += count;
        if self.finished >> 14 != before >> 14 {
            (self.done)(self.finished);
        }
    }
}

/// The cut with the least cost; into halves where only they end in time.
fn cheapest(items: &[Item], levels: usize) -> (usize, Cut) {
    let all = bounds(items);
    if levels <= levels_needed(items.len()) {
        let (lo, hi) = (all.lo(), all.hi());
        let longest = (0..3).max_by(|&a, &b| (hi[a] - lo[a]).total_cmp(&(hi[b] - lo[b])));
        return (longest.unwrap_or(0), halves(items));
    }
    let cuts = cuts(items);
    let axis =
        (1..3).fold(0, |best, axis| if cuts[axis].cost < cuts[best].cost { axis } else { best });
    (axis, cuts[axis])
}

/// Cuts in a row that `count` items need when halved, until what is left can be a leaf whatever the records.
fn levels_needed(count: usize) -> usize {
    let leaves = count.div_ceil(LEAF_RECORDS_MAX);
    leaves.next_power_of_two().ilog2() as usize
}

fn bounds(items: &[Item]) -> Bounds {
    let mut all = Bounds::EMPTY;
    for item in items {
        all.grow(item.lanes());
    }
    all
}

/// Records that a leaf of these items takes, each for one group, if it may have so many.
fn records(items: &[Item]) -> u8 {
    let mut groups = [(0_u32, 0_usize); LEAF_RECORDS_MAX];
    let mut len = 0;
    for item in items {
        let known = groups[..len].iter().position(|(group, _)| *group == item.group);
        match known {
            Some(at) => groups[at].1 += 1,
            None if len < groups.len() => {
                groups[len] = (item.group, 1);
                len += 1;
            }
            None => return TOO_MANY,
        }
    }
    let all: usize = groups[..len].iter().map(|(_, count)| count.div_ceil(RECORD_PRIMITIVES)).sum();
    if all > LEAF_RECORDS_MAX { TOO_MANY } else { all as u8 }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn depth(parts: &[Part], part: u32) -> usize {
        parts[part as usize].cut().map_or(0, |parts_of| {
            1 + parts_of.map(|part| depth(parts, part)).into_iter().max().unwrap_or(0)
        })
    }

    #[test]
    fn no_part_is_cut_more_often_than_it_may_be() {
        // Each twice as large as the next: the heuristic cuts off the largest few.
        let items: Vec<Item> = (0..250_u16)
            .map(|i| {
                let size = 0.7f32.powi(i.into());
                // Many of them may not share a record.
                Item::new(i.into(), u32::from(i % 7), [0.0; 3], [size; 3])
            })
            .collect();
        let mut depths = Vec::new();
        for levels in 6..24 {
            let mut items = items.clone();
            let parts = binary(&mut items, 16, levels, &mut |_| {});
            depths.push(depth(&parts, 0));
            assert!(depths[levels - 6] <= levels, "{depths:?}");
            for part in parts.iter().filter(|part| part.cut().is_none()) {
                assert_ne!(part.records, TOO_MANY, "no leaf: {part:?}");
            }
            let mut names: Vec<u32> = items.iter().map(|item| item.primitive).collect();
            names.sort_unstable();
            assert!(names.into_iter().eq(0..250), "every item is still there");
        }
        assert!(depths.last() > Some(&10), "the limit was never felt: {depths:?}");
    }
}
