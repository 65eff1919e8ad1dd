//! Rays in groups: a list of them against eight boxes, one of them against the triangles of a record, eight against a triangle.

#[allow(clippy::wildcard_imports, reason = "a kernel names a hundred instructions")]
use core::arch::x86_64::*;

use super::boxes::{greater, lesser};
use kiloray_core::geometry::{DET_MAX, DET_MIN, DET_PART, PreparedRay, Ray};
use kiloray_core::trace::{
    Beam, BoxRay, Crossings, Filled, GROUP, Group, Kind, Octet, Quad, Row, Verdict,
};

/// `Lanes::kind`.
///
/// # Safety
/// The machine has AVX2.
#[inline(always)]
pub(super) unsafe fn kind(ray: &Ray) -> Kind {
    const { assert!(size_of::<Ray>() == 32) };
    // SAFETY: by the caller. A ray is eight numbers; its direction are those from the third on, and one behind them.
    unsafe {
        let direction = _mm_loadu_ps(core::ptr::from_ref(ray).cast::<f32>().add(3));
        let size = _mm_andnot_ps(_mm_set1_ps(-0.0), direction);
        // The least axis among equals.
        let no_less = |others: __m128| _mm_cmp_ps::<_CMP_GE_OQ>(size, others);
        let yzx = no_less(_mm_shuffle_ps::<0b11_00_10_01>(size, size));
        let zxy = no_less(_mm_shuffle_ps::<0b11_01_00_10>(size, size));
        let axis = _mm_movemask_ps(_mm_and_ps(yzx, zxy)).trailing_zeros() as u8;
        Kind::new(_mm_movemask_ps(direction) as u8 & 7, axis)
    }
}

/// `Lanes::fill`: the operations of `PreparedRay::of` and `BoxRay::new`, for eight rays at a time.
///
/// It has AVX2 itself, and so have its closures. (Those of a function that is only inlined into one with AVX2 have not: they would call each instruction.)
#[target_feature(enable = "avx2")]
#[inline]
pub(super) fn fill(rays: &[Ray], members: &[u16], kind: Kind, to: &mut Group) -> Filled {
    /// No ray: it accepts no `t`.
    static NONE: [f32; 8] = [0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 1.0, -1.0];
    let at = |lane: usize| {
        let ray = members.get(lane).and_then(|&i| rays.get(usize::from(i)));
        let numbers = ray.map_or(NONE.as_ptr(), |ray| core::ptr::from_ref(ray).cast());
        // SAFETY: a ray is eight numbers, and so is `NONE`.
        unsafe { _mm256_loadu_ps(numbers) }
    };
    let rows = transposed([at(0), at(1), at(2), at(3), at(4), at(5), at(6), at(7)]);
    let [ox, oy, oz, dx, dy, dz, t_min, t_max] = rows;
    let set = |x: f32| _mm256_set1_ps(x);
    let sign = set(-0.0);
    let size = |v: __m256| _mm256_andnot_ps(sign, v);
    let and = |a: __m256, b: __m256| _mm256_and_ps(a, b);
    let no_more = |a: __m256, b: __m256| _mm256_cmp_ps::<_CMP_LE_OQ>(a, b);
    let (along_x, along_y, along_z) = match kind.axis() {
        0 => (dy, dz, dx),
        1 => (dz, dx, dy),
        _ => (dx, dy, dz),
    };
    let sheared = match kind.axis() {
        0 => [oy, oz, ox],
        1 => [oz, ox, oy],
        _ => [ox, oy, oz],
    };
    let greatest = size(along_z);
    let origin = _mm256_max_ps(_mm256_max_ps(size(ox), size(oy)), size(oz));
    // A sum is NaN or infinite if any of them is. (Finite origins may add up to infinity: such a ray gets no box anyway.)
    let finite = |a: __m256, b: __m256, c: __m256| {
        let most = set(f32::MAX);
        and(and(no_more(size(a), most), no_more(size(b), most)), no_more(size(c), most))
    };
    // Before the bounds are cut: that would make numbers of NaN.
    let ordered = _mm256_cmp_ps::<_CMP_ORD_Q>(t_min, t_max);
    let t_min = _mm256_max_ps(t_min, _mm256_setzero_ps());
    let t_max = _mm256_min_ps(t_max, set(f32::MAX));
    let valid = and(
        and(ordered, and(finite(ox, oy, oz), finite(dx, dy, dz))),
        and(
            and(
                no_more(set(PreparedRay::DIRECTION_MIN), greatest),
                no_more(greatest, set(PreparedRay::DIRECTION_MAX)),
            ),
            no_more(t_min, t_max),
        ),
    );
    let one = set(1.0);
    let shear = [
        _mm256_div_ps(along_x, along_z),
        _mm256_div_ps(along_y, along_z),
        _mm256_div_ps(one, along_z),
    ];
    let least = _mm256_mul_ps(greatest, set(PreparedRay::CLAMP));
    let inv = |d: __m256| {
        let raised = _mm256_or_ps(least, and(sign, d));
        let small = _mm256_cmp_ps::<_CMP_LT_OQ>(size(d), least);
        _mm256_div_ps(one, _mm256_blendv_ps(d, raised, small))
    };
    let inverse = size(shear[2]);
    let sound = and(
        no_more(origin, set(BoxRay::ORIGIN_MAX)),
        and(no_more(set(1.0 / BoxRay::INV_MAX), inverse), no_more(inverse, set(BoxRay::INV_MAX))),
    );
    let pad = _mm256_mul_ps(_mm256_add_ps(origin, set(1.01)), set(BoxRay::PAD));
    for (axis, (o, d)) in [(ox, dx), (oy, dy), (oz, dz)].into_iter().enumerate() {
        let inv = inv(d);
        let pad = _mm256_or_ps(pad, and(sign, inv));
        let near = _mm256_mul_ps(_mm256_add_ps(o, pad), _mm256_xor_ps(inv, sign));
        let far = _mm256_mul_ps(_mm256_sub_ps(pad, o), inv);
        // SAFETY: the machine has AVX2, as this function.
        unsafe {
            store(&mut to.inv[axis], inv);
            store(&mut to.near[axis], near);
            store(&mut to.far[axis], far);
            store(&mut to.sheared[axis], sheared[axis]);
            store(&mut to.shear[axis], shear[axis]);
            store(&mut to.origin[axis], o);
        }
    }
    let here = and(valid, sound);
    // SAFETY: as above.
    unsafe {
        store(&mut to.t_min, _mm256_blendv_ps(set(f32::INFINITY), t_min, here));
        store(&mut to.t_max, _mm256_blendv_ps(set(f32::NEG_INFINITY), t_max, here));
    }
    Filled {
        lanes: _mm256_movemask_ps(here) as u8,
        wild: _mm256_movemask_ps(_mm256_andnot_ps(sound, valid)) as u8,
    }
}

