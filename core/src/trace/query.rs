//! What is asked of a ray.

use crate::geometry::{Hit, PreparedRay};

/// What is done with each hit.
pub(super) trait Query {
    /// Takes a hit at `t`, which the ray accepts. `hit` makes the whole of it. `true` ends the traversal.
    fn hit(&mut self, ray: &mut PreparedRay, t: f32, hit: impl FnOnce() -> Hit) -> bool;
}

/// The closest hit: the ray ends at the best so far.
pub(super) struct Closest {
    pub(super) best: Option<Hit>,
}

impl Query for Closest {
    #[inline(always)]
    fn hit(&mut self, ray: &mut PreparedRay, t: f32, hit: impl FnOnce() -> Hit) -> bool {
        let hit = hit();
        if self.best.as_ref().is_none_or(|best| hit.is_closer_than(best)) {
            self.best = Some(hit);
            ray.t_max = t;
        }
        false
    }
}

/// Any hit ends it.
pub(super) struct Any {
    pub(super) found: bool,
}

impl Query for Any {
    #[inline(always)]
    fn hit(&mut self, _: &mut PreparedRay, _: f32, _: impl FnOnce() -> Hit) -> bool {
        self.found = true;
        true
    }
}

/// Every hit is shown to a visitor, which may end it.
pub(super) struct Every<F> {
    pub(super) visit: F,
}

impl<F: FnMut(&Hit) -> bool> Query for Every<F> {
    #[inline(always)]
    fn hit(&mut self, _: &mut PreparedRay, _: f32, hit: impl FnOnce() -> Hit) -> bool {
        (self.visit)(&hit())
    }
}

/// As [`Closest`], in a place of the caller's.
pub(super) struct ClosestInto<'a>(pub(super) &'a mut Option<Hit>);

impl Query for ClosestInto<'_> {
    #[inline(always)]
    fn hit(&mut self, ray: &mut PreparedRay, t: f32, hit: impl FnOnce() -> Hit) -> bool {
        let hit = hit();
        if self.0.as_ref().is_none_or(|best| hit.is_closer_than(best)) {
            *self.0 = Some(hit);
            ray.t_max = t;
        }
        false
    }
}

/// As [`Any`], in a place of the caller's.
pub(super) struct AnyInto<'a>(pub(super) &'a mut bool);

impl Query for AnyInto<'_> {
    #[inline(always)]
    fn hit(&mut self, _: &mut PreparedRay, _: f32, _: impl FnOnce() -> Hit) -> bool {
        *self.0 = true;
        true
    }
}
