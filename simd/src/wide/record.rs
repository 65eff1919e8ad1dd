//! A ray against the four triangles of a record.

#[allow(clippy::wildcard_imports, reason = "a kernel names a hundred instructions")]
use core::arch::x86_64::*;

use kiloray_core::block::format::Record;
use kiloray_core::geometry::{DET_MAX, DET_MIN, DET_PART, PreparedRay};
use kiloray_core::trace::{Crossings, Verdict};

/// A ray along the axes `kx, ky, kz`.
#[derive(Debug, Clone, Copy)]
pub(super) struct Along {
    origin: [f32; 4],
    shear: [f32; 3],
    inv: [f32; 4],
    t_min: f32,
    /// Takes the components x, y, z to the places of `kx, ky, kz`, twice.
    permute: &'static [i32; 8],
}

/// By `kz`: see [`Along::permute`].
static PERMUTES: [[i32; 8]; 3] =
    [[1, 2, 0, 3, 1, 2, 0, 3], [2, 0, 1, 3, 2, 0, 1, 3], [0, 1, 2, 3, 0, 1, 2, 3]];

impl Along {
    #[inline(always)]
    pub(super) fn new(ray: &PreparedRay) -> Self {
        let permute = &PERMUTES[usize::from(ray.axis.min(2))];
        let mut along =
            Self { origin: [0.0; 4], shear: ray.shear, inv: [0.0; 4], t_min: ray.t_min, permute };
        let ([ox, oy, oz], [ix, iy, iz]) = (ray.origin.to_array(), ray.inv.to_array());
        // SAFETY: only called with a value of Avx2 at hand; loads and stores are of whole arrays.
        unsafe {
            let permute = _mm_loadu_si128(permute.as_ptr().cast());
            let origin = _mm_permutevar_ps(_mm_setr_ps(ox, oy, oz, 0.0), permute);
            let inv = _mm_permutevar_ps(_mm_setr_ps(ix, iy, iz, 0.0), permute);
            _mm_storeu_ps(along.origin.as_mut_ptr(), origin);
            _mm_storeu_ps(along.inv.as_mut_ptr(), inv);
        }
        along
    }
}

