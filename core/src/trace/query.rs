//! What is asked of rays.

use crate::geometry::{Hit, PreparedRay};

/// What is done with each hit.
pub(super) trait Query {
    /// Makes the ray no longer than it needs to be.
    #[inline(always)]
    fn begin(&self, _: &mut PreparedRay) {}

    /// Takes a hit at `t`, which the ray accepts. `hit` makes the whole of it. `true` ends the traversal.
    fn hit(&mut self, ray: &mut PreparedRay, t: f32, hit: impl FnOnce() -> Hit) -> bool;
}

/// The closest hit: the ray ends at the best so far.
pub(super) struct Closest<'a>(pub(super) &'a mut Option<Hit>);

impl Query for Closest<'_> {
    #[inline(always)]
    fn begin(&self, ray: &mut PreparedRay) {
        if let Some(best) = &self.0
            && best.t < ray.t_max
        {
            ray.t_max = best.t;
        }
    }

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

/// Any hit ends it.
pub(super) struct Any<'a>(pub(super) &'a mut bool);

impl Query for Any<'_> {
    #[inline(always)]
    fn hit(&mut self, _: &mut PreparedRay, _: f32, _: impl FnOnce() -> Hit) -> bool {
        *self.0 = true;
        true
    }
}

/// Every hit is shown to a visitor, which may end it.
pub(super) struct Every<F>(pub(super) F);

impl<F: FnMut(&Hit) -> bool> Query for Every<F> {
    #[inline(always)]
    fn hit(&mut self, _: &mut PreparedRay, _: f32, hit: impl FnOnce() -> Hit) -> bool {
        (self.0)(&hit())
    }
}

/// The queries of many rays, by ray.
pub(super) trait Queries {
    type Query<'a>: Query
    where
        Self: 'a;

    fn query(&mut self, ray: usize) -> Option<Self::Query<'_>>;
}

impl Queries for [Option<Hit>] {
    type Query<'a> = Closest<'a>;

    #[inline(always)]
    fn query(&mut self, ray: usize) -> Option<Closest<'_>> {
        self.get_mut(ray).map(Closest)
    }
}

impl Queries for [bool] {
    type Query<'a> = Any<'a>;

    #[inline(always)]
    fn query(&mut self, ray: usize) -> Option<Any<'_>> {
        self.get_mut(ray).map(Any)
    }
}
