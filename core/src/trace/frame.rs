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
/// `R_b >= R` the greatest distance from the ray's origin to any coordinate of the block's frame (own boxes lie in
/// the frame).
///
/// - The own box: `t0 = fl(fl(fl(lo - o) - p) * inv)` with `p = 16 u R (1 + u)`. Three roundings, each of
///   a value below `(1 + 20 u) R` (times `inv`), so `t0 >= (lo - o - 19.1 u R) * inv`.
/// - The slot: the frame gives `lo >= origin + scale * q` exactly. `fl(o - origin)` errs by `u R_b`; the division by
///   `scale` and the product `inv * scale` are by a power of two, and exact. Adding the pad, multiplying by `inv`
///   and the sum at the end (fused or, with the product rounded, not) err by `u R_b` each, the latter twice. So the slot's
///   `t <= (lo - o + 5.1 u R_b - e) * inv`, where `e = 32 u R_b (1 - 4 u)` is the pad.
/// - `e > (19.1 + 5.1) u R_b`. What is left, `7 u R_b >= 2⁻⁵ scale`, also pays for results below the least normal
///   number, since `|inv * scale| >= 2⁻¹⁰⁰`.
///
/// The bounds of a node lie in those of its parent's slot, so the same holds for every ancestor: in one block by
/// the same frame, in another since the claim needs no more than that the own box lies in the slot's box.
///
/// An axis whose numbers would leave the range where this holds gets `inv = 0, near = -∞, far = ∞`: it decides nothing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BoxFrame {
    /// `1 / d`, per step.
    pub inv: [f32; 3],
    /// To be added for the bound that the ray meets first: the lower one where `inv` is not negative.
    pub near: [f32; 3],
    /// To be added for the other bound.
    pub far: [f32; 3],
}

/// `32 u`: see [`BoxFrame`].
const PAD: f32 = 32.0 * UNIT_ROUNDOFF;
/// `inv` per step is used between 2⁻¹⁰⁰ and 2¹⁰⁰.
const INV_MAX: f32 = (1_u128 << 100) as f32;
const INV_MIN: f32 = 1.0 / INV_MAX;

impl BoxFrame {
    /// The ray in the frame of the block with this header.
    #[inline(always)]
    #[must_use]
    pub fn new(ray: &PreparedRay, header: &BlockHeader) -> Self {
        let o = ray.origin.to_array();
        let d = [0, 1, 2].map(|a| at(&o, a) - at(&header.origin, a));
        let reach = [0, 1, 2].map(|a| at(&d, a).abs() + 65536.0 * at(&header.scale, a));
        let [rx, ry, rz] = reach;
        let pad = max(max(rx, ry), rz) * PAD;
        let axes = [0, 1, 2].map(|a| {
            let scale = at(&header.scale, a);
            axis(at(&d, a), pad, scale, at(&ray.inv.to_array(), a))
        });
        let [x, y, z] = axes;
        Self { inv: [x.0, y.0, z.0], near: [x.1, y.1, z.1], far: [x.2, y.2, z.2] }
    }
}

#[inline(always)]
fn axis(d: f32, pad: f32, scale: f32, inv: f32) -> (f32, f32, f32) {
    // The exact reciprocal of a power of two.
    let steps = f32::from_bits(0x7f00_0000_u32.wrapping_sub(scale.to_bits()));
    let origin = d * steps;
    let pad = (pad * steps).copysign(inv);
    let inv = inv * scale;
    let near = -(origin + pad) * inv;
    let far = (pad - origin) * inv;
    let usable = inv.abs() >= INV_MIN && inv.abs() <= INV_MAX && near.abs() + far.abs() < f32::MAX;
    if usable { (inv, near, far) } else { (0.0, f32::NEG_INFINITY, f32::INFINITY) }
}

#[inline(always)]
fn at(v: &[f32; 3], axis: usize) -> f32 {
    match axis {
        0 => v[0],
        1 => v[1],
        _ => v[2],
    }
}