/// `Lanes::record`: the operations of `PreparedRay::triangle`, one by one. A function of its own, so that the
/// loop over nodes keeps its registers.
#[inline(never)]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
pub(super) fn record(
    ray: &Along,
    words: &[f32],
    record: &Record,
    t_max: f32,
    out: &mut Crossings,
) -> Verdict {
    // SAFETY: the machine has AVX2.
    let Some(Corners { ab, c, used }) = (unsafe { gather(ray, words, record) }) else {
        return Verdict { accepted: 0, doubtful: 0b1111 };
    };
    let set = |x: f32| _mm_set1_ps(x);
    let low = |v: __m256| _mm256_castps256_ps128(v);
    let high = |v: __m256| _mm256_extractf128_ps::<1>(v);
    let zero = _mm_setzero_ps();
    let wide = |x: f32| _mm256_set1_ps(x);
    let (ox, oy, oz) = (wide(ray.origin[0]), wide(ray.origin[1]), wide(ray.origin[2]));
    let (sx, sy) = (wide(ray.shear[0]), wide(ray.shear[1]));
    // Step 1 of the definition for vertices 0 and 1 (low and high half), and for vertex 2; `z` is not yet multiplied.
    let (abx, aby, abz) =
        (_mm256_sub_ps(ab[0], ox), _mm256_sub_ps(ab[1], oy), _mm256_sub_ps(ab[2], oz));
    let (cx, cy, cz) =
        (_mm_sub_ps(c[0], low(ox)), _mm_sub_ps(c[1], low(oy)), _mm_sub_ps(c[2], low(oz)));
    let x01 = _mm256_sub_ps(abx, _mm256_mul_ps(sx, abz));
    let y01 = _mm256_sub_ps(aby, _mm256_mul_ps(sy, abz));
    let x2 = _mm_sub_ps(cx, _mm_mul_ps(low(sx), cz));
    let y2 = _mm_sub_ps(cy, _mm_mul_ps(low(sy), cz));
    // Step 2: V in the low half, -U in the high one: the same products, exchanged.
    let v_u = _mm256_sub_ps(
        _mm256_mul_ps(x01, _mm256_set_m128(y2, y2)),
        _mm256_mul_ps(y01, _mm256_set_m128(x2, x2)),
    );
    let (x0, y0, x1, y1) = (low(x01), low(y01), high(x01), high(y01));
    let w = _mm_sub_ps(_mm_mul_ps(x1, y0), _mm_mul_ps(y1, x0));
    let v = low(v_u);
    let u = _mm_xor_ps(high(v_u), set(-0.0));
    // A NaN is neither: `min` and `max` give one of the three numbers or a NaN.
    let least = _mm_min_ps(_mm_min_ps(u, v), w);
    let greatest = _mm_max_ps(_mm_max_ps(u, v), w);
    let opposite =
        _mm_and_ps(_mm_cmp_ps::<_CMP_LT_OQ>(least, zero), _mm_cmp_ps::<_CMP_GT_OQ>(greatest, zero));
    let crossing = !(_mm_movemask_ps(opposite) as u32) & used;
    if crossing == 0 {
        return Verdict { accepted: 0, doubtful: 0 };
    }
    let magnitude = |x: __m128| _mm_andnot_ps(set(-0.0), x);
    let least_of = |v: __m256, c: __m128| _mm_min_ps(_mm_min_ps(low(v), high(v)), c);
    let greatest_of = |v: __m256, c: __m128| _mm_max_ps(_mm_max_ps(low(v), high(v)), c);
    let widest =
        |v: __m256, c: __m128| greatest_of(_mm256_andnot_ps(_mm256_set1_ps(-0.0), v), magnitude(c));
    let det = _mm_add_ps(_mm_add_ps(u, v), w);
    let size = magnitude(det);
    let part = _mm_mul_ps(_mm_mul_ps(widest(x01, x2), widest(y01, y2)), set(DET_PART));
    let any_zero = _mm_or_ps(
        _mm_or_ps(_mm_cmp_ps::<_CMP_EQ_UQ>(u, zero), _mm_cmp_ps::<_CMP_EQ_UQ>(v, zero)),
        _mm_cmp_ps::<_CMP_EQ_UQ>(w, zero),
    );
    let in_range = _mm_and_ps(
        _mm_cmp_ps::<_CMP_GE_OQ>(size, part),
        _mm_and_ps(
            _mm_cmp_ps::<_CMP_GE_OQ>(size, set(DET_MIN)),
            _mm_cmp_ps::<_CMP_LE_OQ>(size, set(DET_MAX)),
        ),
    );
    let sound = _mm_movemask_ps(_mm_andnot_ps(any_zero, in_range)) as u32;
    // Step 3.
    let r = _mm_div_ps(set(1.0), det);
    let (b0, b1, b2) = (_mm_mul_ps(u, r), _mm_mul_ps(v, r), _mm_mul_ps(w, r));
    let z = |z: __m128| _mm_mul_ps(set(ray.shear[2]), z);
    let t = _mm_add_ps(
        _mm_add_ps(_mm_mul_ps(b0, z(low(abz))), _mm_mul_ps(b1, z(high(abz)))),
        _mm_mul_ps(b2, z(cz)),
    );
    // Step 5. Rounding is monotone: the least of the differences is the difference of the least.
    let ends_of = |ab: __m256, c: __m128| (least_of(ab, c), greatest_of(ab, c));
    let ends = [ends_of(abx, cx), ends_of(aby, cy), ends_of(abz, cz)];
    let far = |(l, h): (__m128, __m128)| _mm_max_ps(magnitude(l), magnitude(h));
    let pad = _mm_max_ps(_mm_max_ps(far(ends[0]), far(ends[1])), far(ends[2]));
    let pad = _mm_mul_ps(pad, set(PreparedRay::PAD));
    let slab = |axis: usize, (l, h): (__m128, __m128)| {
        let inv = set(ray.inv[axis]);
        let t0 = _mm_mul_ps(_mm_sub_ps(l, pad), inv);
        let t1 = _mm_mul_ps(_mm_add_ps(h, pad), inv);
        // The one that the sign of `inv` makes the first is the lesser: `l - pad < h + pad`, or all is one number.
        (_mm_min_ps(t0, t1), _mm_max_ps(t0, t1))
    };
    let ((x0, x1), (y0, y1), (z0, z1)) = (slab(0, ends[0]), slab(1, ends[1]), slab(2, ends[2]));
    let enter = _mm_max_ps(_mm_max_ps(x0, y0), z0);
    let leave = _mm_min_ps(_mm_min_ps(x1, y1), z1);
    // Step 4 of a hit.
    let t = _mm_add_ps(_mm_min_ps(leave, _mm_max_ps(enter, t)), zero);
    let within = _mm_and_ps(
        _mm_cmp_ps::<_CMP_LE_OQ>(enter, leave),
        _mm_and_ps(
            _mm_cmp_ps::<_CMP_LE_OQ>(set(ray.t_min), t),
            _mm_cmp_ps::<_CMP_LE_OQ>(t, set(t_max)),
        ),
    );
    // SAFETY: four numbers each, of the eight of a row.
    unsafe {
        _mm_storeu_ps(out.t.as_mut_ptr(), t);
        _mm_storeu_ps(out.b1.as_mut_ptr(), b1);
        _mm_storeu_ps(out.b2.as_mut_ptr(), b2);
    }
    Verdict {
        accepted: crossing & sound & _mm_movemask_ps(within) as u32,
        doubtful: crossing & !sound,
    }
}

