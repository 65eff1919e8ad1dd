//! All rays of a bundle as one, in intervals.

use super::frame::BoxRay;
use super::group::Row;
use crate::block::format::{BlockHeader, Node};

/// Origins, and inverses of directions, from the least to the greatest of a bundle whose rays have the same signs.
///
/// # Why no box test loses a hit
/// Per axis, a ray's `t0` of a plane is `d * inv` with `d` and `inv` from the bundle's intervals; `inv` is of one sign. So it is at least the
/// lesser of the least `d` times either end of `inv`'s interval. `d` is rounded as in [`BoxFrame`](super::BoxFrame), with the greatest of the pads.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Beam {
    origin: [[f32; 3]; 2],
    inv: [[f32; 3]; 2],
    pad: f32,
}

/// A beam in the frame of a block: `d = q * scale + near` (or `far`) for a bound `q`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BeamFrame {
    /// Size of one step.
    pub scale: [f32; 3],
    /// Origin of the block's frame.
    pub origin: [f32; 3],
    /// To be added for the bound that is met first: the lower one where `inv` is not negative.
    pub near: [f32; 3],
    /// To be added for the other bound.
    pub far: [f32; 3],
    /// Least and greatest `1 / d`.
    pub inv: [[f32; 3]; 2],
}

/// The children of a node for a bundle, by slot.
#[derive(Debug, Clone, Copy)]
#[repr(C, align(32))]
pub struct Planes {
    /// The planes met first, by axis, in scene coordinates.
    pub near: [Row; 3],
    /// The others.
    pub far: [Row; 3],
    /// Where the first ray enters.
    pub enter: Row,
}

impl Beam {
    /// Of no ray.
    pub(super) const NONE: Self = Self {
        origin: [[f32::INFINITY; 3], [f32::NEG_INFINITY; 3]],
        inv: [[f32::INFINITY; 3], [f32::NEG_INFINITY; 3]],
        pad: 0.0,
    };

    /// Takes in a ray.
    #[inline(always)]
    pub(super) fn take_in(&mut self, ray: &BoxRay) {
        let widen = |[low, high]: &mut [[f32; 3]; 2], by: [f32; 3]| {
            for ((low, high), x) in low.iter_mut().zip(high).zip(by) {
                *low = if x < *low { x } else { *low };
                *high = if x > *high { x } else { *high };
            }
        };
        widen(&mut self.origin, ray.origin);
        widen(&mut self.inv, ray.inv);
        self.pad = if ray.pad > self.pad { ray.pad } else { self.pad };
    }

    /// In the frame of the block with this header.
    #[inline(always)]
    pub(super) fn frame(&self, header: &BlockHeader) -> BeamFrame {
        let [lowest, highest] = self.origin;
        let [[sx, sy, sz], _] = self.inv;
        let axis = |origin: f32, low: f32, high: f32, inv: f32| {
            let (low, high) = (origin - (high + self.pad), origin - (low - self.pad));
            if inv < 0.0 { (high, low) } else { (low, high) }
        };
        let ([ox, oy, oz], [lx, ly, lz], [hx, hy, hz]) = (header.origin, lowest, highest);
        let (nx, fx) = axis(ox, lx, hx, sx);
        let (ny, fy) = axis(oy, ly, hy, sy);
        let (nz, fz) = axis(oz, lz, hz, sz);
        BeamFrame {
            scale: header.scale,
            origin: header.origin,
            near: [nx, ny, nz],
            far: [fx, fy, fz],
            inv: self.inv,
        }
    }
}

impl BeamFrame {
    /// The slots that any ray may meet between `t_min` and `t_max`: the kernel of any machine.
    #[inline(always)]
    pub(super) fn slots(&self, node: &Node, t_min: f32, t_max: f32, planes: &mut Planes) -> u32 {
        let mut enter = [t_min; 8];
        let mut leave = [t_max; 8];
        let [low, high] = &self.inv;
        let bounds = node.lo.iter().zip(&node.hi);
        let frame = self.scale.iter().zip(&self.origin).zip(self.near.iter().zip(&self.far));
        let into = planes.near.iter_mut().zip(&mut planes.far);
        for ((((lo, hi), ((scale, origin), (near, far))), (first, last)), (low, high)) in
            bounds.zip(frame).zip(into).zip(low.iter().zip(high))
        {
            let (lo, hi) = if *low < 0.0 { (hi, lo) } else { (lo, hi) };
            for ((enter, q), first) in enter.iter_mut().zip(lo).zip(first) {
                let at = f32::from(*q) * scale;
                *first = at + origin;
                let (a, b) = ((at + near) * low, (at + near) * high);
                let t = if a < b { a } else { b };
                *enter = if t > *enter { t } else { *enter };
            }
            for ((leave, q), last) in leave.iter_mut().zip(hi).zip(last) {
                let at = f32::from(*q) * scale;
                *last = at + origin;
                let (a, b) = ((at + far) * low, (at + far) * high);
                let t = if a > b { a } else { b };
                *leave = if t < *leave { t } else { *leave };
            }
        }
        planes.enter = enter;
        let lanes = enter.iter().zip(&leave).enumerate();
        lanes.fold(0, |mask, (slot, (enter, leave))| mask | u32::from(enter <= leave) << slot)
    }
}

impl Planes {
    pub(super) const NONE: Self = Self { near: [[0.0; 8]; 3], far: [[0.0; 8]; 3], enter: [0.0; 8] };
}
