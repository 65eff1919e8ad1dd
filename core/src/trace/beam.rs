//! All rays of a stream as one, in intervals.

use super::frame::BoxRay;
use super::group::{GROUP, Group, Row};

/// Origins, and inverses of directions, from the least to the greatest of rays that have the same signs: what decides for all of them that they miss a
/// box.
///
/// # Why no box test loses a hit
/// Per axis, a ray's `t0` of a plane is `d * inv` with `d` and `inv` from the intervals; `inv` is of one sign. So it is at least the lesser of
/// the least `d` times either end of the interval of `inv`. `d` is rounded as in [`Group`], with the greatest of the pads.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Beam {
    /// To be subtracted from the planes that are met first, by axis.
    pub near: [f32; 3],
    /// To be subtracted from the others.
    pub far: [f32; 3],
    /// Least and greatest `1 / d`.
    pub inv: [[f32; 3]; 2],
    /// Least accepted `t`.
    pub t_min: f32,
    /// Greatest accepted `t`.
    pub t_max: f32,
}

impl Beam {
    /// Of no ray.
    pub(super) const NONE: Self = Self {
        near: [0.0; 3],
        far: [0.0; 3],
        inv: [[1.0; 3]; 2],
        t_min: f32::INFINITY,
        t_max: f32::NEG_INFINITY,
    };

    /// That of the rays in these groups, which have these signs.
    #[inline(always)]
    #[must_use]
    pub fn of(groups: &[Group], signs: u8) -> Self {
        let mut beam = Self { t_max: farthest(groups), ..Self::NONE };
        let mut t_min = [f32::INFINITY; GROUP];
        for group in groups {
            t_min = rows(&t_min, &group.t_min, |a, b| if a < b { a } else { b });
        }
        beam.t_min = t_min.iter().fold(f32::INFINITY, |a, &b| if a < b { a } else { b });
        let [least, greatest] = &mut beam.inv;
        let mut origin = [[0.0; 2]; 3];
        for (axis, ((least, greatest), origin)) in
            least.iter_mut().zip(greatest).zip(&mut origin).enumerate()
        {
            [*least, *greatest] = ends(groups, |group| group.inv.get(axis));
            *origin = ends(groups, |group| group.origin.get(axis));
        }
        let farther = |far: f32, [low, high]: &[f32; 2]| far.max(low.abs()).max(high.abs());
        let pad = (origin.iter().fold(0.0, farther) + 1.01) * BoxRay::PAD;
        let far = beam.far.iter_mut();
        for (axis, ((near, far), [low, high])) in
            beam.near.iter_mut().zip(far).zip(origin).enumerate()
        {
            let (low, high) = (low - pad, high + pad);
            (*near, *far) = if signs >> axis & 1 == 0 { (high, low) } else { (low, high) };
        }
        beam
    }

    /// The boxes that any ray may meet, by slot, of which these are the planes that are met first and last; and where the first ray enters each: the kernel of
    /// any machine.
    #[inline(always)]
    pub(super) fn meets(&self, (near, far): ([&Row; 3], [&Row; 3]), enter: &mut Row) -> u8 {
        *enter = [self.t_min; 8];
        let mut leave = [self.t_max; 8];
        let [low, high] = &self.inv;
        let inv = low.iter().zip(high);
        let planes = near.iter().zip(far).zip(self.near.iter().zip(&self.far));
        for (((first, last), (near, far)), (low, high)) in planes.zip(inv) {
            for (enter, plane) in enter.iter_mut().zip(*first) {
                let (a, b) = ((plane - near) * low, (plane - near) * high);
                let t = if a < b { a } else { b };
                *enter = if t > *enter { t } else { *enter };
            }
            for (leave, plane) in leave.iter_mut().zip(last) {
                let (a, b) = ((plane - far) * low, (plane - far) * high);
                let t = if a > b { a } else { b };
                *leave = if t < *leave { t } else { *leave };
            }
        }
        let slots = enter.iter().zip(&leave).enumerate();
        slots.fold(0, |mask, (slot, (enter, leave))| mask | u8::from(enter <= leave) << slot)
    }
}

/// The greatest `t` that any ray of these groups accepts.
#[inline(always)]
pub(super) fn farthest(groups: &[Group]) -> f32 {
    let mut far = [f32::NEG_INFINITY; GROUP];
    for group in groups {
        far = rows(&far, &group.t_max, |a, b| if a > b { a } else { b });
    }
    far.iter().fold(f32::NEG_INFINITY, |a, &b| if a > b { a } else { b })
}

/// The least and the greatest number of the rays of some groups.
#[inline(always)]
pub(super) fn ends<'g>(
    groups: &'g [Group],
    row: impl Fn(&'g Group) -> Option<&'g Row>,
) -> [f32; 2] {
    let (mut low, mut high) = ([f32::INFINITY; GROUP], [f32::NEG_INFINITY; GROUP]);
    for group in groups {
        let Some(row) = row(group) else { continue };
        let places = low.iter_mut().zip(&mut high).zip(row);
        for ((low, high), (&x, &t_min)) in
            places.zip(&group.t_min).map(|((places, x), t)| (places, (x, t)))
        {
            // Lanes without a ray accept no `t`.
            let has = t_min < f32::INFINITY;
            *low = if has & (x < *low) { x } else { *low };
            *high = if has & (x > *high) { x } else { *high };
        }
    }
    let least = low.iter().fold(f32::INFINITY, |a, &b| if a < b { a } else { b });
    [least, high.iter().fold(f32::NEG_INFINITY, |a, &b| if a > b { a } else { b })]
}

#[inline(always)]
fn rows(a: &Row, b: &Row, of: impl Fn(f32, f32) -> f32) -> Row {
    let mut to = *a;
    for (to, &b) in to.iter_mut().zip(b) {
        *to = of(*to, b);
    }
    to
}
