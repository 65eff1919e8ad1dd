use bytemuck::{Pod, Zeroable};

/// The queues whose heads may go one way: a bit each, which queues that are [`BITS`] apart share.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable)]
#[repr(transparent)]
pub(super) struct Heads(u32);

const BITS: usize = u32::BITS as usize;

impl Heads {
    pub(super) const NONE: Self = Self(0);

    /// Whether there is none.
    pub(super) const fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// Adds a queue.
    pub(super) const fn insert(&mut self, queue: usize) {
        self.0 |= 1 << (queue % BITS);
    }

    /// Takes one of so many queues away, if none that shares its bit `is` one of them as well.
    pub(super) fn remove(&mut self, queue: usize, queues: usize, is: impl Fn(usize) -> bool) {
        // A router of a board has so few that none shares a bit.
        let shares = cfg!(feature = "bundles")
            && (queue % BITS..queues).step_by(BITS).any(|other| other != queue && is(other));
        if !shares && (cfg!(feature = "bundles") || queues <= BITS) {
            self.0 &= !(1 << (queue % BITS));
        }
    }

    /// All that there may be, of so many queues.
    pub(super) fn queues(self, queues: usize) -> impl Iterator<Item = usize> {
        let Self(mut bits) = self;
        let mut next = usize::MAX;
        core::iter::from_fn(move || {
            if next >= queues {
                if bits == 0 {
                    return None;
                }
                next = bits.trailing_zeros() as usize;
                bits &= bits.wrapping_sub(1);
            }
            let queue = next;
            next = next.saturating_add(BITS);
            (queue < queues).then_some(queue)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn queues_are_found_again() {
        for queues in [1, 31, 32, 33, 64, 65, 200] {
            let mut heads = Heads::NONE;
            assert!(heads.is_empty() && heads.queues(queues).next().is_none());
            let some = || (0..queues).step_by(7);
            some().for_each(|queue| heads.insert(queue));
            let mut found: std::vec::Vec<usize> = heads.queues(queues).collect();
            found.sort_unstable();
            let shares = |queue: &usize| some().any(|other| other % BITS == queue % BITS);
            assert!(found.into_iter().eq((0..queues).filter(shares)), "{queues}");
            if queues <= BITS || cfg!(feature = "bundles") {
                // Of those that share a bit the last one takes it away.
                for queue in some() {
                    assert!(heads.queues(queues).any(|other| other == queue));
                    heads.remove(queue, queues, |other| other % 7 == 0 && other > queue);
                }
                assert_eq!(heads, Heads::NONE);
            }
        }
    }
}
