//! How quick one thing was in several rounds.

use std::fmt;

use kiloray_tests::statistics::median;

/// Rates of one way with one kind of ray \[M rays/s\].
#[derive(Debug, Clone, Default)]
pub(crate) struct Rates {
    medians: Vec<f64>,
    best: f64,
}

impl Rates {
    /// A round: the median of its passes, and the best of them.
    pub(crate) fn add(&mut self, median: f64, best: f64) {
        self.medians.push(median);
        self.best = self.best.max(best);
    }

    /// The median over the rounds.
    pub(crate) fn median(&self) -> f64 {
        median(&self.medians)
    }

    /// How many times as quick as what was measured right before, in each round in turn, and by the best pass of either.
    pub(crate) fn to(&self, others: &Self) -> (Vec<f64>, f64) {
        let pairs = self.medians.iter().zip(&others.medians);
        (pairs.map(|(ours, theirs)| ours / theirs).collect(), self.best / others.best)
    }
}

impl fmt::Display for Rates {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:7.3} M rays/s (best {:.3})", self.median(), self.best)
    }
}
