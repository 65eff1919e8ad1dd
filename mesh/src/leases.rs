use super::delay::Delay;
use kiloray_core::network::NodeId;
use kiloray_core::node::Time;
use kiloray_core::render::Tiling;
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

/// Who renders which tiles, by their places in the order of work.
///
/// Fresh places go out in grants that shrink as work does: an asker gets at most what is left by twice the number of askers (factoring:
/// Hummel, Schonberg & Flynn 1992; guided self-scheduling, Polychronopoulos & Kuck 1987, takes the whole of it). Whoever is given
/// a part of a [run](Tiling::RUN) is given the rest of it when it asks again, unless all runs have been begun by then: who has none goes on with
/// half of the longest rest (affinity scheduling: Markatos & LeBlanc 1994). When none is left, those that are out for longer than tiles
/// take are given to others as well (backup tasks: Dean & Ghemawat 2004, section 3.6), oldest first, each time after twice as long.
#[derive(Debug)]
pub(super) struct Leases {
    tiles: Vec<Lease>,
    /// The first place of which the run was not begun.
    next: u32,
    /// What is left of the runs that were begun, by who goes on with it.
    rests: BTreeMap<NodeId, Range<u32>>,
    /// Places that were never given, and are not complete.
    fresh: u32,
    incomplete: u32,
    /// Places that are out, by the time they were last given.
    out: BTreeSet<(Time, u32)>,
    askers: BTreeMap<NodeId, Asker>,
    askers_min: u32,
    delay: Delay,
    /// Nodes that were named to those that had no work.
    named: usize,
    pub(super) counts: LeaseCounts,
}

/// What was given.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct LeaseCounts {
    /// Places given for the first time.
    pub(super) given: u64,
    /// Places that were out, and were given to another.
    pub(super) given_again: u64,
    /// Asks that came again, and had the same answer.
    pub(super) repeated: u64,
}

#[derive(Debug, Clone, Default)]
struct Lease {
    holders: Vec<NodeId>,
    since: Time,
    times: u32,
    is_complete: bool,
}

/// The last grant of an asker.
#[derive(Debug, Clone, Copy)]
struct Asker {
    number: u32,
    first: u32,
    count: u32,
}

/// A run of places; or, where it has none, a node that still renders, and how long to wait \[µs\].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Given {
    pub(super) first: u32,
    pub(super) count: u32,
    pub(super) wait: u32,
}

/// Whether a number of a request comes after another; they wrap.
const fn is_after(number: u32, other: u32) -> bool {
    number.wrapping_sub(other).cast_signed() > 0
}

/// The least wait \[ns\].
const WAIT_MIN: u64 = 100_000;

impl Leases {
    pub(super) fn new(tiles: u32) -> Self {
        Self {
            tiles: vec![Lease::default(); tiles as usize],
            next: 0,
            rests: BTreeMap::new(),
            fresh: tiles,
            incomplete: tiles,
            out: BTreeSet::new(),
            askers: BTreeMap::new(),
            askers_min: 1,
            delay: Delay::default(),
            named: 0,
            counts: LeaseCounts::default(),
        }
    }

    /// So many will ask: the first is not taken for the only one.
    pub(super) fn expect(&mut self, askers: u32) {
        self.askers_min = askers.max(1);
    }

    pub(super) const fn is_done(&self) -> bool {
        self.incomplete == 0
    }

    /// Places for an asker that can take `count`. A request has one answer, however often it comes: if another were lost, what it gave would be missed
    /// only when it is overdue.
    pub(super) fn ask(&mut self, now: Time, from: NodeId, number: u32, count: u32) -> Given {
        let known = self.askers.get(&from).copied();
        if let Some(asker) = known.filter(|asker| !is_after(number, asker.number)) {
            self.counts.repeated += 1;
            if asker.number == number {
                if let Some((first, count)) = self.still_open(asker.first, asker.count) {
                    return Given { first, count, wait: 0 };
                }
                if asker.count == 0 {
                    return self.nothing(now, from);
                }
            }
            // It was overtaken by what came of it: nobody waits for its answer, and tiles would be with nobody. Or a node in place of this one begins to
            // ask: it comes to the next number soon.
            let wait = if self.is_done() { u32::MAX } else { 1 };
            return Given { first: u32::MAX, count: 0, wait };
        }
        let count = count.max(1);
        let _ = self.askers.entry(from).or_insert(Asker { number, first: 0, count: 0 });
        let (first, count) =
            self.fresh(from, count).or_else(|| self.overdue(now, from, count)).unwrap_or_default();
        for place in first..first + count {
            self.give(now, place, from);
        }
        self.askers.insert(from, Asker { number, first, count });
        if count > 0 {
            return Given { first, count, wait: 0 };
        }
        self.nothing(now, from)
    }

    fn nothing(&mut self, now: Time, from: NodeId) -> Given {
        Given { first: self.busy(from), count: 0, wait: self.wait(now, from) }
    }

    /// Notes that a tile is complete.
    pub(super) fn complete(&mut self, now: Time, place: u32) {
        let Some(lease) = self.tiles.get_mut(place as usize).filter(|l| !l.is_complete) else {
            return;
        };
        self.fresh -= u32::from(lease.times == 0);
        // One that was given twice does not tell which of them was quick (Karn & Partridge 1987).
        if lease.times == 1 {
            self.delay.note(Time(now.0.saturating_sub(lease.since.0)));
        }
        let _ = self.out.remove(&(lease.since, place));
        *lease = Lease { is_complete: true, ..Lease::default() };
        self.incomplete -= 1;
    }

