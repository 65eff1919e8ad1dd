use crate::path::mix;

/// The index at a place of a seeded random order of `0..len`: a bijection, computed without a table.
///
/// A Feistel network (Luby & Rackoff 1988) permutes the least even number of bits that holds all indices; what
/// falls outside is permuted again (cycle walking: Black & Rogaway 2002, "Ciphers with arbitrary finite domains", section 4). The walk
/// from a place below `len` comes back to that place if it meets no other, so it ends; the bits hold fewer than `4 len` numbers, so on
/// average it takes fewer than four steps.
#[must_use]
pub(super) fn shuffled(place: u32, len: u32, seed: u64) -> Option<u32> {
    if place >= len {
        return None;
    }
    let half = (u32::BITS - (len - 1).leading_zeros()).div_ceil(2);
    let mut index = permuted(place, half, seed);
    while index >= len {
        index = permuted(index, half, seed);
    }
    Some(index)
}

/// Four rounds are enough for long numbers; with two bits to a half, 12 indices still show a bias of a quarter for some
/// neighbours then, and none with eight.
const ROUNDS: u64 = 8;

/// A permutation of the numbers of `2 half` bits; `half` is at most 16.
fn permuted(x: u32, half: u32, seed: u64) -> u32 {
    let mask = (1 << half) - 1;
    let (left, right) = (0..ROUNDS).fold((x >> half, x & mask), |(left, right), round| {
        (right, left ^ mix(seed ^ mix(round << 32 | u64::from(right))) as u32 & mask)
    });
    left << half | right
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn order(len: u32, seed: u64) -> Vec<u32> {
        (0..len).map(|place| shuffled(place, len, seed).unwrap()).collect()
    }

    #[test]
    fn it_is_a_permutation_of_every_length() {
        for len in 0..700 {
            let mut order = order(len, u64::from(len) * 31);
            order.sort_unstable();
            assert!(order.iter().copied().eq(0..len), "{len}");
            assert_eq!(shuffled(len, len, 1), None);
        }
    }

    proptest! {
        #[test]
        fn it_is_a_permutation_of_long_runs_too(len in 1_u32..60_000, seed: u64) {
            let mut order = order(len, seed);
            order.sort_unstable();
            prop_assert!(order.into_iter().eq(0..len));
        }

        #[test]
        fn the_longest_are_within_bounds(place: u32, len in 1_u32.., seed: u64) {
            let index = shuffled(place, len, seed);
            prop_assert_eq!(index.is_some(), place < len);
            prop_assert!(index.is_none_or(|index| index < len));
        }
    }

    /// Of a random order: each index is equally often at each place, and next to another equally often.
    #[test]
    fn orders_of_many_seeds_are_even() {
        let (len, seeds) = (12, 24_000);
        let (mut at, mut pairs) = ([[0_u32; 12]; 12], [[0_u32; 12]; 12]);
        for seed in 0..seeds {
            let order = order(len, seed);
            for (place, &index) in order.iter().enumerate() {
                at[place][index as usize] += 1;
            }
            for pair in order.windows(2) {
                pairs[pair[0] as usize][pair[1] as usize] += 1;
            }
        }
        // Expected 2,000 each, with a standard deviation of 43 if random; six of them.
        assert!(at.as_flattened().iter().all(|n| n.abs_diff(2000) < 260), "{at:?}");
        let apart = (0..12).flat_map(|a| (0..12).filter(move |b| *b != a).map(move |b| (a, b)));
        assert!(apart.clone().all(|(a, b)| pairs[a][b].abs_diff(2000) < 260), "{pairs:?}");
    }

    #[test]
    fn another_seed_is_another_order() {
        assert_ne!(order(64, 1), order(64, 2));
        assert_ne!(order(64, 1), (0..64).collect::<Vec<_>>());
    }
}
