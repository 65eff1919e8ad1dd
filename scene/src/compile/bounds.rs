//! Boxes for the build: eight lanes, so that a union is one lane-wise minimum.

use bytemuck::{Pod, Zeroable};

/// The box `lo[0..3] ..= -(neg_hi[0..3])`; lanes 3 and 7 are free and mean nothing.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C, align(32))]
pub(crate) struct Bounds(pub(crate) [f32; 8]);

impl Bounds {
    /// Holds nothing.
    pub(crate) const EMPTY: Self = Self([f32::INFINITY; 8]);

    #[inline(always)]
    pub(crate) fn grow(&mut self, other: &[f32; 8]) {
        for (a, b) in self.0.iter_mut().zip(other) {
            *a = if *b < *a { *b } else { *a };
        }
    }

    pub(crate) fn lo(&self) -> [f32; 3] {
        [self.0[0], self.0[1], self.0[2]]
    }

    pub(crate) fn hi(&self) -> [f32; 3] {
        [-self.0[4], -self.0[5], -self.0[6]]
    }

    /// The lower and the upper corner; of an empty box both are zero.
    pub(crate) fn ends(&self) -> ([f32; 3], [f32; 3]) {
        if self.is_empty() { ([0.0; 3], [0.0; 3]) } else { (self.lo(), self.hi()) }
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.0[0] == f32::INFINITY
    }

    /// Half the surface area; 0 for an empty box.
    #[inline(always)]
    pub(crate) fn area(&self) -> f32 {
        let b = &self.0;
        let (x, y, z) = (-b[4] - b[0], -b[5] - b[1], -b[6] - b[2]);
        let area = x * y + y * z + z * x;
        if area > 0.0 && x >= 0.0 { area } else { 0.0 }
    }
}

/// A primitive during the build: its own box and its name.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[repr(C, align(32))]
pub(crate) struct Item {
    pub(crate) lo: [f32; 3],
    /// Index among the surfaces: triangles, then spheres.
    pub(crate) primitive: u32,
    pub(crate) neg_hi: [f32; 3],
    /// Primitives of one record have the same: material, and 2¹⁶ for spheres.
    pub(crate) group: u32,
}

impl Item {
    pub(crate) fn new(primitive: u32, group: u32, lo: [f32; 3], hi: [f32; 3]) -> Self {
        Self { lo, primitive, neg_hi: hi.map(|v| -v), group }
    }

    /// The box; its free lanes hold whatever the names are as floats.
    #[inline(always)]
    pub(crate) fn lanes(&self) -> &[f32; 8] {
        bytemuck::cast_ref(self)
    }

    /// Twice the centre of the box.
    #[inline(always)]
    pub(crate) fn center2(&self, axis: usize) -> f32 {
        self.lo[axis] - self.neg_hi[axis]
    }
}
