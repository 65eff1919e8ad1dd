//! A ray against the eight boxes of a node.

#[allow(clippy::wildcard_imports, reason = "a kernel names a hundred instructions")]
use core::arch::x86_64::*;

use kiloray_core::block::ExpandedNode;
use kiloray_core::block::format::Node;

use super::frame::{Frame, Sides, Spread};
use super::in_place;

/// Where a ray enters and leaves eight boxes, by slot: it meets those that it enters no later than it leaves them.
#[derive(Debug, Clone, Copy)]
pub struct Hits {
    pub(super) enter: __m256,
    pub(super) leave: __m256,
}

/// The boxes of a node in a block.
///
/// # Safety
/// The machine has AVX2 and FMA.
#[inline(always)]
pub(super) unsafe fn stored(frame: &Frame, node: &Node, span: (f32, f32)) -> Hits {
    let bytes = core::ptr::from_ref(node).cast::<u8>();
    let frame = in_place(frame);
    let Sides { first: [fx, fy, fz], last: [lx, ly, lz] } = *frame.sides;
    // SAFETY: by the caller. Sides are those of a table: sixteen bytes from there lie in the 96 bytes of bounds.
    unsafe {
        let bounds = |offset: usize| {
            let q = _mm_loadu_si128(bytes.add(offset).cast());
            _mm256_cvtepi32_ps(_mm256_cvtepu16_epi32(q))
        };
        let first = [bounds(fx), bounds(fy), bounds(fz)];
        let last = [bounds(lx), bounds(ly), bounds(lz)];
        hits(&Spread::of(frame), first, last, span)
    }
}

/// The boxes of a node of the top.
///
/// # Safety
/// The machine has AVX2 and FMA.
#[inline(always)]
pub(super) unsafe fn expanded(frame: &Spread, node: &ExpandedNode, span: (f32, f32)) -> Hits {
    let bytes = core::ptr::from_ref(node).cast::<u8>();
    let Sides { first: [fx, fy, fz], last: [lx, ly, lz] } = *frame.sides;
    // SAFETY: as above; bounds are twice as long: 32 bytes from twice those offsets lie in their 192, and are aligned as the
    // node is.
    unsafe {
        let bounds = |offset: usize| _mm256_load_ps(bytes.add(2 * offset).cast());
        let first = [bounds(fx), bounds(fy), bounds(fz)];
        let last = [bounds(lx), bounds(ly), bounds(lz)];
        hits(frame, first, last, span)
    }
}

/// Of bounds in the order in which the ray meets them, by axis.
///
/// # Safety
/// The machine has AVX2 and FMA.
#[inline(always)]
unsafe fn hits(
    &Spread { inv: [ix, iy, iz], near, far, .. }: &Spread,
    [x0, y0, z0]: [__m256; 3],
    [x1, y1, z1]: [__m256; 3],
    (t_min, t_max): (f32, f32),
) -> Hits {
    // SAFETY: by the caller.
    unsafe {
        let x0 = _mm256_fmadd_ps(x0, ix, near[0]);
        let y0 = _mm256_fmadd_ps(y0, iy, near[1]);
        let z0 = _mm256_fmadd_ps(z0, iz, near[2]);
        let x1 = _mm256_fmadd_ps(x1, ix, far[0]);
        let y1 = _mm256_fmadd_ps(y1, iy, far[1]);
        let z1 = _mm256_fmadd_ps(z1, iz, far[2]);
        let (t_min, t_max) = (_mm256_set1_ps(t_min), _mm256_set1_ps(t_max));
        // `t_min` is not negative, so `enter` is right. A box that is left at a negative `t` is not met, or needlessly where -0 stands for it.
        Hits {
            enter: greater(greater(x0, y0), greater(z0, t_min)),
            leave: lesser(lesser(x1, y1), lesser(z1, t_max)),
        }
    }
}

/// The greater of each two, as whole numbers: in one cycle, where floats take four. Their order is that of numbers that are not negative; any other is
/// less than these. So the greatest of several is right if one of them is not negative.
///
/// # Safety
/// The machine has AVX2.
#[inline(always)]
pub(super) unsafe fn greater(a: __m256, b: __m256) -> __m256 {
    // SAFETY: by the caller.
    unsafe {
        let whole = |x: __m256| _mm256_castps_si256(x);
        _mm256_castsi256_ps(_mm256_max_epi32(whole(a), whole(b)))
    }
}

/// The lesser of each two, as above. The least of several is right if none is negative, or else is one of those that are, perhaps -0.
///
/// # Safety
/// The machine has AVX2.
#[inline(always)]
pub(super) unsafe fn lesser(a: __m256, b: __m256) -> __m256 {
    // SAFETY: by the caller.
    unsafe {
        let whole = |x: __m256| _mm256_castps_si256(x);
        _mm256_castsi256_ps(_mm256_min_epi32(whole(a), whole(b)))
    }
}
