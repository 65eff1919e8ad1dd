use crate::{Sample, Timeline};

/// Most steps of a time line.
const STEPS: usize = 256;

/// Its steps are never shorter than 2 to this power \[ns\].
const SHORTEST: u32 = 10;

/// The shortest step that a moment is in.
pub(crate) const fn step_of(at: u64) -> u64 {
    at >> SHORTEST
}

/// A time line as it grows: when it gets too long, its steps are joined in pairs.
#[derive(Debug)]
pub(crate) struct TimelineRecorder {
    /// The length of a step is 2 to this power \[ns\].
    power: u32,
    steps: Vec<Step>,
    /// Rays held, and pixels complete, at the last step.
    stored: u64,
    pixels: u64,
}

#[derive(Debug, Clone, Copy, Default)]
struct Step {
    /// Node time at work \[ns\].
    busy: u64,
    /// Of that, tracing and shading \[ns\].
    useful: u64,
    /// Node time waiting \[ns\].
    waiting: u64,
    /// Node time after a crash \[ns\].
    dead: u64,
    stored: u64,
    link_bytes: u64,
    pixels: u64,
}

impl Default for TimelineRecorder {
    /// Of no time yet.
    fn default() -> Self {
        Self { power: SHORTEST, steps: Vec::with_capacity(STEPS), stored: 0, pixels: 0 }
    }
}

impl TimelineRecorder {
    /// Spans up to this moment are going to be entered: it grows before the first, so that their order makes no difference.
    pub(crate) fn reach(&mut self, end: u64) {
        self.at(end.saturating_sub(1));
    }

    /// A node was at work, this part of it tracing and shading.
    pub(crate) fn busy(&mut self, from: u64, to: u64, useful: f32) {
        self.spread(from, to, |step, ns| {
            step.busy += ns;
            // In whole numbers, whose sum does not depend on the order.
            step.useful += (ns as f64 * f64::from(useful)).round() as u64;
        });
    }

    /// A node waited.
    pub(crate) fn waiting(&mut self, from: u64, to: u64) {
        self.spread(from, to, |step, ns| step.waiting += ns);
    }

    /// Bytes leave by a link.
    pub(crate) fn bytes(&mut self, at: u64, bytes: u64) {
        self.at(at).link_bytes += bytes;
    }

    /// So many rays are held from now on.
    pub(crate) fn stored(&mut self, at: u64, rays: u64) {
        self.at(at);
        self.stored = rays;
        let step = self.at(at);
        step.stored = step.stored.max(rays);
    }

    /// So many pixels are complete from now on.
    pub(crate) fn pixels(&mut self, at: u64, pixels: u64) {
        self.at(at);
        self.pixels = pixels;
        self.at(at).pixels = pixels;
    }

    /// The time line of so many nodes, until `end`, of which some died at these times.
    pub(crate) fn finish(
        mut self,
        end: u64,
        nodes: u16,
        deaths: impl Iterator<Item = u64>,
    ) -> Timeline {
        self.at(end.saturating_sub(1));
        for at in deaths {
            self.spread(at, end, |step, ns| step.dead += ns);
        }
        let step_ns = 1 << self.power;
        let used = end.div_ceil(step_ns) as usize;
        let samples = self.steps.iter().take(used).enumerate().map(|(index, step)| {
            let length = (end - index as u64 * step_ns).min(step_ns) as f64;
            let [busy, waiting, dead] =
                [step.busy, step.waiting, step.dead].map(|ns| ns as f64 / length);
            Sample {
                busy,
                useful: step.useful as f64 / length,
                waiting,
                idle: (f64::from(nodes) - busy - waiting - dead).max(0.0),
                dead,
                stored: step.stored,
                link_bytes: step.link_bytes,
                pixels: step.pixels,
            }
        });
        Timeline { step_ns, samples: samples.collect() }
    }

    fn spread(&mut self, from: u64, to: u64, mut add: impl FnMut(&mut Step, u64)) {
        if from >= to {
            return;
        }
        self.at(to - 1);
        let mut start = from;
        while start < to {
            let index = start >> self.power;
            let end = ((index + 1) << self.power).min(to);
            add(&mut self.steps[index as usize], end - start);
            start = end;
        }
    }

    /// The step of a moment.
    fn at(&mut self, at: u64) -> &mut Step {
        while at >> self.power >= STEPS as u64 {
            self.power += 1;
            let join = |pair: &[Step]| match *pair {
                [a, b] => Step {
                    busy: a.busy + b.busy,
                    useful: a.useful + b.useful,
                    waiting: a.waiting + b.waiting,
                    dead: a.dead + b.dead,
                    stored: a.stored.max(b.stored),
                    link_bytes: a.link_bytes + b.link_bytes,
                    pixels: b.pixels,
                },
                _ => pair[0],
            };
            self.steps = self.steps.chunks(2).map(join).collect();
        }
        let index = (at >> self.power) as usize;
        if self.steps.len() <= index {
            let next = Step { stored: self.stored, pixels: self.pixels, ..Step::default() };
            self.steps.resize(index + 1, next);
        }
        &mut self.steps[index]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_is_lost_when_steps_are_joined() {
        let mut line = TimelineRecorder::default();
        let end = 3 << 20;
        for start in (0..end).step_by(1024) {
            line.busy(start, start + 512, 0.25);
            line.waiting(start + 512, start + 768);
            line.bytes(start, 7);
            match start {
                0x10_0000 => line.stored(start, 5),
                0x18_0000 => line.pixels(start, 60),
                0x20_0000 => line.stored(start, 3),
                _ => {}
            }
        }
        let line = line.finish(end, 3, [end / 3].into_iter());
        assert!(line.samples.len() <= STEPS && line.samples.len() as u64 * line.step_ns >= end);
        let bytes: u64 = line.samples.iter().map(|sample| sample.link_bytes).sum();
        assert_eq!(bytes, 7 * 3 * 1024);
        for sample in &line.samples {
            assert!((sample.busy, sample.useful, sample.waiting) == (0.5, 0.125, 0.25));
            assert!((sample.idle + sample.dead - 2.25).abs() < 1e-9, "{sample:?}");
        }
        // Those who are dead are not without work.
        let dead: f64 = line.samples.iter().map(|sample| sample.dead).sum();
        assert_eq!(dead * line.step_ns as f64, f64::from(2 << 20));
        let at = |ns: u64| line.samples[(ns / line.step_ns) as usize];
        let stored = [900_000, 1_100_000, 1_900_000, 2_500_000].map(|ns| at(ns).stored);
        assert_eq!(stored, [0, 5, 5, 3]);
        assert_eq!([1_000_000, 2_900_000].map(|ns| at(ns).pixels), [0, 60]);
    }
}
