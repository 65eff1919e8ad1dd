use crate::block::format::BlockHeader;
use crate::geometry::PreparedRay;
use crate::geometry::rounding::{UNIT_ROUNDOFF, max};

/// A ray in the frame of a block: per axis, `t = q * inv + near` (or `far`) for a 16-bit bound `q`.
///
/// # Why no box test loses a hit
///
/// Claim: for every primitive in a slot, the slot's interval of `t` holds the interval of the primitive's
/// own box ([`PreparedRay::own_box`]). Take an axis with `inv > 0` and the lower bounds; the
/// other cases are mirror images. Let `u = 2⁻²⁴`, `R` the greatest distance of step 3 of the hit's definition and
/// `R_b >= R` the greatest magnitude of a coordinate of the ray's origin, and a little above 1: own boxes and the origins of
/// frames lie in the cube [-1, 1]³, a few ulp aside ([`BlockView::parse`](crate::block::BlockView::parse) checks it).
///
/// - The own box: `t0 = fl(fl(fl(lo - o) - p) * inv)` with `p = 16 u R (1 + u)`. Three roundings, each of
///   a value below `(1 + 20 u) R` (times `inv`), so `t0 >= (lo - o - 19.1 u R) * inv`.
/// - The slot: the frame gives `lo >= origin + scale * q` exactly, and `inv * scale` is exact, `scale` being a power of two.
///   `near = fl(fl(fl(o - origin) + P) * -inv)` errs by `u R_b` three times (times `inv`); the product and the sum that make
///   `t` of it err by `u R_b` once more if they are fused, twice if not. So the slot's
///   `t <= (lo - o + 5.1 u R_b - P) * inv`, where `P = 32 u R_b (1 - 4 u)` is the pad.
/// - `P > (19.1 + 5.1) u R_b`. What is left, `7 u R_b |inv| >= 2⁻⁴²`, also pays for results below the least normal number.
///
/// The bounds of a node lie in those of its parent's slot, so the same holds for every ancestor: in one block by
/// the same frame, in another since the claim needs no more than that the own box lies in the slot's box.
///
/// An [expanded node](crate::block::ExpandedNode) has a frame as well, with `origin = 0` and `scale = 1`: its bounds are the numbers
/// `origin + scale * q` themselves, which lie in the cube, and the steps above ask no more of them.
///
/// For the numbers to stay in the range where this holds, no coordinate of the ray's origin is above 2⁴⁰ and the greatest component of
/// its direction is between 2⁻²⁰ and 2²⁰ (then `|inv|` is between 2⁻²⁰ and 2⁸⁰, and `scale` between 2⁻⁸⁰ and 2). Any other ray gets
/// an infinite pad, and `inv = ±1`: no box decides anything.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BoxFrame {
    /// `1 / d`, per step.
    pub inv: [f32; 3],
    /// To be added for the bound that the ray meets first: the lower one where `inv` is not negative.
    pub near: [f32; 3],
    /// To be added for the other bound.
    pub far: [f32; 3],
}

/// What box tests need of a ray.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BoxRay {
    /// Its origin.
    pub origin: [f32; 3],
    /// `1 / d`.
    pub inv: [f32; 3],
    /// The pad `P` of [`BoxFrame`].
    pub pad: f32,
}

impl BoxRay {
    /// Greatest magnitude of a coordinate of the origin, for boxes to decide anything.
    pub const ORIGIN_MAX: f32 = (1_u64 << 40) as f32;
    /// Greatest magnitude of the inverse of the direction's greatest component, and inverse of the least.
    pub const INV_MAX: f32 = (1 << 20) as f32;
    /// The pad is this part of the greatest magnitude of a coordinate and a little above 1.
    pub const PAD: f32 = 32.0 * UNIT_ROUNDOFF;

    /// What box tests need of this ray.
    #[inline(always)]
    #[must_use]
    pub fn new(ray: &PreparedRay) -> Self {
        let (ox, oy, oz) = (ray.origin.x.abs(), ray.origin.y.abs(), ray.origin.z.abs());
        if let Some(pad) = Self::pad(max(max(ox, oy), oz), ray.shear[2].abs()) {
            return Self { origin: ray.origin.to_array(), inv: ray.inv.to_array(), pad };
        }
        let inv = ray.inv;
        let signs = [1.0_f32.copysign(inv.x), 1.0_f32.copysign(inv.y), 1.0_f32.copysign(inv.z)];
        Self { origin: [0.0; 3], inv: signs, pad: f32::INFINITY }
    }

    /// The pad of a ray whose origin has this greatest magnitude of a coordinate, and the inverse of whose direction has this least; `None`: no box
    /// decides anything for it.
    #[inline(always)]
    #[must_use]
    pub fn pad(greatest: f32, least: f32) -> Option<f32> {
        let sound =
            greatest <= Self::ORIGIN_MAX && (1.0 / Self::INV_MAX..=Self::INV_MAX).contains(&least);
        sound.then(|| Self::sound_pad(greatest))
    }

    /// The same, where boxes are known to decide.
    #[inline(always)]
    #[must_use]
    pub const fn sound_pad(greatest: f32) -> f32 {
        (greatest + 1.01) * Self::PAD
    }
}

impl BoxFrame {
    /// The ray in the frame of the block with this header.
    #[inline(always)]
    #[must_use]
    pub fn new(ray: &BoxRay, header: &BlockHeader) -> Self {
        let axis = |o: f32, origin: f32, scale: f32, inv: f32| {
            let d = o - origin;
            let pad = ray.pad.copysign(inv);
            (inv * scale, (d + pad) * -inv, (pad - d) * inv)
        };
        let ([px, py, pz], [ox, oy, oz]) = (ray.origin, header.origin);
        let ([dx, dy, dz], [sx, sy, sz]) = (ray.inv, header.scale);
        let (ix, nx, fx) = axis(px, ox, sx, dx);
        let (iy, ny, fy) = axis(py, oy, sy, dy);
        let (iz, nz, fz) = axis(pz, oz, sz, dz);
        Self { inv: [ix, iy, iz], near: [nx, ny, nz], far: [fx, fy, fz] }
    }
}
