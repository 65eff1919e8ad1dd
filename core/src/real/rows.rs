use super::{LANES, Real, Vector};
#[cfg(feature = "bundles")]
use crate::trace::Lanes;
use glam::Vec3;

/// A number for each lane.
pub(crate) type Row = [f32; LANES];

/// A vector for each lane, axis by axis: from memory to lanes, and back.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Rows([Row; 3]);

impl Rows {
    /// Zeros.
    pub(crate) const NONE: Self = Self([[0.0; LANES]; 3]);

    /// Puts down the vector of a lane.
    #[cfg(feature = "bundles")]
    #[inline(always)]
    pub(crate) fn set(&mut self, lane: usize, v: Vec3) {
        let [x, y, z] = &mut self.0;
        set(x, lane, v.x);
        set(y, lane, v.y);
        set(z, lane, v.z);
    }

    /// The vector of a lane.
    #[inline(always)]
    pub(crate) fn at(&self, lane: usize) -> Vec3 {
        Vec3::from(self.0.map(|row| at(&row, lane)))
    }

    /// Puts down the vectors of as many lanes as there are, from `first` on.
    #[inline(always)]
    pub(crate) fn put<R: Real>(&mut self, first: usize, v: Vector<R>) {
        let [x, y, z] = &mut self.0;
        put(x, first, v.x);
        put(y, first, v.y);
        put(z, first, v.z);
    }

    /// The vectors of as many lanes as there are, from `first` on.
    #[cfg(feature = "bundles")]
    #[inline(always)]
    pub(crate) fn read<L: Lanes>(&self, lanes: L, first: usize) -> Vector<L::Real> {
        let [x, y, z] = &self.0;
        Vector { x: lanes.read(x, first), y: lanes.read(y, first), z: lanes.read(z, first) }
    }
}

/// Puts down the number of a lane.
#[cfg(feature = "bundles")]
#[inline(always)]
pub(crate) fn set<T>(row: &mut [T; LANES], lane: usize, value: T) {
    if let Some(place) = row.get_mut(lane) {
        *place = value;
    }
}

/// The number of a lane.
#[inline(always)]
pub(crate) fn at(row: &Row, lane: usize) -> f32 {
    row.get(lane % LANES).copied().unwrap_or(0.0)
}

/// Puts down the numbers of as many lanes as there are, from `first` on.
#[inline(always)]
pub(crate) fn put<R: Real>(row: &mut Row, first: usize, x: R) {
    let mut lanes = [0.0; LANES];
    x.store(&mut lanes);
    let places = row.iter_mut().skip(first).take(R::COUNT);
    places.zip(lanes).for_each(|(place, x)| *place = x);
}
