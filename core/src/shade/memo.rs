#[cfg(feature = "bundles")]
use crate::light::Glance;
use crate::light::Look;
use crate::path::PathKey;

#[cfg(feature = "bundles")]
use super::rows::GROUPS;
#[cfg(feature = "bundles")]
use super::{FEW_LIGHTS, Glances, LightRows};
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
    /// What it sees of the first lights, where they are few.
    #[cfg(feature = "bundles")]
    glances: [Option<(Glance<f32>, Option<f32>)>; FEW_LIGHTS],
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
        let glances = [None; FEW_LIGHTS];
        Self { point, len: 0, looks: [[Look::NEAR; LANES]; GROUPS], glances }
    }

    /// Forgets what it knows, for a point.
    #[inline(always)]
    pub(super) const fn of(&mut self, point: PathKey) {
        (self.point, self.len) = (point, 0);
    }

    /// Knows what the point sees, which is that of a ray, of as many lights as there are planes.
    #[inline(always)]
    pub(crate) fn glance(
        &mut self,
        point: PathKey,
        glances: &Glances,
        lane: usize,
        lights: &LightRows,
    ) {
        self.of(point);
        let places = self.glances.iter_mut().zip(lights.planes()).enumerate();
        for (light, (place, plane)) in places {
            *place = plane.and_then(|_| glances.get(light, lane));
        }
    }

    /// What a point sees of a light, if it is known.
    #[inline(always)]
    pub(super) fn glance_of(
        &self,
        point: PathKey,
        light: usize,
    ) -> Option<&(Glance<f32>, Option<f32>)> {
        let glance = self.glances.get(light)?.as_ref();
        glance.filter(|_| self.point == point)
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
