use bytemuck::{Pod, Zeroable};

/// The queues whose heads may go one way: a bit each, which queues that are [`BITS`] apart share. Of few queues it is exact.
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

    /// Takes one of so many queues away, if no other shares its bit.
    pub(super) const fn remove(&mut self, queue: usize, queues: usize) {
        if queues <= BITS {
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
    use std::vec::Vec;

    #[test]
    fn queues_are_found_again() {
        for queues in [1, 31, 32, 33, 100] {
            let mut heads = Heads::NONE;
            assert!(heads.is_empty() && heads.queues(queues).next().is_none());
            let some = || (0..queues).step_by(7);
            some().for_each(|queue| heads.insert(queue));
            let mut found: Vec<usize> = heads.queues(queues).collect();
            found.sort_unstable();
            let shares = |queue: &usize| some().any(|other| other % BITS == queue % BITS);
            assert!(found.into_iter().eq((0..queues).filter(shares)), "{queues}");
            some().for_each(|queue| heads.remove(queue, queues));
            assert_eq!(heads.is_empty(), queues <= BITS);
        }
    }
}