/// Rows of what were columns.
#[target_feature(enable = "avx2")]
#[inline]
fn transposed([a, b, c, d, e, f, g, h]: [__m256; 8]) -> [__m256; 8] {
    let pair = |a: __m256, b: __m256| {
        let low = _mm256_castps_pd(_mm256_unpacklo_ps(a, b));
        (low, _mm256_castps_pd(_mm256_unpackhi_ps(a, b)))
    };
    let ((ab0, ab2), (cd0, cd2), (ef0, ef2), (gh0, gh2)) =
        (pair(a, b), pair(c, d), pair(e, f), pair(g, h));
    let four = |ab: __m256d, cd: __m256d| {
        let low = _mm256_castpd_ps(_mm256_unpacklo_pd(ab, cd));
        (low, _mm256_castpd_ps(_mm256_unpackhi_pd(ab, cd)))
    };
    let ((a0, a1), (a2, a3)) = (four(ab0, cd0), four(ab2, cd2));
    let ((e0, e1), (e2, e3)) = (four(ef0, gh0), four(ef2, gh2));
    let low = |a: __m256, e: __m256| _mm256_permute2f128_ps::<0x20>(a, e);
    let high = |a: __m256, e: __m256| _mm256_permute2f128_ps::<0x31>(a, e);
    [
        low(a0, e0),
        low(a1, e1),
        low(a2, e2),
        low(a3, e3),
        high(a0, e0),
        high(a1, e1),
        high(a2, e2),
        high(a3, e3),
    ]
}

