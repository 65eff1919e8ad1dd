/// Gaps of Shell's sort: Ciura 2001, "Best increments for the average case of shellsort", continued by 2.25.
const GAPS: [usize; 12] = [19_937, 8861, 3938, 1750, 701, 301, 132, 57, 23, 10, 4, 1];

/// Sorts by a key, in place, equal keys in any order. O(n^4/3) moves or less for the lengths of queues.
///
/// Not `sort_unstable_by_key`: that may panic (if comparing contradicts itself), and takes 48 items of stack.
pub(crate) fn sort_by_key<T: Copy>(items: &mut [T], key: impl Fn(&T) -> u32) {
    for gap in GAPS {
        for from in gap..items.len() {
            let Some(&item) = items.get(from) else { break };
            let mut to = from;
            while let Some(before) = to.checked_sub(gap) {
                let Some(&other) = items.get(before).filter(|other| key(other) > key(&item)) else {
                    break;
                };
                if let Some(place) = items.get_mut(to) {
                    *place = other;
                }
                to = before;
            }
            if let Some(place) = items.get_mut(to) {
                *place = item;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn sorts_as_the_standard_library_does(mut items: Vec<u32>, few in 1_u32..9) {
            for limit in [u32::MAX, few] {
                items.iter_mut().for_each(|x| *x %= limit);
                let mut expected = items.clone();
                expected.sort_unstable();
                sort_by_key(&mut items, |&x| x);
                prop_assert_eq!(&items, &expected);
            }
        }
    }

    #[test]
    fn sorts_what_is_longer_than_the_greatest_gap() {
        let mut items: Vec<u32> = (0..30_000_u32).map(|i| i.wrapping_mul(0x9e37_79b1)).collect();
        let mut expected = items.clone();
        expected.sort_unstable();
        sort_by_key(&mut items, |&x| x);
        assert_eq!(items, expected);
    }
}
