use crate::light::Dark;
use crate::path::PathKey;

/// What was found out about the last point, and is asked again about it.
///
/// It changes no result: what is not in it is found out once more, as it always is where memory is small.
#[derive(Debug, Clone)]
pub struct Memo {
    /// The name of the path that ends at the point.
    #[cfg(feature = "bundles")]
    point: PathKey,
    /// How many lights of the table have been looked at, the first ones.
    #[cfg(feature = "bundles")]
    len: usize,
    #[cfg(feature = "bundles")]
    looks: [Look; LOOKS],
}

/// Lights whose looks are kept.
#[cfg(feature = "bundles")]
const LOOKS: usize = 64;

/// What a quick look at a light shows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Look {
    /// Nothing: it is to be looked at closely.
    Near,
    /// What it would bring, roughly: [`Aim::far`](crate::light::Aim::far).
    Far(f32),
    /// Why it cannot light the point.
    Dark(Dark),
}

impl Default for Memo {
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(feature = "bundles")]
impl Memo {
    /// Of no point.
    #[must_use]
    pub const fn new() -> Self {
        Self { point: PathKey { path: 0, sample: 0 }, len: 0, looks: [Look::Near; LOOKS] }
    }

    /// Begins with a point.
    pub(super) const fn begin(&mut self, point: PathKey) {
        (self.point, self.len) = (point, 0);
    }

    /// Keeps the look at the next light.
    #[inline(always)]
    pub(super) fn note(&mut self, look: Look) {
        if let Some(place) = self.looks.get_mut(self.len) {
            *place = look;
            self.len = self.len.wrapping_add(1);
        }
    }

    /// The look of a point at a light, if it was kept.
    #[inline(always)]
    pub(super) fn look(&self, point: PathKey, light: u32) -> Option<Look> {
        let kept = (light as usize) < self.len && self.point == point;
        self.looks.get(light as usize).copied().filter(|_| kept)
    }
}

#[cfg(not(feature = "bundles"))]
impl Memo {
    /// Of no point.
    #[must_use]
    pub const fn new() -> Self {
        Self {}
    }

    pub(super) const fn begin(&mut self, _: PathKey) {}

    pub(super) const fn note(&mut self, _: Look) {}

    pub(super) const fn look(&self, _: PathKey, _: u32) -> Option<Look> {
        None
    }
}