/// `Lanes::boxes`.
///
/// # Safety
/// The machine has AVX2 and FMA.
#[inline(always)]
pub(super) unsafe fn boxes(
    groups: &[Group],
    list: &[Octet],
    count: usize,
    (near, far): ([&Row; 3], [&Row; 3]),
    met: &mut [Octet],
) -> u8 {
    let [nx, ny, nz] = near;
    let [fx, fy, fz] = far;
    // SAFETY: by the caller; loads are of whole rows, of lanes of groups that are there, and of chunks that both lists have.
    unsafe {
        let (nx, ny, nz) = (load(nx), load(ny), load(nz));
        let (fx, fy, fz) = (load(fx), load(fy), load(fz));
        let mut all = 0_u64;
        let mut left = count;
        let chunks = count.div_ceil(GROUP).min(list.len()).min(met.len());
        for chunk in 0..chunks {
            let mut ids = u64::from_le_bytes(*list.get_unchecked(chunk));
            // One number, not eight: it is read as one.
            let mut masks = 0_u64;
            let here = left.min(GROUP);
            for k in 0..here {
                let (group, lane) = ((ids >> 3 & 31) as usize, (ids & 7) as usize);
                ids >>= 8;
                let Some(group) = groups.get(group) else { continue };
                let at = |row: &Row| _mm256_broadcast_ss(&*row.as_ptr().add(lane));
                let (ix, iy, iz) = (at(&group.inv[0]), at(&group.inv[1]), at(&group.inv[2]));
                let x0 = _mm256_fmadd_ps(nx, ix, at(&group.near[0]));
                let y0 = _mm256_fmadd_ps(ny, iy, at(&group.near[1]));
                let z0 = _mm256_fmadd_ps(nz, iz, at(&group.near[2]));
                let x1 = _mm256_fmadd_ps(fx, ix, at(&group.far[0]));
                let y1 = _mm256_fmadd_ps(fy, iy, at(&group.far[1]));
                let z1 = _mm256_fmadd_ps(fz, iz, at(&group.far[2]));
                let enter = greater(greater(x0, y0), greater(z0, at(&group.t_min)));
                let leave = lesser(lesser(x1, y1), lesser(z1, at(&group.t_max)));
                let mask = _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LE_OQ>(enter, leave)) as u64;
                masks |= mask << (8 * k);
            }
            left -= here;
            *met.get_unchecked_mut(chunk) = masks.to_le_bytes();
            all |= masks;
        }
        all |= all >> 32;
        all |= all >> 16;
        (all | all >> 8) as u8
    }
}

/// For each mask of eight lanes, where the first come from.
static FIRST: [Octet; 256] = first();

const fn first() -> [Octet; 256] {
    let mut table = [[0; 8]; 256];
    let mut mask = 0;
    while mask < 256 {
        let (mut to, mut place) = (0, 0);
        while place < 8 {
            if mask >> place & 1 == 1 {
                table[mask][to] = place as u8;
                to += 1;
            }
            place += 1;
        }
        mask += 1;
    }
    table
}

/// `Lanes::select`.
///
/// # Safety
/// The machine has AVX2.
#[inline(always)]
pub(super) unsafe fn select(
    list: &[Octet],
    met: &[Octet],
    count: usize,
    slot: usize,
    to: &mut [Octet],
) -> usize {
    let chunks = count.div_ceil(GROUP).min(to.len()).min(list.len()).min(met.len());
    let to = to.as_flattened_mut().as_mut_ptr();
    let mut end = 0;
    // SAFETY: by the caller.
    let to_sign = unsafe { _mm_cvtsi32_si128(7 - (slot as i32 & 7)) };
    for chunk in 0..chunks {
        // SAFETY: by the caller. All have so many chunks, and before this one no more was put down than was read: eight bytes fit in.
        unsafe {
            // The slot's bit of each byte, as its sign. Behind the list no bit is set.
            let met = _mm_loadl_epi64(met.get_unchecked(chunk).as_ptr().cast());
            let here = _mm_movemask_epi8(_mm_sll_epi64(met, to_sign)) as u32;
            let ids = _mm_loadl_epi64(list.get_unchecked(chunk).as_ptr().cast());
            let from = _mm_loadl_epi64(FIRST[here as usize & 255].as_ptr().cast());
            _mm_storel_epi64(to.add(end).cast(), _mm_shuffle_epi8(ids, from));
            end += here.count_ones() as usize;
        }
    }
    end
}

/// `Lanes::beam`.
///
/// # Safety
/// The machine has AVX2 and FMA.
#[inline(always)]
pub(super) unsafe fn beam(beam: &Beam, (near, far): ([&Row; 3], [&Row; 3]), to: &mut Row) -> u8 {
    // SAFETY: by the caller; loads and the store are of whole rows.
    unsafe {
        let set = |x: f32| _mm256_set1_ps(x);
        let (mut enter, mut leave) = (set(beam.t_min), set(beam.t_max));
        for axis in 0..3 {
            let (low, high) = (set(beam.inv[0][axis]), set(beam.inv[1][axis]));
            let first = _mm256_sub_ps(load(near[axis]), set(beam.near[axis]));
            let last = _mm256_sub_ps(load(far[axis]), set(beam.far[axis]));
            let first = _mm256_min_ps(_mm256_mul_ps(first, low), _mm256_mul_ps(first, high));
            let last = _mm256_max_ps(_mm256_mul_ps(last, low), _mm256_mul_ps(last, high));
            enter = _mm256_max_ps(enter, first);
            leave = _mm256_min_ps(leave, last);
        }
        store(to, enter);
        _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LE_OQ>(enter, leave)) as u8
    }
}

