//! What is asked of a ray.

use crate::geometry::Hit;

/// What is done with each hit.
pub trait Query {
    /// Makes a ray no longer than it needs to be after the hits before.
    #[inline(always)]
    fn shorten(&self, _t_max: &mut f32) {}

    /// Whether hits make a ray shorter. Where any hit will do, or all are wanted, none does: whatever the ray meets it reaches, and it may as well visit the tree from
    /// its far end. So it does where all blocks are at hand, as it would test the surface that it leaves before all others. (Where blocks are fetched it begins with
    /// those nearby: rays to a sky fetch three times as many from the other end.)
    #[inline(always)]
    fn shortens(&self) -> bool {
        true
    }

    /// Where any one hit is the answer: whether there has been one. Together with others, a ray that lacks a block then goes past it, and waits for it only
    /// if nothing beyond is in its way. `None`: each hit counts.
    #[inline(always)]
    fn answered(&self) -> Option<bool> {
        None
    }

    /// Takes a hit at `t`, which the ray accepts, and may make the ray shorter if it [does so](Self::shortens). `true` ends the traversal.
    fn hit(&mut self, t_max: &mut f32, t: f32, hit: &impl Whole) -> bool;
}

/// A hit of which no more is known than was needed to find it.
pub trait Whole {
    /// All of it.
    fn whole(&self) -> Hit;
}

impl<F: Fn() -> Hit> Whole for F {
    #[inline(always)]
    fn whole(&self) -> Hit {
        self()
    }
}

/// The closest hit: the ray ends at the best so far.
impl Query for Option<Hit> {
    #[inline(always)]
    fn shorten(&self, t_max: &mut f32) {
        if let Some(best) = self
            && best.t < *t_max
        {
            *t_max = best.t;
        }
    }

    #[inline(always)]
    fn hit(&mut self, t_max: &mut f32, t: f32, hit: &impl Whole) -> bool {
        // The whole hit is made where it stays: made first, it would be copied.
        let closer = match self {
            None => true,
            Some(best) if t == best.t => ties(best, hit),
            Some(best) => t < best.t,
        };
        if closer {
            *self = Some(hit.whole());
            *t_max = t;
        }
        false
    }
}

/// Whether a hit comes before another at the same `t`.
#[cold]
#[inline(never)]
fn ties(best: &Hit, hit: &impl Whole) -> bool {
    hit.whole().is_closer_than(best)
}

/// Whether there is any hit: the first ends it.
impl Query for bool {
    #[inline(always)]
    fn shortens(&self) -> bool {
        false
    }

    #[inline(always)]
    fn answered(&self) -> Option<bool> {
        Some(*self)
    }

    #[inline(always)]
    fn hit(&mut self, _: &mut f32, _: f32, _: &impl Whole) -> bool {
        *self = true;
        true
    }
}

/// Every hit is shown to a visitor, which may end it.
pub(super) struct Every<F>(pub(super) F);

impl<F: FnMut(&Hit) -> bool> Query for Every<F> {
    #[inline(always)]
    fn shortens(&self) -> bool {
        false
    }

    #[inline(always)]
    fn hit(&mut self, _: &mut f32, _: f32, hit: &impl Whole) -> bool {
        (self.0)(&hit.whole())
    }
}
