//! A bundle against eight boxes, eight rays against a box or a triangle.

#[allow(clippy::wildcard_imports, reason = "a kernel names a hundred instructions")]
use core::arch::x86_64::*;

use kiloray_core::block::format::Node;
use kiloray_core::geometry::{DET_MAX, DET_MIN, DET_PART, PreparedRay};
use kiloray_core::trace::{BeamFrame, Corners, Crossings, Group, Planes, Row, Sides, Verdict};

/// `Lanes::beam`.
///
/// # Safety
/// The machine has AVX2 and FMA.
#[inline(always)]
pub(super) unsafe fn beam(
    beam: &BeamFrame,
    node: &Node,
    t_min: f32,
    t_max: f32,
    planes: &mut Planes,
) -> u32 {
    // SAFETY: by the caller; loads and stores are of whole rows.
    unsafe {
        let mut enter = _mm256_set1_ps(t_min);
        let mut leave = _mm256_set1_ps(t_max);
        let bounds = |q: &[u16; 8]| {
            _mm256_cvtepi32_ps(_mm256_cvtepu16_epi32(_mm_loadu_si128(q.as_ptr().cast())))
        };
        let [low, high] = &beam.inv;
        for axis in 0..3 {
            let negative = low[axis] < 0.0;
            let lo = node.lo[axis].as_ptr();
            let hi = node.hi[axis].as_ptr();
            let (first, last) = if negative { (hi, lo) } else { (lo, hi) };
            let (first, last) = (bounds(&*first.cast()), bounds(&*last.cast()));
            let scale = _mm256_set1_ps(beam.scale[axis]);
            let origin = _mm256_set1_ps(beam.origin[axis]);
            let (low, high) = (_mm256_set1_ps(low[axis]), _mm256_set1_ps(high[axis]));
            store(&mut planes.near[axis], _mm256_fmadd_ps(first, scale, origin));
            store(&mut planes.far[axis], _mm256_fmadd_ps(last, scale, origin));
            let first = _mm256_fmadd_ps(first, scale, _mm256_set1_ps(beam.near[axis]));
            let last = _mm256_fmadd_ps(last, scale, _mm256_set1_ps(beam.far[axis]));
            let t0 = _mm256_min_ps(_mm256_mul_ps(first, low), _mm256_mul_ps(first, high));
            let t1 = _mm256_max_ps(_mm256_mul_ps(last, low), _mm256_mul_ps(last, high));
            enter = _mm256_max_ps(enter, t0);
            leave = _mm256_min_ps(leave, t1);
        }
        store(&mut planes.enter, enter);
        _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LE_OQ>(enter, leave)) as u32
    }
}

/// `Lanes::meets`.
///
/// # Safety
/// The machine has AVX2 and FMA.
#[inline(always)]
pub(super) unsafe fn meets(group: &Group, sides: &Sides) -> u32 {
    // SAFETY: by the caller; loads are of whole rows.
    unsafe {
        let at = |axis: usize, plane: f32, row: &Row| {
            _mm256_fmadd_ps(_mm256_set1_ps(plane), load(&group.inv[axis]), load(row))
        };
        let near = |axis: usize| at(axis, sides.near[axis], &group.near[axis]);
        let far = |axis: usize| at(axis, sides.far[axis], &group.far[axis]);
        let enter = _mm256_max_ps(
            _mm256_max_ps(near(0), near(1)),
            _mm256_max_ps(near(2), load(&group.t_min)),
        );
        let leave =
            _mm256_min_ps(_mm256_min_ps(far(0), far(1)), _mm256_min_ps(far(2), load(&group.t_max)));
        _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LE_OQ>(enter, leave)) as u32
    }
}

