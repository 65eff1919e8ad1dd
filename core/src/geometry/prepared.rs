use super::rounding::{UNIT_ROUNDOFF, max, min};
use super::{Aabb, Ray};
use glam::Vec3;

/// A ray, prepared for the tests that decide a hit: what depends on the ray alone, computed once.
///
/// Everything here is part of the [definition of a hit](super#what-a-hit-is), operation by operation.
/// Vector lanes read these fields and must not derive them in any other way.
///
/// A ray that can hit nothing is prepared as [`NONE`](Self::NONE): it accepts no `t`, and has no NaN in any
/// field. Such a ray has an origin, direction, `t_min` or `t_max` that is NaN, an infinite origin or direction,
/// or a direction whose greatest component is outside [`DIRECTION_MIN`](Self::DIRECTION_MIN) to
/// [`DIRECTION_MAX`](Self::DIRECTION_MAX).
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C)]
pub struct PreparedRay {
    /// The ray's origin.
    pub origin: Vec3,
    /// The ray's direction, as given.
    pub direction: Vec3,
    /// Least accepted `t`: the ray's, at least 0.
    pub t_min: f32,
    /// Greatest accepted `t`: the ray's, at most `f32::MAX`. A search for the closest hit lowers it.
    pub t_max: f32,
    /// `1 / d` per axis, `d` the clamped direction of step 1; never zero, infinite or NaN.
    pub inv: Vec3,
    /// `[d[kx] / d[kz], d[ky] / d[kz], 1 / d[kz]]`, of the ray's direction as given.
    pub shear: [f32; 3],
    /// The axis `kz` of the direction's component of greatest magnitude, 0 to 2; the least axis
    /// among equals. `kx` and `ky` are the two that follow it in the cycle x, y, z.
    pub axis: u8,
    /// Bit `a`: the ray descends axis `a`, or has a component of -0 there; the sign of `inv`.
    pub signs: u8,
}

impl PreparedRay {
    /// Least magnitude that a direction's greatest component may have.
    pub const DIRECTION_MIN: f32 = 1.0 / Self::DIRECTION_MAX;
    /// Greatest magnitude that a direction's greatest component may have: 2⁶⁷, above 10²⁰.
    pub const DIRECTION_MAX: f32 = (1_u128 << 67) as f32;
    /// Components less than this part of the greatest, 2⁻⁶⁰, are raised to it for box tests.
    pub const CLAMP: f32 = 1.0 / (1_u64 << 60) as f32;
    /// The pad of an own box is this part, `16 u`, of its greatest distance from the origin.
    pub const PAD: f32 = 16.0 * UNIT_ROUNDOFF;

    /// Prepares a ray. One that can hit nothing is [`NONE`](Self::NONE).
    #[inline(always)]
    #[must_use]
    pub fn new(ray: &Ray) -> Self {
        Self::of(ray).unwrap_or(Self::NONE)
    }

    /// Prepares a ray, unless its numbers are none of a ray's.
    #[inline(always)]
    #[must_use]
    pub fn of(ray: &Ray) -> Option<Self> {
        let d = ray.direction;
        let axis = Self::axis(d);
        let pick = |x: f32, y: f32, z: f32| select(axis == 0, x, select(axis == 1, y, z));
        let (x, y, z) = (pick(d.y, d.z, d.x), pick(d.z, d.x, d.y), pick(d.x, d.y, d.z));
        let greatest = z.abs();
        let valid = ray.origin.is_finite()
            && ray.direction.is_finite()
            && (Self::DIRECTION_MIN..=Self::DIRECTION_MAX).contains(&greatest)
            && !ray.t_min.is_nan()
            && !ray.t_max.is_nan();
        if !valid {
            return None;
        }
        let least = greatest * Self::CLAMP;
        Some(Self {
            origin: ray.origin,
            direction: ray.direction,
            t_min: max(ray.t_min, 0.0),
            t_max: min(ray.t_max, f32::MAX),
            inv: Vec3::new(
                1.0 / clamp(d.x, least),
                1.0 / clamp(d.y, least),
                1.0 / clamp(d.z, least),
            ),
            shear: [x / z, y / z, 1.0 / z],
            axis,
            signs: Self::signs(d),
        })
    }

    /// The [axis](Self#structfield.axis) of a direction. Of one with a NaN, any.
    #[inline(always)]
    #[must_use]
    pub(crate) fn axis(direction: Vec3) -> u8 {
        let a = direction.abs();
        // Without branches: no one foresees the axes of rays that go anywhere.
        let (is_x, is_y) = ((a.x >= a.y) & (a.x >= a.z), a.y >= a.z);
        u8::from(!is_x) << u8::from(!is_y)
    }

