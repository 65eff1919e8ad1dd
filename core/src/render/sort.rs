/// Sorts by a key, in place, equal keys in any order: radix exchange (Hildebrandt & Isbitz 1959), bit by bit from the highest in which keys
/// differ. So it takes time for the number of lights, not of rays: two looks at each item for each bit.
///
/// Not `sort_unstable_by_key`: that may panic (if comparing contradicts itself), and takes 48 items of stack.
pub(crate) fn sort_by_key<T: Copy>(items: &mut [T], key: impl Fn(&T) -> u32) {
    let first = items.first().map_or(0, &key);
    let differ = items.iter().fold(0, |differ, item| differ | (key(item) ^ first));
    let bits = u32::BITS.saturating_sub(differ.leading_zeros());
    for bit in (0..bits).rev().filter(|bit| differ >> bit & 1 == 1) {
        let mut rest = &mut *items;
        while let Some(first) = rest.first() {
            // Those that are alike so far, of which those with the bit go behind.
            let prefix = u64::from(key(first)) >> (bit + 1);
            let alike = |item: &&T| u64::from(key(item)) >> (bit + 1) == prefix;
            let count = rest.iter().take_while(alike).count();
            let Some((run, behind)) = rest.split_at_mut_checked(count) else { break };
            exchange(run, |item| key(item) >> bit & 1 == 1);
            rest = behind;
        }
    }
}

/// Puts those that are `high` behind the others.
fn exchange<T: Copy>(items: &mut [T], high: impl Fn(&T) -> bool) {
    let mut rest = items.iter_mut();
    while let Some(low) = rest.find(|item| high(item)) {
        let Some(high) = rest.rfind(|item| !high(item)) else { break };
        core::mem::swap(low, high);
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
                sort_by_key(&mut items, |&x| !x);
                expected.reverse();
                prop_assert_eq!(&items, &expected);
            }
        }
    }
}