    /// From the first to the last place of a run that are not complete.
    fn still_open(&self, first: u32, count: u32) -> Option<(u32, u32)> {
        let open = |place: &u32| self.tiles.get(*place as usize).is_some_and(|l| !l.is_complete);
        let begin = (first..first + count).find(open)?;
        let last = (begin..first + count).rfind(open)?;
        Some((begin, last - begin + 1))
    }

    /// An asker's part of so many places.
    fn share(&self, places: u32, wanted: u32) -> u32 {
        let askers = (self.askers.len() as u32).max(self.askers_min);
        (places / (2 * askers)).clamp(1, wanted)
    }

    /// The next places that were never given.
    fn fresh(&mut self, from: NodeId, wanted: u32) -> Option<(u32, u32)> {
        let share = self.share(self.fresh, wanted);
        loop {
            let rest = self.rests.remove(&from);
            let places = rest.or_else(|| self.begin(share)).or_else(|| self.half())?;
            // Complete and never given: somebody had it from a ledger before this one.
            let is_open = |place: &u32| !self.tiles[*place as usize].is_complete;
            let Some(first) = places.clone().find(is_open) else { continue };
            let count = (first..places.end).take(share as usize).take_while(is_open).count() as u32;
            if first + count < places.end {
                let _ = self.rests.insert(from, first + count..places.end);
            }
            return Some((first, count));
        }
    }

    /// As many whole runs as hold so many places.
    fn begin(&mut self, places: u32) -> Option<Range<u32>> {
        let len = self.tiles.len() as u32;
        let first = self.next;
        let end = first.saturating_add(places).checked_next_multiple_of(Tiling::RUN);
        self.next = end.map_or(len, |end| end.min(len));
        (first < len).then_some(first..self.next)
    }

    /// The later half of the longest rest.
    fn half(&mut self) -> Option<Range<u32>> {
        let longest = self.rests.iter().max_by_key(|(_, rest)| rest.len())?;
        let (holder, rest) = (*longest.0, longest.1.clone());
        let middle = rest.start + rest.len() as u32 / 2;
        if rest.start < middle {
            let _ = self.rests.insert(holder, rest.start..middle);
        } else {
            let _ = self.rests.remove(&holder);
        }
        Some(middle..rest.end)
    }

    /// The run of overdue places with the oldest that this asker may have.
    fn overdue(&self, now: Time, from: NodeId, wanted: u32) -> Option<(u32, u32)> {
        let is_due = |place: u32| self.due(place, from).is_some_and(|due| due <= now);
        let first = self.out.iter().map(|&(_, place)| place).find(|&place| is_due(place))?;
        let share = self.share(self.out.len() as u32, wanted);
        let count = (first..first + share).take_while(|&place| is_due(place)).count() as u32;
        Some((first, count))
    }

    /// When a place that is out may go to this asker too. To one that has it already it goes later, but it does: it may be a
    /// sub-master that has lost a node, and the only one.
    fn due(&self, place: u32, asker: NodeId) -> Option<Time> {
        let lease = self.tiles.get(place as usize).filter(|l| l.times > 0 && !l.is_complete)?;
        let held = u32::from(lease.holders.contains(&asker));
        Some(lease.since.after(self.delay.limit(lease.times + held)))
    }

    fn give(&mut self, now: Time, place: u32, to: NodeId) {
        let Some(lease) = self.tiles.get_mut(place as usize) else { return };
        if lease.times == 0 {
            self.counts.given += 1;
            self.fresh -= 1;
        } else {
            self.counts.given_again += 1;
            let _ = self.out.remove(&(lease.since, place));
        }
        lease.since = now;
        lease.times += 1;
        if !lease.holders.contains(&to) {
            lease.holders.push(to);
        }
        let _ = self.out.insert((now, place));
    }

    /// A node that has a place which is not complete: such nodes in turn, each as often as it has places.
    fn busy(&mut self, asker: NodeId) -> u32 {
        self.named = self.named.wrapping_add(1);
        let holder = |&(_, place): &(Time, u32)| self.tiles[place as usize].holders.last().copied();
        let others = || self.out.iter().filter_map(holder).filter(|&node| node != asker);
        let at = self.named.checked_rem(others().count());
        at.and_then(|at| others().nth(at)).map_or(u32::MAX, |node| u32::from(node.0))
    }

    /// How long an asker that gets nothing waits: until a place is due, but no longer than the oldest is out, as the limit may fall \[µs\].
    fn wait(&self, now: Time, asker: NodeId) -> u32 {
        let Some(&(oldest, _)) = self.out.first() else { return u32::MAX };
        let due = self.out.iter().filter_map(|&(_, place)| self.due(place, asker)).min();
        let until_due = due.unwrap_or_default().0.saturating_sub(now.0);
        let age = now.0.saturating_sub(oldest.0);
        let wait = until_due.min(age.max(WAIT_MIN)).div_ceil(1000);
        wait.clamp(1, u64::from(u32::MAX)) as u32
    }
}