    /// The [signs](Self#structfield.signs) of a direction.
    #[inline(always)]
    #[must_use]
    pub(crate) fn signs(direction: Vec3) -> u8 {
        sign(direction.x) | sign(direction.y) << 1 | sign(direction.z) << 2
    }

    /// A ray that hits nothing.
    pub const NONE: Self = Self {
        origin: Vec3::ZERO,
        direction: Vec3::Z,
        t_min: f32::INFINITY,
        t_max: f32::NEG_INFINITY,
        inv: Vec3::ONE,
        shear: [0.0, 0.0, 1.0],
        axis: 2,
        signs: 0,
    };

    /// Whether it can hit nothing at all.
    #[inline(always)]
    #[must_use]
    pub fn is_none(&self) -> bool {
        self.t_min > self.t_max
    }

    /// Step 3: the interval of `t` in which the ray is in a primitive's padded own box, or `None`
    /// if it misses it.
    ///
    /// Order of operations, per axis: `l = lo - o`, `h = hi - o`; `R` the greatest of all six
    /// magnitudes; `p = R * 16u`; `t0 = (l - p) * inv`, `t1 = (h + p) * inv`, exchanged if
    /// `inv < 0`; `enter = max(max(t0x, t0y), t0z)`, `leave = min(min(t1x, t1y), t1z)`. (With finite
    /// input none of them is NaN, and which zero comes out does not matter: step 4 ends with `+ 0`.)
    #[inline(always)]
    #[must_use]
    pub fn own_box(&self, own: &Aabb) -> Option<Interval> {
        let l = own.min - self.origin;
        let h = own.max - self.origin;
        let far_x = max(l.x.abs(), h.x.abs());
        let far_y = max(l.y.abs(), h.y.abs());
        let far_z = max(l.z.abs(), h.z.abs());
        let pad = max(max(far_x, far_y), far_z) * Self::PAD;
        let (x0, x1) = slab(l.x, h.x, pad, self.inv.x);
        let (y0, y1) = slab(l.y, h.y, pad, self.inv.y);
        let (z0, z1) = slab(l.z, h.z, pad, self.inv.z);
        let enter = max(max(x0, y0), z0);
        let leave = min(min(x1, y1), z1);
        (enter <= leave).then_some(Interval { enter, leave })
    }

    /// Step 4: `t`, clamped to the interval of the own box, if the ray accepts it.
    ///
    /// `t' = min(leave, max(enter, t)) + 0`, by the [rule](super::rounding::max) that keeps a NaN in `t`, which then
    /// fails; the sum turns `-0` into `+0`. Accepted if `t_min <= t' <= t_max`.
    #[inline(always)]
    #[must_use]
    pub fn accept(&self, t: f32, own: Interval) -> Option<f32> {
        let t = min(own.leave, max(own.enter, t)) + 0.0;
        (self.t_min <= t && t <= self.t_max).then_some(t)
    }

    /// A vector's components along `kx`, `ky`, `kz`.
    #[inline(always)]
    #[must_use]
    pub fn permuted(&self, v: Vec3) -> (f32, f32, f32) {
        permute(v, self.axis)
    }
}

/// Where a ray is in a box.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Interval {
    /// `t` at which it enters; below zero if the origin is in the box.
    pub enter: f32,
    /// `t` at which it leaves.
    pub leave: f32,
}

/// The components along the axes that follow `axis` in the cycle x, y, z, and along `axis`.
#[inline(always)]
fn permute(v: Vec3, axis: u8) -> (f32, f32, f32) {
    match axis {
        0 => (v.y, v.z, v.x),
        1 => (v.z, v.x, v.y),
        _ => (v.x, v.y, v.z),
    }
}

/// One of two, whatever decides, in the same time.
#[inline(always)]
fn select(first: bool, a: f32, b: f32) -> f32 {
    let mask = u32::from(first).wrapping_neg();
    f32::from_bits(a.to_bits() & mask | b.to_bits() & !mask)
}

/// The sign bit.
#[inline(always)]
fn sign(x: f32) -> u8 {
    (x.to_bits() >> 31) as u8
}

#[inline(always)]
fn clamp(d: f32, least: f32) -> f32 {
    if d.abs() < least { least.copysign(d) } else { d }
}

#[inline(always)]
fn slab(l: f32, h: f32, pad: f32, inv: f32) -> (f32, f32) {
    let t0 = (l - pad) * inv;
    let t1 = (h + pad) * inv;
    if inv < 0.0 { (t1, t0) } else { (t0, t1) }
}
