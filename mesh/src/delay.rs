use kiloray_core::node::Time;

/// How long tiles take from grant to completion: a moving mean and mean deviation, as of round trips in Jacobson 1988
/// ("Congestion avoidance and control", appendix A). It averages over more samples than that, since many nodes report at once.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Delay {
    mean: i64,
    deviation: i64,
    samples: i64,
}

/// The limit before the first tile is complete: nobody knows yet whether the machine is quick or slow.
const FIRST: Time = Time(1_000_000_000);
/// Samples in the means: each new one counts as one of so many.
const SAMPLES: i64 = 16;

impl Delay {
    /// Notes a tile that took so long.
    pub(super) fn note(&mut self, took: Time) {
        let took = took.0.min(1 << 60) as i64;
        self.samples = self.samples.saturating_add(1);
        if self.samples == 1 {
            self.mean = took;
            self.deviation = took / 2;
            return;
        }
        let error = took - self.mean;
        self.mean += error / SAMPLES;
        self.deviation += (error.abs() - self.deviation) / SAMPLES;
    }

    /// What is out for longer than this, given `times` times by now, is overdue: twice the mean, and a margin of four deviations,
    /// or more of them as long as few tiles tell; twice as much each time.
    ///
    /// Not many more: the first tiles may have waited for nodes that had died, and then all that those took with them would
    /// be given again after so many times that wait.
    pub(super) fn limit(&self, times: u32) -> Time {
        let once = if self.samples == 0 {
            FIRST.0
        } else {
            let deviations = 4 + SAMPLES / self.samples;
            let margin = self.deviation.saturating_mul(deviations);
            self.mean.saturating_mul(2).saturating_add(margin) as u64
        };
        Time(once.saturating_mul(1 << times.saturating_sub(1).min(40)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_limit_follows_the_tiles() {
        let mut delay = Delay::default();
        assert_eq!(delay.limit(1), FIRST);
        delay.note(Time(1000));
        // 20 deviations of a half.
        assert_eq!(delay.limit(1), Time(12_000));
        for _ in 0..300 {
            delay.note(Time(1000));
        }
        // Whole numbers: the deviation stays where a sixteenth of it is none.
        assert!((2000..2100).contains(&delay.limit(1).0), "{delay:?}");
        assert_eq!(delay.limit(3).0, 4 * delay.limit(1).0);
        for k in 0..300 {
            delay.note(Time(10_000 + 2000 * (k % 2)));
        }
        // Twice 11,000, and four times 1,000.
        assert!((24_500..27_500).contains(&delay.limit(1).0), "{delay:?}");
        delay.note(Time::NEVER);
        assert!(delay.limit(u32::MAX) > delay.limit(1));
    }
}