/// The corners of four triangles along `kx, ky, kz`: the first and second in the halves of `ab`.
struct Corners {
    ab: [__m256; 3],
    c: [__m128; 3],
    /// Mask of the places that are used.
    used: u32,
}

/// Loads twelve vertices. `None` if one does not lie in `words`.
///
/// # Safety
/// The machine has AVX2.
#[inline(always)]
unsafe fn gather(ray: &Along, words: &[f32], record: &Record) -> Option<Corners> {
    // SAFETY: the machine has AVX2. A record has sixteen bytes. Every vertex that is loaded has been
    // compared: words 3 (base + i) to 3 (base + i) + 3 lie in `words`.
    unsafe {
        let bytes = _mm_loadu_si128(core::ptr::from_ref(record).cast());
        let spread = |i: i8| {
            let z = -1;
            _mm_setr_epi8(i, z, z, z, i + 3, z, z, z, i + 6, z, z, z, i + 9, z, z, z)
        };
        let a = _mm_shuffle_epi8(bytes, spread(0));
        let b = _mm_shuffle_epi8(bytes, spread(1));
        let c = _mm_shuffle_epi8(bytes, spread(2));
        let unused = _mm_and_si128(_mm_cmpeq_epi32(a, b), _mm_cmpeq_epi32(b, c));
        let used = !_mm_movemask_ps(_mm_castsi128_ps(unused)) as u32 & 0b1111;
        let greatest = _mm_max_epi32(_mm_max_epi32(a, b), c);
        let greatest = _mm_add_epi32(greatest, _mm_slli_epi32::<1>(greatest));
        let base = 3 * usize::from(record.base);
        // Blocks end at 64 KiB: no length of words wraps.
        let last = words.len().min(1 << 20) as i32 - 4 - base as i32;
        let beyond = _mm_cmpgt_epi32(greatest, _mm_set1_epi32(last));
        if _mm_movemask_epi8(beyond) != 0 {
            return None;
        }
        let vertices = words.as_ptr().add(base);
        let at = |i: u8| vertices.add(3 * usize::from(i));
        let permute = _mm256_loadu_si256(ray.permute.as_ptr().cast());
        let pair = |[a, b, _]: [u8; 3]| {
            let low = _mm256_castps128_ps256(_mm_loadu_ps(at(a)));
            let both = _mm256_insertf128_ps::<1>(low, _mm_loadu_ps(at(b)));
            _mm256_permutevar_ps(both, permute)
        };
        let third = |[_, _, c]: [u8; 3]| {
            _mm_permutevar_ps(_mm_loadu_ps(at(c)), _mm256_castsi256_si128(permute))
        };
        let [i0, i1, i2, i3] = record.index;
        let (p0, p1, p2, p3) = (pair(i0), pair(i1), pair(i2), pair(i3));
        let xy01 = _mm256_castps_pd(_mm256_unpacklo_ps(p0, p1));
        let xy23 = _mm256_castps_pd(_mm256_unpacklo_ps(p2, p3));
        let z01 = _mm256_castps_pd(_mm256_unpackhi_ps(p0, p1));
        let z23 = _mm256_castps_pd(_mm256_unpackhi_ps(p2, p3));
        let ab = [
            _mm256_castpd_ps(_mm256_unpacklo_pd(xy01, xy23)),
            _mm256_castpd_ps(_mm256_unpackhi_pd(xy01, xy23)),
            _mm256_castpd_ps(_mm256_unpacklo_pd(z01, z23)),
        ];
        let (p0, p1, p2, p3) = (third(i0), third(i1), third(i2), third(i3));
        let (xy01, xy23) = (_mm_unpacklo_ps(p0, p1), _mm_unpacklo_ps(p2, p3));
        let (z01, z23) = (_mm_unpackhi_ps(p0, p1), _mm_unpackhi_ps(p2, p3));
        let c = [_mm_movelh_ps(xy01, xy23), _mm_movehl_ps(xy23, xy01), _mm_movelh_ps(z01, z23)];
        Some(Corners { ab, c, used })
    }
}
