/// Finds out that a run goes on in vain.
///
/// A pixel is complete when all of its tile is, which with many samples is long after the last; meanwhile nodes begin camera paths. Those of a tile
/// that is rendered again and again count up to a bound.
#[derive(Debug)]
pub(crate) struct Watchdog {
    /// Events without a step forward after which the run is given up, if all before them took no longer.
    patience: u64,
    pixels: u64,
    begun: u64,
    most: u64,
    /// The events, and the virtual time, when it last went forward.
    since: (u64, u64),
}

/// How often each camera path may begin: where nodes die, many do more than once.
const TIMES: u64 = 64;

impl Watchdog {
    /// Of a run of so many camera paths.
    pub(crate) const fn new(patience: u64, paths: u64) -> Self {
        let most = paths.saturating_mul(TIMES);
        Self { patience, pixels: 0, begun: 0, most, since: (0, 0) }
    }

    /// So many pixels are complete.
    pub(crate) fn pixels(&mut self, pixels: u64, (events, now): (u64, u64)) {
        if pixels != self.pixels {
            (self.pixels, self.since) = (pixels, (events, now));
        }
    }

    /// So many camera paths have been begun.
    pub(crate) fn begun(&mut self, begun: u64, (events, now): (u64, u64)) {
        let begun = begun.min(self.most);
        if begun > self.begun {
            (self.begun, self.since) = (begun, (events, now));
        }
    }

    /// When it last went forward \[ns\].
    pub(crate) const fn since(&self) -> u64 {
        self.since.1
    }

    /// Whether nothing has gone forward for too long.
    pub(crate) const fn is_in_vain(&self, events: u64, now: u64) -> bool {
        let (since, since_ns) = self.since;
        events - since > self.patience && now - since_ns > since_ns
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_tiles_are_not_in_vain_but_those_that_begin_for_ever_are() {
        let mut dog = Watchdog::new(1000, 50);
        for step in 1..=64 * 50 {
            dog.pixels(0, (900 * step, 900 * step));
            dog.begun(step, (900 * step, 900 * step));
            assert!(!dog.is_in_vain(900 * (step + 1), 1800 * (step + 1)));
        }
        let last = 64 * 50 * 900;
        dog.begun(64 * 50 + 1, (last + 500, last + 500));
        assert!(!dog.is_in_vain(last + 1000, 3 * last));
        assert!(dog.is_in_vain(last + 1001, 3 * last));
        // As long as all before.
        assert!(!dog.is_in_vain(last + 1001, 2 * last));
        dog.pixels(1, (last + 1001, 3 * last));
        assert!(!dog.is_in_vain(last + 2000, 9 * last));
    }
}
