use crate::{Faults, Rate};

/// What happens to a packet on a link.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Fate {
    /// It never arrives.
    pub(crate) lost: bool,
    /// It is sent twice.
    pub(crate) doubled: bool,
    /// The second of them never arrives.
    pub(crate) copy_lost: bool,
    /// Beyond its time \[ns\].
    pub(crate) delay: u64,
    /// Those behind it do not wait for it: it can be overtaken.
    pub(crate) strays: bool,
}

/// Of the packets that are delayed, so many can be overtaken. A link keeps the order else: what is overtaken counts as
/// lost, so that a link without any order would carry next to nothing.
const STRAYS: Rate = Rate { count: 1, of: 16 };

/// The fate of the `number`-th packet of a link: a function of the seed and these.
pub(crate) fn fate(faults: &Faults, seed: u64, link: u32, number: u64) -> Fate {
    let base = mix(mix(mix(seed) ^ u64::from(link)) ^ number);
    let draw = |what: u64| mix(base ^ what);
    Fate {
        lost: happens(faults.loss, draw(1)),
        doubled: happens(faults.duplicate, draw(2)),
        copy_lost: happens(faults.loss, draw(5)),
        delay: scale(draw(3), faults.jitter.saturating_add(1)),
        strays: faults.jitter > 0 && happens(STRAYS, draw(4)),
    }
}

fn happens(rate: Rate, draw: u64) -> bool {
    rate.count > 0 && scale(draw, u64::from(rate.of.max(1))) < u64::from(rate.count)
}

/// A number below `below`, from an even draw.
fn scale(draw: u64, below: u64) -> u64 {
    ((u128::from(draw) * u128::from(below)) >> 64) as u64
}

/// The finaliser of splitmix64 (Steele, Lea, Flood 2014), after its increment.
fn mix(x: u64) -> u64 {
    let mut x = x.wrapping_add(0x9e37_79b9_7f4a_7c15);
    x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ (x >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neighbouring_seeds_are_not_each_other_with_links_exchanged() {
        let faults = Faults { loss: Rate { count: 1, of: 10 }, ..Faults::default() };
        let lost = |seed: u64, link: u32| -> Vec<bool> {
            (0..64).map(|number| fate(&faults, seed, link, number).lost).collect()
        };
        let known: Vec<_> = (0..8).map(|link| lost(0, link)).collect();
        for (seed, link) in (1..8).flat_map(|seed| (0..8).map(move |link| (seed, link))) {
            assert!(!known.contains(&lost(seed, link)), "{seed} {link}");
        }
    }

    #[test]
    fn rates_are_kept() {
        let rate = |count, of| Rate { count, of };
        let faults =
            Faults { loss: rate(1, 100), duplicate: rate(1, 10), jitter: 9, ..Faults::default() };
        let fates: Vec<Fate> = (0..100_000).map(|n| fate(&faults, 7, (n % 13) as u32, n)).collect();
        let lost = fates.iter().filter(|fate| fate.lost).count();
        let doubled = fates.iter().filter(|fate| fate.doubled).count();
        let delay: u64 = fates.iter().map(|fate| fate.delay).sum();
        // Five standard deviations.
        assert!((843..1157).contains(&lost), "{lost}");
        assert!((9525..10475).contains(&doubled), "{doubled}");
        let strays = fates.iter().filter(|fate| fate.strays).count();
        assert!((5867..6633).contains(&strays), "{strays}");
        assert!((445_000..455_000).contains(&delay), "{delay}");
        assert!(fates.iter().all(|fate| fate.delay <= 9));
        let none = fate(&Faults::default(), 7, 1, 1);
        let whole = Fate { lost: false, doubled: false, copy_lost: false, delay: 0, strays: false };
        assert_eq!(none, whole);
    }
}