/// `Lanes::meets`.
///
/// # Safety
/// The machine has AVX2 and FMA.
#[inline(always)]
pub(super) unsafe fn meets(group: &Group, (near, far): ([&Row; 3], [&Row; 3]), slot: usize) -> u8 {
    let slot = slot & 7;
    // SAFETY: by the caller; loads are of whole rows, and of one of eight slots.
    unsafe {
        let at = |axis: usize, planes: [&Row; 3], row: &Row| {
            let plane = _mm256_broadcast_ss(&*planes[axis].as_ptr().add(slot));
            _mm256_fmadd_ps(plane, load(&group.inv[axis]), load(row))
        };
        let first = |axis: usize| at(axis, near, &group.near[axis]);
        let last = |axis: usize| at(axis, far, &group.far[axis]);
        let enter = greater(greater(first(0), first(1)), greater(first(2), load(&group.t_min)));
        let leave = lesser(lesser(last(0), last(1)), lesser(last(2), load(&group.t_max)));
        _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LE_OQ>(enter, leave)) as u8
    }
}

/// `Lanes::triangle`: the operations of `PreparedRay::triangle`, one by one.
///
/// # Safety
/// The machine has AVX2 and FMA.
#[inline(always)]
pub(super) unsafe fn triangle(
    quad: &Quad,
    place: usize,
    group: &Group,
    kind: Kind,
    out: &mut Crossings,
) -> Verdict {
    let place = place & 3;
    // SAFETY: by the caller; loads and stores are of whole rows, and of places that are there.
    unsafe {
        let set = |x: f32| _mm256_set1_ps(x);
        let sign = set(-0.0);
        let magnitude = |x: __m256| _mm256_andnot_ps(sign, x);
        let zero = _mm256_setzero_ps();
        let [ox, oy, oz] = &group.origin;
        let (ox, oy, oz) = (load(ox), load(oy), load(oz));
        let from = |at: usize| {
            let from = |axis: usize, o: __m256| {
                let row = if at < 2 {
                    quad.v01[axis].as_ptr().add(4 * at)
                } else {
                    quad.v2[axis].as_ptr()
                };
                _mm256_sub_ps(_mm256_broadcast_ss(&*row.add(place)), o)
            };
            [from(0, ox), from(1, oy), from(2, oz)]
        };
        let (from0, from1, from2) = (from(0), from(1), from(2));
        let [sx, sy, sz] = &group.shear;
        let (sx, sy) = (load(sx), load(sy));
        // Step 1; `z` is not yet multiplied.
        let axis = kind.axis();
        let sheared = |[x, y, z]: [__m256; 3]| {
            let (x, y, z) = match axis {
                0 => (y, z, x),
                1 => (z, x, y),
                _ => (x, y, z),
            };
            let x = _mm256_sub_ps(x, _mm256_mul_ps(sx, z));
            let y = _mm256_sub_ps(y, _mm256_mul_ps(sy, z));
            (x, y, z)
        };
        let ((x0, y0, z0), (x1, y1, z1), (x2, y2, z2)) =
            (sheared(from0), sheared(from1), sheared(from2));
        // Step 2.
        let u = _mm256_sub_ps(_mm256_mul_ps(x2, y1), _mm256_mul_ps(y2, x1));
        let v = _mm256_sub_ps(_mm256_mul_ps(x0, y2), _mm256_mul_ps(y0, x2));
        let w = _mm256_sub_ps(_mm256_mul_ps(x1, y0), _mm256_mul_ps(y1, x0));
        // As in `record`.
        let least = lesser(lesser(u, v), w);
        let greatest = greater(greater(u, v), w);
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
        // Rounding is monotone: the least of the differences is the difference of the least.
        let low = |axis: usize| _mm256_min_ps(_mm256_min_ps(from0[axis], from1[axis]), from2[axis]);
        let high =
            |axis: usize| _mm256_max_ps(_mm256_max_ps(from0[axis], from1[axis]), from2[axis]);
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