/// `Lanes::triangle`: the operations of `PreparedRay::triangle`, one by one.
///
/// # Safety
/// The machine has AVX2 and FMA.
#[inline(always)]
pub(super) unsafe fn triangle(group: &Group, corners: &Corners, out: &mut Crossings) -> Verdict {
    // SAFETY: by the caller; loads and stores are of whole rows.
    unsafe {
        let set = |x: f32| _mm256_set1_ps(x);
        let sign = set(-0.0);
        let magnitude = |x: __m256| _mm256_andnot_ps(sign, x);
        let zero = _mm256_setzero_ps();
        let [ox, oy, oz] = &group.sheared;
        let [sx, sy, sz] = &group.shear;
        let (sx, sy) = (load(sx), load(sy));
        // Step 1; `z` is not yet multiplied.
        let sheared = |v: &[f32; 3]| {
            let z = _mm256_sub_ps(set(v[2]), load(oz));
            let x = _mm256_sub_ps(_mm256_sub_ps(set(v[0]), load(ox)), _mm256_mul_ps(sx, z));
            let y = _mm256_sub_ps(_mm256_sub_ps(set(v[1]), load(oy)), _mm256_mul_ps(sy, z));
            (x, y, z)
        };
        let [v0, v1, v2] = &corners.sheared;
        let ((x0, y0, z0), (x1, y1, z1), (x2, y2, z2)) = (sheared(v0), sheared(v1), sheared(v2));
        // Step 2.
        let u = _mm256_sub_ps(_mm256_mul_ps(x2, y1), _mm256_mul_ps(y2, x1));
        let v = _mm256_sub_ps(_mm256_mul_ps(x0, y2), _mm256_mul_ps(y0, x2));
        let w = _mm256_sub_ps(_mm256_mul_ps(x1, y0), _mm256_mul_ps(y1, x0));
        // A NaN is neither: `min` and `max` give one of the three numbers or a NaN.
        let least = _mm256_min_ps(_mm256_min_ps(u, v), w);
        let greatest = _mm256_max_ps(_mm256_max_ps(u, v), w);
        let opposite = _mm256_and_ps(
            _mm256_cmp_ps::<_CMP_LT_OQ>(least, zero),
            _mm256_cmp_ps::<_CMP_GT_OQ>(greatest, zero),
        );
        let crossing = !(_mm256_movemask_ps(opposite) as u32) & 0xff;
        if crossing == 0 {
            return Verdict { accepted: 0, doubtful: 0 };
        }
        let det = _mm256_add_ps(_mm256_add_ps(u, v), w);
        let size = magnitude(det);
        let widest =
            |a, b, c| _mm256_max_ps(_mm256_max_ps(magnitude(a), magnitude(b)), magnitude(c));
        let part =
            _mm256_mul_ps(_mm256_mul_ps(widest(x0, x1, x2), widest(y0, y1, y2)), set(DET_PART));
        let any_zero = _mm256_or_ps(
            _mm256_or_ps(
                _mm256_cmp_ps::<_CMP_EQ_UQ>(u, zero),
                _mm256_cmp_ps::<_CMP_EQ_UQ>(v, zero),
            ),
            _mm256_cmp_ps::<_CMP_EQ_UQ>(w, zero),
        );
        let in_range = _mm256_and_ps(
            _mm256_cmp_ps::<_CMP_GE_OQ>(size, part),
            _mm256_and_ps(
                _mm256_cmp_ps::<_CMP_GE_OQ>(size, set(DET_MIN)),
                _mm256_cmp_ps::<_CMP_LE_OQ>(size, set(DET_MAX)),
            ),
        );
        let sound = _mm256_movemask_ps(_mm256_andnot_ps(any_zero, in_range)) as u32;
        // Step 3.
        let r = _mm256_div_ps(set(1.0), det);
        let (b0, b1, b2) = (_mm256_mul_ps(u, r), _mm256_mul_ps(v, r), _mm256_mul_ps(w, r));
        let sz = load(sz);
        let z = |z: __m256| _mm256_mul_ps(sz, z);
        let t = _mm256_add_ps(
            _mm256_add_ps(_mm256_mul_ps(b0, z(z0)), _mm256_mul_ps(b1, z(z1))),
            _mm256_mul_ps(b2, z(z2)),
        );
        // Step 5.
        let (min, max) = (corners.own.min.to_array(), corners.own.max.to_array());
        let low = |axis: usize| _mm256_sub_ps(set(min[axis]), load(&group.origin[axis]));
        let high = |axis: usize| _mm256_sub_ps(set(max[axis]), load(&group.origin[axis]));
        let ends = [(low(0), high(0)), (low(1), high(1)), (low(2), high(2))];
        // Not `map`: compiled for any machine, it is no part of this function unless it is inlined, and passes vectors in memory.
        let far = |(l, h): (__m256, __m256)| _mm256_max_ps(magnitude(l), magnitude(h));
        let pad = _mm256_max_ps(_mm256_max_ps(far(ends[0]), far(ends[1])), far(ends[2]));
        let pad = _mm256_mul_ps(pad, set(PreparedRay::PAD));
        let slab = |axis: usize, (l, h): (__m256, __m256)| {
            let inv = load(&group.inv[axis]);
            let t0 = _mm256_mul_ps(_mm256_sub_ps(l, pad), inv);
            let t1 = _mm256_mul_ps(_mm256_add_ps(h, pad), inv);
            (_mm256_blendv_ps(t0, t1, inv), _mm256_blendv_ps(t1, t0, inv))
        };
        let ((x0, x1), (y0, y1), (z0, z1)) = (slab(0, ends[0]), slab(1, ends[1]), slab(2, ends[2]));
        let enter = _mm256_max_ps(_mm256_max_ps(x0, y0), z0);
        let leave = _mm256_min_ps(_mm256_min_ps(x1, y1), z1);
        // Step 4 of a hit.
        let t = _mm256_add_ps(_mm256_min_ps(leave, _mm256_max_ps(enter, t)), zero);
        let within = _mm256_and_ps(
            _mm256_cmp_ps::<_CMP_LE_OQ>(enter, leave),
            _mm256_and_ps(
                _mm256_cmp_ps::<_CMP_LE_OQ>(load(&group.t_min), t),
                _mm256_cmp_ps::<_CMP_LE_OQ>(t, load(&group.t_max)),
            ),
        );
        store(&mut out.t, t);
        store(&mut out.b1, b1);
        store(&mut out.b2, b2);
        Verdict {
            accepted: crossing & sound & _mm256_movemask_ps(within) as u32,
            doubtful: crossing & !sound,
        }
    }
}

/// # Safety
/// The machine has AVX2.
#[inline(always)]
unsafe fn load(row: &Row) -> __m256 {
    // SAFETY: by the caller; a row is eight numbers.
    unsafe { _mm256_loadu_ps(row.as_ptr()) }
}

/// # Safety
/// The machine has AVX2.
#[inline(always)]
unsafe fn store(row: &mut Row, value: __m256) {
    // SAFETY: by the caller; a row is eight numbers.
    unsafe { _mm256_storeu_ps(row.as_mut_ptr(), value) }
}
