//! Eight rays side by side: a row of lanes for each number of theirs.

use super::frame::BoxRay;
use crate::geometry::{Aabb, PreparedRay};
use glam::Vec3;

/// Rays of a [`Group`].
pub const GROUP: usize = 8;

/// A number of each ray.
pub type Row = [f32; GROUP];

/// Eight rays of the same signs and the same greatest axis. A lane without a ray accepts no `t`.
///
/// # Why no box test loses a hit
/// As in [`BoxFrame`](super::BoxFrame), whose frame is here the scene's own: `t = plane * inv + near`. The plane is rounded once more (by `u`, as
/// it lies in the cube), and so is the product of it (by `u R_b |inv|`): with fused operations or without, the bounds err by at most
/// `8 u R_b |inv|`, and 19.1 and 8 are still less than the 32 of the pad.
#[derive(Debug, Clone, Copy)]
#[repr(C, align(32))]
pub struct Group {
    /// [`BoxRay::inv`], by axis.
    pub inv: [Row; 3],
    /// To be added to the plane that is met first, times `inv`.
    pub near: [Row; 3],
    /// To be added to the other plane, times `inv`.
    pub far: [Row; 3],
    /// Least accepted `t`.
    pub t_min: Row,
    /// Greatest accepted `t`.
    pub t_max: Row,
    /// Origins, by axis.
    pub origin: [Row; 3],
    /// Origins along `kx, ky, kz`.
    pub sheared: [Row; 3],
    /// [`PreparedRay::shear`].
    pub shear: [Row; 3],
}

/// A box of which the planes are known that a group meets first.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sides {
    /// The planes met first, by axis, in scene coordinates.
    pub near: [f32; 3],
    /// The others.
    pub far: [f32; 3],
}

/// A triangle for a group.
#[derive(Debug, Clone, Copy)]
pub struct Corners {
    /// The vertices along `kx, ky, kz`.
    pub sheared: [[f32; 3]; 3],
    /// Its own box, along x, y, z.
    pub own: Aabb,
}

/// What a group hits a triangle with: of each lane that is [accepted](Verdict::accepted).
#[derive(Debug, Clone, Copy)]
#[repr(C, align(32))]
pub struct Crossings {
    /// As in [`TriangleHit`](crate::geometry::TriangleHit).
    pub t: Row,
    /// Weight of vertex 1.
    pub b1: Row,
    /// Weight of vertex 2.
    pub b2: Row,
}

/// Which lanes hit a triangle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Verdict {
    /// They hit it, to the bit as [`PreparedRay::triangle`] has it.
    pub accepted: u32,
    /// These must ask [`PreparedRay::triangle`].
    pub doubtful: u32,
}

impl Crossings {
    /// None.
    pub const NONE: Self = Self { t: [0.0; GROUP], b1: [0.0; GROUP], b2: [0.0; GROUP] };
}

impl Group {
    /// Eight lanes without a ray.
    pub const NONE: Self = Self {
        inv: [[1.0; GROUP]; 3],
        near: [[0.0; GROUP]; 3],
        far: [[0.0; GROUP]; 3],
        t_min: [f32::INFINITY; GROUP],
        t_max: [f32::NEG_INFINITY; GROUP],
        origin: [[0.0; GROUP]; 3],
        sheared: [[0.0; GROUP]; 3],
        shear: [[0.0; GROUP]; 3],
    };

    /// Puts a ray into a lane.
    #[inline(always)]
    pub(super) fn set(&mut self, lane: usize, ray: &PreparedRay, boxes: &BoxRay) {
        put(&mut self.inv, lane, boxes.inv);
        let [ox, oy, oz] = boxes.origin;
        let [ix, iy, iz] = boxes.inv;
        let near = |o: f32, inv: f32| (o + boxes.pad.copysign(inv)) * -inv;
        let far = |o: f32, inv: f32| (boxes.pad.copysign(inv) - o) * inv;
        put(&mut self.near, lane, [near(ox, ix), near(oy, iy), near(oz, iz)]);
        put(&mut self.far, lane, [far(ox, ix), far(oy, iy), far(oz, iz)]);
        put(&mut self.origin, lane, ray.origin.to_array());
        put(&mut self.sheared, lane, ray.permuted(ray.origin).into());
        put(&mut self.shear, lane, ray.shear);
        if let (Some(t_min), Some(t_max)) = (self.t_min.get_mut(lane), self.t_max.get_mut(lane)) {
            (*t_min, *t_max) = (ray.t_min, ray.t_max);
        }
    }

    /// The lanes that meet a box: the kernel of any machine.
    #[inline(always)]
    pub(super) fn meets(&self, sides: &Sides) -> u32 {
        let (mut enter, mut leave) = (self.t_min, self.t_max);
        for axis in 0..3 {
            let rows = (self.inv.get(axis), self.near.get(axis), self.far.get(axis));
            let (Some(inv), Some(near), Some(far)) = rows else { continue };
            let (Some(&first), Some(&last)) = (sides.near.get(axis), sides.far.get(axis)) else {
                continue;
            };
            for ((enter, inv), near) in enter.iter_mut().zip(inv).zip(near) {
                let t = first * inv + near;
                *enter = if t > *enter { t } else { *enter };
            }
            for ((leave, inv), far) in leave.iter_mut().zip(inv).zip(far) {
                let t = last * inv + far;
                *leave = if t < *leave { t } else { *leave };
            }
        }
        let lanes = enter.iter().zip(&leave).enumerate();
        lanes.fold(0, |mask, (lane, (enter, leave))| mask | u32::from(enter <= leave) << lane)
    }

    /// The greatest `t` that any lane accepts.
    #[inline(always)]
    pub(super) fn farthest(&self) -> f32 {
        self.t_max.iter().fold(f32::NEG_INFINITY, |a, &b| if a > b { a } else { b })
    }
}

impl Corners {
    /// A triangle, for rays of this greatest axis.
    #[inline(always)]
    pub(super) fn new([a, b, c]: [Vec3; 3], axis: u8) -> Self {
        let along = |v: Vec3| match axis {
            0 => [v.y, v.z, v.x],
            1 => [v.z, v.x, v.y],
            _ => [v.x, v.y, v.z],
        };
        Self { sheared: [along(a), along(b), along(c)], own: Aabb::of_triangle([a, b, c]) }
    }
}

#[inline(always)]
fn put(rows: &mut [Row; 3], lane: usize, values: [f32; 3]) {
    for (row, value) in rows.iter_mut().zip(values) {
        if let Some(place) = row.get_mut(lane) {
            *place = value;
        }
    }
}
