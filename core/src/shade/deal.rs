use super::Unit;
use crate::elementary::{exponent, power_of_two};
use glam::Vec3;

/// The light of a lamp that is known without shadows, and the parts of it that its samples take.
///
/// Each takes what it brings, rounded; a ray of its own takes what is left, which may be less than nothing: so where all rays arrive their
/// [quantised](Unit::quantise) sum is exactly that of the whole. That ray goes to a place that does not depend on the samples. As what is left
/// is nothing in the mean, the mean is right whatever becomes of that ray: the known light is a control variate (Owen 2013, Monte Carlo
/// theory, 8.9), with a visibility that knows nothing of the samples as its coefficient. (A sample among the others that takes the rest as well would
/// weigh it by what is in its own way: light that comes from a bright part of a lamp alone would be worth too little or too much.)
///
/// The whole and its parts are multiples of a grain, a power of two, of which the whole has less than 2¹⁹ in any channel: so all sums and
/// differences of them are exact in f32, as long as samples bring at most [`MOST`](crate::light::MOST) times their share.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Deal {
    rest: Vec3,
    /// 1.5 × 2²³ grains: added and taken away again it rounds to grains. Nothing is known of the whole if it is 0.
    shift: f32,
}

impl Deal {
    /// No whole is known: what is taken is taken as it is.
    pub(super) const UNKNOWN: Self = Self { rest: Vec3::INFINITY, shift: 0.0 };

    /// The whole, which is rounded to its grain: by 2⁻¹⁹ of its greatest channel at most.
    pub(super) fn new(whole: Vec3, unit: &Unit) -> Self {
        let grain = power_of_two(exponent(whole.max_element()) - 19).max(unit.step());
        let shift = 12_582_912.0 * grain;
        Self { rest: rounded(whole, shift), shift }
    }

    /// Whether the whole is known.
    pub(super) const fn is_known(&self) -> bool {
        self.shift > 0.0
    }

    /// What is left: the whole, before anything is taken.
    pub(super) const fn rest(&self) -> Vec3 {
        self.rest
    }

    /// The light of a ray, if it counts: of a sample that brings about this, or of the ray that takes the rest.
    #[inline(always)]
    pub(super) fn part(&mut self, light: Vec3, is_rest: bool) -> Option<Vec3> {
        if is_rest {
            return (self.rest != Vec3::ZERO).then_some(self.rest);
        }
        let light = self.take(light);
        (light.max_element() > 0.0).then_some(light)
    }

    /// Takes a part of about this.
    fn take(&mut self, part: Vec3) -> Vec3 {
        if !self.is_known() {
            return part;
        }
        // More than that no part has: a third is 2²² grains.
        let part = rounded(part.min(Vec3::splat(self.shift * (1.0 / 3.0))), self.shift);
        self.rest -= part;
        part
    }
}

fn rounded(light: Vec3, shift: f32) -> Vec3 {
    (light + shift) - shift
}

#[cfg(test)]
mod tests {
    use super::super::Sum;
    use super::*;
    use crate::light::MOST;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn the_parts_have_the_sum_of_the_whole(
            whole in prop::array::uniform3(0f32..2.0),
            scale in -60i32..15,
            weights in prop::collection::vec(prop::array::uniform3(0f32..MOST), 2..200),
            brightest in 0.01f32..1e6,
        ) {
            let unit = Unit::new(brightest);
            let whole = Vec3::from(whole) * power_of_two(scale) * brightest;
            let mut deal = Deal::new(whole, &unit);
            let exact = unit.quantise(deal.rest());
            let grain = f64::from(unit.step()).max(f64::from(whole.max_element()) / f64::from(1 << 18));
            prop_assert!((deal.rest() - whole).abs().as_dvec3().max_element() <= grain);
            let mut sum = Sum::ZERO;
            for weight in &weights {
                let part = whole * Vec3::from(*weight) / weights.len() as f32;
                let taken = deal.part(part, false).unwrap_or_default();
                prop_assert!((taken - part).abs().as_dvec3().max_element() <= grain);
                sum.add(unit.quantise(taken));
            }
            sum.add(unit.quantise(deal.part(Vec3::ONE, true).unwrap_or_default()));
            prop_assert_eq!(sum, exact);
        }
    }
}
