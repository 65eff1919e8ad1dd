use super::Unit;
use crate::elementary::{exponent, power_of_two};
use glam::Vec3;

/// An amount of light that is dealt out in parts whose [quantised](Unit::quantise) sum is exactly that of the whole, whatever the parts are.
///
/// The whole and its parts are multiples of a grain, a power of two, of which the whole has less than 2²¹ in any channel: so all sums and
/// differences of them are exact in f32.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Deal {
    rest: Vec3,
    /// 1.5 × 2²³ grains: added and taken away again it rounds to grains. Nothing is known of the whole if it is 0.
    shift: f32,
}

impl Deal {
    /// No whole is known: what is taken is taken as it is.
    pub(super) const UNKNOWN: Self = Self { rest: Vec3::INFINITY, shift: 0.0 };

    /// The whole, which is rounded to its grain: by 2⁻²¹ of its greatest channel at most.
    pub(super) fn new(whole: Vec3, unit: &Unit) -> Self {
        let grain = power_of_two(exponent(whole.max_element()) - 21).max(unit.step());
        let shift = 12_582_912.0 * grain;
        Self { rest: rounded(whole, shift), shift }
    }

    /// Whether the whole is known.
    pub(super) const fn is_known(&self) -> bool {
        self.shift > 0.0
    }

    /// What is left.
    pub(super) const fn rest(&self) -> Vec3 {
        self.rest
    }

    /// The part of a ray that brings about this as a sample, if it counts. The `last` of those that share a known light takes what is left of it: of a
    /// lamp whose light is known, no sample is lost.
    #[inline(always)]
    pub(super) fn part(&mut self, light: Vec3, last: bool) -> Option<Vec3> {
        let light = if last && self.is_known() { self.rest() } else { self.take(light) };
        (light.max_element() > 0.0).then_some(light)
    }

    /// Takes a part of about this, and no more than is left.
    pub(super) fn take(&mut self, part: Vec3) -> Vec3 {
        if !self.is_known() {
            return part;
        }
        let part = rounded(part.min(self.rest), self.shift);
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
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn the_parts_have_the_sum_of_the_whole(
            whole in prop::array::uniform3(0f32..2.0),
            scale in -60i32..20,
            weights in prop::collection::vec(prop::array::uniform3(0f32..2.5), 1..200),
            brightest in 0.01f32..1e6,
        ) {
            let unit = Unit::new(brightest);
            let whole = Vec3::from(whole) * power_of_two(scale) * brightest;
            let mut deal = Deal::new(whole, &unit);
            let exact = unit.quantise(deal.rest());
            let grain = f64::from(unit.step()).max(f64::from(whole.max_element()) / f64::from(1 << 20));
            prop_assert!((deal.rest() - whole).abs().as_dvec3().max_element() <= grain);
            let mut sum = Sum::ZERO;
            for weight in &weights {
                sum.add(unit.quantise(deal.take(whole * Vec3::from(*weight) / weights.len() as f32)));
            }
            prop_assert!(deal.rest().min_element() >= 0.0);
            sum.add(unit.quantise(deal.rest()));
            prop_assert_eq!(sum, exact);
        }
    }
}
