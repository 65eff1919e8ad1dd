use crate::light::Look;
use crate::path::PathKey;

#[cfg(feature = "bundles")]
use super::rows::GROUPS;
#[cfg(feature = "bundles")]
use crate::real::LANES;

/// What was found out about the last point, and is asked again about it: its looks at the first lights.
///
/// It changes no result: what is not in it is found out once more, as it always is where memory is small.
#[derive(Debug, Clone)]
pub struct Memo {
    /// The name of the path that ends at the point.
    #[cfg(feature = "bundles")]
    point: PathKey,
    #[cfg(feature = "bundles")]
    len: usize,
    #[cfg(feature = "bundles")]
    looks: [[Look; LANES]; GROUPS],
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
        let point = PathKey { path: 0, sample: 0 };
        Self { point, len: 0, looks: [[Look::NEAR; LANES]; GROUPS] }
    }

    /// Forgets what it knows, for a point.
    #[inline(always)]
    pub(super) const fn of(&mut self, point: PathKey) {
        (self.point, self.len) = (point, 0);
    }

    /// Places for its looks at so many lights.
    #[inline(always)]
    pub(super) fn begin(&mut self, len: usize) -> &mut [[Look; LANES]] {
        self.len = len;
        self.looks.get_mut(..len.div_ceil(LANES)).unwrap_or_default()
    }

    /// The looks of a point at the first lights, as far as they are known.
    #[inline(always)]
    pub(super) fn looks(&self, point: PathKey) -> &[Look] {
        let looks = self.looks.as_flattened().get(..self.len);
        looks.filter(|_| self.point == point).unwrap_or_default()
    }
}

#[cfg(not(feature = "bundles"))]
impl Memo {
    /// Of no point.
    #[must_use]
    pub const fn new() -> Self {
        Self {}
    }

    pub(super) const fn of(&mut self, _: PathKey) {}

    pub(super) const fn looks(&self, _: PathKey) -> &[Look] {
        &[]
    }
}
