use serde::{Deserialize, Serialize};

/// How long things took.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct Latencies {
    /// From the request for a block to its arrival.
    pub fetch: Histogram,
    /// Of it, until the request was with the owner.
    pub fetch_request: Histogram,
    /// Of it, from then on until the first piece entered a link: what the owner did before, and its queue.
    pub fetch_owner: Histogram,
    /// Of it, from then on until the last piece was there.
    pub fetch_reply: Histogram,
    /// From a ray's departure to its answer.
    pub ray: Histogram,
    /// From the grant of a tile to its last pixel.
    pub tile: Histogram,
}

/// Times of one kind \[ns\]. Percentiles and bounds are exact to 1 %.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct Histogram {
    /// How many.
    pub count: u64,
    /// The least.
    pub min: u64,
    /// The mean.
    pub mean: f64,
    /// Half were no longer.
    pub p50: u64,
    /// 90 % were no longer.
    pub p90: u64,
    /// 99 % were no longer.
    pub p99: u64,
    /// 99.9 % were no longer.
    pub p999: u64,
    /// The greatest.
    pub max: u64,
    /// How many there were by powers of two; only those that had any.
    pub buckets: Vec<HistogramBucket>,
}

/// A part of a histogram.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct HistogramBucket {
    /// The greatest time that counts here \[ns\].
    pub up_to: u64,
    /// How many.
    pub count: u64,
}

/// Times as they are recorded. It can be sent, as times and how often they were, to be put together with others.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(from = "Vec<(u64, u64)>", into = "Vec<(u64, u64)>")]
pub(super) struct Recorder(hdrhistogram::Histogram<u64>);

impl Default for Recorder {
    /// Without any yet.
    fn default() -> Self {
        // Two digits, any 64-bit value: a few KiB, as it grows with the greatest.
        Self(hdrhistogram::Histogram::new(2).expect("two digits are allowed"))
    }
}

impl From<Vec<(u64, u64)>> for Recorder {
    fn from(times: Vec<(u64, u64)>) -> Self {
        let mut recorder = Self::default();
        times.into_iter().for_each(|(ns, count)| recorder.record(ns, count));
        recorder
    }
}

impl From<Recorder> for Vec<(u64, u64)> {
    fn from(recorder: Recorder) -> Self {
        let steps = recorder.0.iter_recorded();
        steps.map(|step| (step.value_iterated_to(), step.count_at_value())).collect()
    }
}

impl Recorder {
    /// Records a time, so many times.
    pub(super) fn record(&mut self, ns: u64, count: u64) {
        // A histogram that grows refuses nothing.
        let _ = self.0.record_n(ns.min(u64::MAX / 2), count);
    }

    /// Takes over what another has recorded.
    pub(super) fn add(&mut self, other: &Self) {
        // A histogram that grows refuses nothing.
        let _ = self.0.add(&other.0);
    }

    /// What was recorded.
    pub(super) fn histogram(&self) -> Histogram {
        let all = &self.0;
        if all.is_empty() {
            return Histogram::default();
        }
        let buckets = all.iter_log(1, 2.0).filter(|step| step.count_since_last_iteration() > 0);
        let bucket = |step: hdrhistogram::iterators::IterationValue<u64>| HistogramBucket {
            up_to: step.value_iterated_to(),
            count: step.count_since_last_iteration(),
        };
        Histogram {
            count: all.len(),
            min: all.min(),
            mean: all.mean(),
            p50: all.value_at_quantile(0.5),
            p90: all.value_at_quantile(0.9),
            p99: all.value_at_quantile(0.99),
            p999: all.value_at_quantile(0.999),
            max: all.max(),
            buckets: buckets.map(bucket).collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percentiles_are_exact_to_one_percent() {
        let mut recorder = Recorder::default();
        (1..=100_000).for_each(|ns| recorder.record(ns, 1));
        let histogram = recorder.histogram();
        assert_eq!((histogram.count, histogram.min), (100_000, 1));
        for (found, expected) in [
            (histogram.p50, 50_000),
            (histogram.p90, 90_000),
            (histogram.p99, 99_000),
            (histogram.p999, 99_900),
            (histogram.max, 100_000),
        ] {
            assert!(found.abs_diff(expected) * 100 <= expected, "{found} {expected}");
        }
        assert_eq!(histogram.buckets.iter().map(|bucket| bucket.count).sum::<u64>(), 100_000);
        assert_eq!(Recorder::default().histogram(), Histogram::default());
    }

    #[test]
    fn what_is_sent_is_what_was_recorded() {
        let mut recorder = Recorder::default();
        (1..=10_000).for_each(|ns| recorder.record(ns * ns, ns % 3));
        let mut twice = Recorder::from(Vec::from(recorder.clone()));
        let of = |recorder: &Recorder| (recorder.histogram().count, recorder.histogram().p90);
        assert_eq!(of(&twice), of(&recorder));
        twice.add(&recorder);
        assert_eq!(of(&twice), (2 * of(&recorder).0, of(&recorder).1));
        assert!(Recorder::from(vec![(u64::MAX, u64::MAX), (0, u64::MAX)]).histogram().count > 0);
    }
}
