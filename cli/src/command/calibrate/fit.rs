use kiloray_core::node::Work;
use kiloray_sim::Profile;

/// Operations that are fitted.
const TERMS: usize = 16;
/// How much the shape of `pc` counts against one picture: where pictures do not tell operations apart, it does.
const HOLD: f64 = 0.01;
/// Rounds of the descent: far more than it needs.
const ROUNDS: usize = 20_000;

/// A picture: how often each operation was done, and how long all took.
#[derive(Debug, Clone, Copy)]
pub(super) struct Row {
    counts: [f64; TERMS],
    /// How long all took \[ns\]; infinite before it is measured.
    pub(super) ns: f64,
}

impl Row {
    /// Not yet timed, of a node's operations in a scene where a hit takes so many estimates of lights.
    pub(super) fn new(work: &Work<u64>, estimates: usize) -> Self {
        let counts = [
            work.nodes,
            work.leaves,
            work.blocks,
            work.rays,
            work.shadow_rays,
            work.bundle_rays,
            work.bundle_nodes,
            work.bundle_boxes,
            work.bundle_ray_boxes,
            work.bundle_triangles,
            work.bundle_ray_triangles,
            work.shadings,
            work.shadings * estimates as u64,
            work.lights,
            work.light_samples,
            work.clips,
        ];
        Self { counts: counts.map(|count| count as f64), ns: f64::INFINITY }
    }

    /// How far a profile's time is from that measured, as a part of this.
    pub(super) fn error(&self, profile: &Profile) -> f64 {
        self.time(profile) / self.ns - 1.0
    }

    /// By a profile \[ns\].
    fn time(&self, profile: &Profile) -> f64 {
        self.sum(&values(profile))
    }

    fn sum(&self, each: &[f64; TERMS]) -> f64 {
        self.counts.iter().zip(each).map(|(n, ns)| n * ns).sum()
    }
}

/// The figures of a profile, in the order of a row's counts.
fn figures(profile: &mut Profile) -> [&mut f64; TERMS] {
    [
        &mut profile.node,
        &mut profile.leaf,
        &mut profile.block,
        &mut profile.ray,
        &mut profile.shadow_ray,
        &mut profile.bundle_ray,
        &mut profile.bundle_node,
        &mut profile.bundle_box,
        &mut profile.bundle_ray_box,
        &mut profile.bundle_triangle,
        &mut profile.bundle_ray_triangle,
        &mut profile.shading,
        &mut profile.light,
        &mut profile.light_bundle,
        &mut profile.light_sample,
        &mut profile.clip,
    ]
}

/// The same, to read.
fn values(profile: &Profile) -> [f64; TERMS] {
    figures(&mut profile.clone()).map(|figure| *figure)
}

/// The profile `pc`, so much faster or slower that it is right in the middle, and then the least squares of relative errors with no
/// time below zero, by coordinate descent. What the pictures do not show, as messages, is scaled alone.
pub(super) fn fit(rows: &[Row]) -> Profile {
    let mut profile = Profile::PC;
    let mut ratios: Vec<f64> = rows.iter().map(|row| row.ns / row.time(&profile)).collect();
    ratios.sort_by(f64::total_cmp);
    let scale = ratios.get(ratios.len() / 2).copied().unwrap_or(1.0);
    profile.message = rounded(profile.message * scale);
    let prior = values(&profile).map(|figure| figure * scale);
    let mut found = prior;
    for _ in 0..ROUNDS {
        for (term, held) in prior.into_iter().enumerate() {
            let (mut numerator, mut denominator) = (HOLD / held, HOLD / held.powi(2));
            for row in rows {
                let rest = row.sum(&found) - row.counts[term] * found[term];
                numerator += row.counts[term] * (row.ns - rest) / row.ns.powi(2);
                denominator += (row.counts[term] / row.ns).powi(2);
            }
            found[term] = (numerator / denominator).max(0.0);
        }
    }
    for (figure, found) in figures(&mut profile).into_iter().zip(found) {
        *figure = rounded(found);
    }
    profile
}

/// More figures than can be measured help nobody.
pub(super) fn rounded(ns: f64) -> f64 {
    (ns * 1000.0).round() / 1000.0
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Pictures that each do something else most, on a machine that is slower.
    fn rows(slower: impl Fn(usize) -> f64) -> Vec<Row> {
        (0..TERMS)
            .map(|most| {
                let mut row = Row { counts: [1e3; TERMS], ns: 0.0 };
                row.counts[most] = 1e6;
                let mut machine = Profile::PC;
                for (term, figure) in figures(&mut machine).into_iter().enumerate() {
                    *figure *= slower(term);
                }
                row.ns = row.time(&machine);
                row
            })
            .collect()
    }

    #[test]
    fn a_machine_that_is_slower_throughout_is_found() {
        let profile = fit(&rows(|_| 2.5));
        assert!((profile.message - 2.5 * Profile::PC.message).abs() < 1e-9);
        for (found, pc) in values(&profile).into_iter().zip(values(&Profile::PC)) {
            assert!((found / pc - 2.5).abs() < 0.01, "{found} {pc}");
        }
    }

    #[test]
    fn a_machine_of_another_shape_is_found() {
        let slower = |term: usize| if term.is_multiple_of(3) { 4.0 } else { 1.5 };
        let rows = rows(slower);
        let profile = fit(&rows);
        for row in &rows {
            assert!((row.time(&profile) / row.ns - 1.0).abs() < 0.05);
        }
        let found = values(&profile).into_iter().zip(values(&Profile::PC));
        for (term, (found, pc)) in found.enumerate() {
            assert!((found / pc / slower(term) - 1.0).abs() < 0.1, "{term}: {found} {pc}");
        }
    }

    #[test]
    fn what_no_picture_shows_keeps_its_shape() {
        let mut rows = rows(|_| 3.0);
        rows.pop();
        for row in &mut rows {
            row.ns -= row.counts[TERMS - 1] * 3.0 * Profile::PC.clip;
            row.counts[TERMS - 1] = 0.0;
        }
        let profile = fit(&rows);
        assert!((profile.clip / Profile::PC.clip - 3.0).abs() < 0.03, "{}", profile.clip);
    }
}
