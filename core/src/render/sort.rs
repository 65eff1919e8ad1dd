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

/// The same of items that are large: their keys and places are sorted in `room`, which has a number for each, and each item moves once. Where keys differ in
/// few bits, those of one key stay in their order.
///
/// Where keys and places take more than 32 bits, keys that differ in the lowest of theirs alone count as equal.
#[cfg(feature = "bundles")]
pub(crate) fn sort_large_by_key<T: Copy>(
    items: &mut [T],
    room: &mut [u32],
    key: impl Fn(&T) -> u32,
) {
    let Some(tags) = room.get_mut(..items.len()) else { return };
    let first = items.first().map_or(0, &key);
    let mut differ = 0;
    for (tag, item) in tags.iter_mut().zip(&*items) {
        *tag = key(item);
        differ |= *tag ^ first;
    }
    if differ == 0 {
        return;
    }
    let of_key = u32::BITS.saturating_sub(differ.leading_zeros());
    let of_place = usize::BITS.saturating_sub(items.len().saturating_sub(1).leading_zeros());
    if of_key <= COUNTED && of_key.saturating_add(of_place) <= u32::BITS {
        count_places(tags, of_key);
        arrange(items, tags, u32::MAX);
        return;
    }
    let left_out = of_key.saturating_add(of_place).saturating_sub(u32::BITS);
    for (tag, place) in tags.iter_mut().zip(0..) {
        *tag = tag.unbounded_shr(left_out).unbounded_shl(of_place) | place;
    }
    let places = !u32::MAX.unbounded_shl(of_place);
    sort_by_key(tags, |tag| tag & !places);
    arrange(items, tags, places);
}

/// Keys that differ in so many of their lowest bits at most are counted: those of 256 lights, by signs.
#[cfg(feature = "bundles")]
const COUNTED: u32 = 11;

/// Makes of keys that differ in their lowest `bits` alone the places of the items in their order.
#[cfg(feature = "bundles")]
fn count_places(tags: &mut [u32], bits: u32) {
    let mut begins = [0_u32; 1 << COUNTED];
    let begins = begins.get_mut(..1 << bits).unwrap_or_default();
    let keys = !u32::MAX.unbounded_shl(bits);
    for tag in &mut *tags {
        *tag &= keys;
        if let Some(count) = begins.get_mut(*tag as usize) {
            *count = count.wrapping_add(1);
        }
    }
    let mut before = 0_u32;
    for begin in &mut *begins {
        before = before.wrapping_add(core::mem::replace(begin, before));
    }
    for place in 0..tags.len() {
        let Some(key) = tags.get(place).map(|tag| (tag & keys) as usize) else { break };
        let Some(begin) = begins.get_mut(key) else { break };
        // Above the key of the item that lies there, the place of the one that belongs there.
        if let Some(tag) = tags.get_mut(*begin as usize) {
            *tag |= (place as u32).unbounded_shl(bits);
        }
        *begin = begin.wrapping_add(1);
    }
    tags.iter_mut().for_each(|tag| *tag = tag.unbounded_shr(bits));
}

/// Moves each item to its place. The lowest bits of `tags` say which item belongs there.
#[cfg(feature = "bundles")]
fn arrange<T: Copy>(items: &mut [T], tags: &mut [u32], places: u32) {
    for begin in 0..items.len() {
        let mut from = tags.get(begin).map_or(begin, |tag| (tag & places) as usize);
        let Some(&one) = items.get(begin).filter(|_| from != begin) else { continue };
        let mut to = begin;
        // What belongs here, then what belongs where that was, until that is where it began.
        while from != begin {
            let (Some(&other), Some(tag)) = (items.get(from), tags.get_mut(from)) else { break };
            if let Some(place) = items.get_mut(to) {
                *place = other;
            }
            to = from;
            from = (*tag & places) as usize;
            *tag = to as u32;
        }
        if let Some(place) = items.get_mut(to) {
            *place = one;
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

        #[cfg(feature = "bundles")]
        #[test]
        fn large_items_are_sorted_alike(mut items: Vec<u32>, few in 1_u32..9, more in 0_usize..3) {
            let mut room = vec![7; items.len() + more];
            for limit in [1 << 24, few] {
                items.iter_mut().for_each(|x| *x %= limit);
                for high in [0, 1 << 31] {
                    let mut expected = items.clone();
                    sort_by_key(&mut expected, |&x| x | high);
                    sort_large_by_key(&mut items, &mut room, |&x| x | high);
                    prop_assert_eq!(&items, &expected);
                    items.reverse();
                }
            }
        }
    }

    #[cfg(feature = "bundles")]
    proptest! {
        #[test]
        fn of_few_keys_items_keep_their_order(
            keys in proptest::collection::vec(0_u32..1 << COUNTED, 0..300), few in 1_u32..9, turned: bool,
        ) {
            for limit in [1 << COUNTED, few] {
                let high = if turned { u32::MAX } else { 0 };
                let key = |&(key, _): &(u32, usize)| (key % limit) ^ high;
                let mut items: Vec<_> = keys.iter().copied().zip(0..).collect();
                let mut expected = items.clone();
                expected.sort_by_key(key);
                sort_large_by_key(&mut items, &mut vec![7; keys.len()], key);
                prop_assert_eq!(&items, &expected);
            }
        }
    }

    #[cfg(feature = "bundles")]
    #[test]
    fn all_items_remain_whatever_their_keys_leave_of_room() {
        // A key of 32 bits and five for the place.
        let all: std::vec::Vec<u32> = (0..32).map(|i: u32| i.reverse_bits() | i).collect();
        let (mut items, mut room) = (all.clone(), [0; 32]);
        sort_large_by_key(&mut items, &mut room, |&x| x);
        assert!(items.is_sorted_by_key(|x| x >> 5));
        items.sort_unstable();
        let mut all = all;
        all.sort_unstable();
        assert_eq!(items, all);
    }
}
