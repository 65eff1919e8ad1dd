//! Eight rays side by side: a row of lanes for each number of theirs.

use super::frame::BoxRay;
use crate::geometry::{PreparedRay, Ray};
use glam::Vec3;

/// Rays of a [`Group`].
pub const GROUP: usize = 8;

/// A number of each ray.
pub type Row = [f32; GROUP];

/// Eight rays of the same [`Kind`]. A lane without a ray accepts no `t`.
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

/// The four triangles of a record, by axis.
#[derive(Debug, Clone, Copy)]
#[repr(C, align(32))]
pub struct Quad {
    /// The first vertex of each, then the second of each.
    pub v01: [Row; 3],
    /// The third of each.
    pub v2: [[f32; 4]; 3],
    /// Bit `k`: place `k` holds a triangle.
    pub used: u32,
}

/// The signs of a ray's direction, and its greatest axis: rays of one kind can be in one [`Group`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Kind(u8);

/// Eight small numbers, one for each lane.
pub type Octet = [u8; GROUP];

/// What became of the rays that were put into a group: a bit for each lane.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Filled {
    /// They are in it.
    pub lanes: u8,
    /// They are not, for no box test can be made for them.
    pub wild: u8,
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
    pub(super) fn meets(&self, near: [f32; 3], far: [f32; 3]) -> u8 {
        let (mut enter, mut leave) = (self.t_min, self.t_max);
        let rows = self.inv.iter().zip(&self.near).zip(&self.far);
        for (((inv, to_near), to_far), (first, last)) in rows.zip(near.iter().zip(far)) {
            for ((enter, inv), to_near) in enter.iter_mut().zip(inv).zip(to_near) {
                let t = first * inv + to_near;
                *enter = if t > *enter { t } else { *enter };
            }
            for ((leave, inv), to_far) in leave.iter_mut().zip(inv).zip(to_far) {
                let t = last * inv + to_far;
                *leave = if t < *leave { t } else { *leave };
            }
        }
        let lanes = enter.iter().zip(&leave).enumerate();
        lanes.fold(0, |mask, (lane, (enter, leave))| mask | u8::from(enter <= leave) << lane)
    }

    /// The boxes that a lane meets: the kernel of any machine.
    #[inline(always)]
    pub(super) fn slots(&self, lane: usize, near: [&Row; 3], far: [&Row; 3]) -> u8 {
        let at = |row: &Row| row.get(lane).copied().unwrap_or(0.0);
        let mut enter = [at(&self.t_min); 8];
        let mut leave = [at(&self.t_max); 8];
        let rows = self.inv.iter().zip(&self.near).zip(&self.far);
        for (((inv, to_near), to_far), (first, last)) in rows.zip(near.iter().zip(far)) {
            let (inv, to_near, to_far) = (at(inv), at(to_near), at(to_far));
            for (enter, plane) in enter.iter_mut().zip(*first) {
                let t = plane * inv + to_near;
                *enter = if t > *enter { t } else { *enter };
            }
            for (leave, plane) in leave.iter_mut().zip(last) {
                let t = plane * inv + to_far;
                *leave = if t < *leave { t } else { *leave };
            }
        }
        let slots = enter.iter().zip(&leave).enumerate();
        slots.fold(0, |mask, (slot, (enter, leave))| mask | u8::from(enter <= leave) << slot)
    }

    /// Puts rays into lanes, in their order: the kernel of any machine.
    #[inline(always)]
    pub(super) fn fill(&mut self, rays: &[Ray], members: &[u16]) -> Filled {
        *self = Self::NONE;
        let mut filled = Filled { lanes: 0, wild: 0 };
        for (lane, &member) in members.iter().enumerate().take(GROUP) {
            let Some(ray) = rays.get(usize::from(member)) else { continue };
            let ray = PreparedRay::new(ray);
            if ray.is_none() {
                continue;
            }
            let boxes = BoxRay::new(&ray);
            if boxes.pad == f32::INFINITY {
                filled.wild |= 1 << lane;
            } else {
                filled.lanes |= 1 << lane;
                self.set(lane, &ray, &boxes);
            }
        }
        filled
    }

    /// The ray in a lane, prepared, of which the rest is known.
    #[inline(always)]
    #[must_use]
    pub fn prepared(&self, lane: usize, kind: Kind, ray: &Ray) -> PreparedRay {
        let at = |row: &Row| row.get(lane & (GROUP - 1)).copied().unwrap_or(0.0);
        let ([ix, iy, iz], [sx, sy, sz]) = (&self.inv, &self.shear);
        PreparedRay {
            origin: ray.origin,
            direction: ray.direction,
            t_min: at(&self.t_min),
            t_max: at(&self.t_max),
            inv: Vec3::new(at(ix), at(iy), at(iz)),
            shear: [at(sx), at(sy), at(sz)],
            axis: kind.axis(),
            signs: kind.signs(),
        }
    }
}

impl Kind {
    /// How many there are, with those that no ray is of.
    pub(super) const COUNT: usize = 32;

    /// That of a ray of these signs, as in [`PreparedRay`].
    #[inline(always)]
    #[must_use]
    pub const fn new(signs: u8, axis: u8) -> Self {
        Self((signs & 7) << 2 | if axis < 2 { axis } else { 2 })
    }

    /// That of a ray, whatever it is.
    #[inline(always)]
    #[must_use]
    pub fn of(ray: &Ray) -> Self {
        Self::new(PreparedRay::signs(ray.direction), PreparedRay::axis(ray.direction))
    }

    /// A number below [`COUNT`](Self::COUNT).
    #[inline(always)]
    pub(super) const fn index(self) -> usize {
        self.0 as usize
    }

    /// As in [`PreparedRay`].
    #[inline(always)]
    #[must_use]
    pub const fn signs(self) -> u8 {
        self.0 >> 2
    }

    /// As in [`PreparedRay`].
    #[inline(always)]
    #[must_use]
    pub const fn axis(self) -> u8 {
        self.0 & 3
    }
}

impl Quad {
    /// No triangle.
    pub(super) const NONE: Self = Self { v01: [[0.0; 8]; 3], v2: [[0.0; 4]; 3], used: 0 };
}

#[inline(always)]
fn put(rows: &mut [Row; 3], lane: usize, values: [f32; 3]) {
    for (row, value) in rows.iter_mut().zip(values) {
        if let Some(place) = row.get_mut(lane) {
            *place = value;
        }
    }
}
