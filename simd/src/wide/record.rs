//! A ray against the four triangles of a record.

#[allow(clippy::wildcard_imports, reason = "a kernel names a hundred instructions")]
use core::arch::x86_64::*;

use kiloray_core::block::Vertices;
use kiloray_core::block::format::Record;
use kiloray_core::geometry::{DET_MAX, DET_MIN, DET_PART, PreparedRay};
use kiloray_core::trace::{Crossings, Group, Kind, Quad, Row, Verdict};

use super::in_place;

/// A ray along the axes `kx, ky, kz`.
#[derive(Debug, Clone, Copy)]
pub(super) struct Along {
    origin: [f32; 4],
    shear: [f32; 4],
    inv: [f32; 4],
    t_min: f32,
    /// Takes the components x, y, z to the places of `kx, ky, kz`.
    permute: __m128i,
}

/// By a mask of axes, for its first as `kz`: see [`Along::permute`]. Of none, for the last.
static PERMUTES: [[i32; 4]; 8] = {
    let (x, y, z) = ([1, 2, 0, 3], [2, 0, 1, 3], [0, 1, 2, 3]);
    [z, x, y, x, z, x, y, x]
};

/// The numbers of [`PERMUTES`] for a mask of axes.
///
/// # Safety
/// The machine has AVX2.
#[inline(always)]
pub(super) unsafe fn permute(axes: u32) -> __m128i {
    // SAFETY: by the caller; the load is of a whole array.
    unsafe { _mm_loadu_si128(PERMUTES[axes as usize & 7].as_ptr().cast()) }
}

impl Along {
    /// Of a ray with these numbers of a [`PreparedRay`], its origin and the inverse of its direction.
    ///
    /// # Safety
    /// The machine has AVX2.
    #[inline(always)]
    pub(super) unsafe fn new(
        permute: __m128i,
        shear: __m128,
        t_min: f32,
        origin: __m128,
        inv: __m128,
    ) -> Self {
        // SAFETY: by the caller; stores are of whole arrays.
        unsafe {
            let none = [0.0; 4];
            let mut along = Self { origin: none, shear: none, inv: none, t_min, permute };
            _mm_storeu_ps(along.origin.as_mut_ptr(), _mm_permutevar_ps(origin, permute));
            _mm_storeu_ps(along.shear.as_mut_ptr(), shear);
            _mm_storeu_ps(along.inv.as_mut_ptr(), _mm_permutevar_ps(inv, permute));
            along
        }
    }
}

/// Four triangles as the ray sees them: a row of lanes for each number of theirs. Vertices 0 and 1 are the halves of the long rows.
#[derive(Clone, Copy)]
struct Sheared {
    /// Distance from the origin along `kx, ky, kz`.
    from01: [__m256; 3],
    from2: [__m128; 3],
    x01: __m256,
    y01: __m256,
    x2: __m128,
    y2: __m128,
}

/// The edge functions of four triangles.
#[derive(Clone, Copy)]
struct Edges {
    u: __m128,
    v: __m128,
    w: __m128,
}

/// `Lanes::record`: the operations of `PreparedRay::triangle`, one by one.
///
/// # Safety
/// The machine has AVX2.
#[inline(always)]
pub(super) unsafe fn record(
    ray: &Along,
    vertices: Vertices<'_>,
    record: &Record,
    t_max: f32,
    out: &mut Crossings,
) -> Verdict {
    let ray = in_place(ray);
    // SAFETY: by the caller.
    unsafe {
        let Some(Sheared { from01, from2, x01, y01, x2, y2 }) = sheared(ray, vertices, record)
        else {
            return Verdict { accepted: 0, doubtful: 0b1111 };
        };
        hits(
            ray,
            &Sheared { from01, from2, x01, y01, x2, y2 },
            || used(_mm_loadu_si128(core::ptr::from_ref(record).cast())),
            t_max,
            out,
        )
    }
}

/// Steps 2 to 5.
///
/// # Safety
/// The machine has AVX2.
#[inline(always)]
unsafe fn hits(
    ray: &Along,
    vertices: &Sheared,
    used: impl FnOnce() -> u32,
    t_max: f32,
    out: &mut Crossings,
) -> Verdict {
    // SAFETY: by the caller.
    unsafe {
        let &Sheared { x01, y01, x2, y2, .. } = vertices;
        // Step 2.
        let (x0, x1) = (low(x01), high(x01));
        let (y0, y1) = (low(y01), high(y01));
        let edge = |ax: __m128, by: __m128, ay: __m128, bx: __m128| {
            _mm_sub_ps(_mm_mul_ps(ax, by), _mm_mul_ps(ay, bx))
        };
        let (u, v, w) = (edge(x2, y1, y2, x1), edge(x0, y2, y0, x2), edge(x1, y0, y1, x0));
        let zero = _mm_setzero_ps();
        // As whole numbers, in a cycle each: any that is negative will do for the least. What hides one is -0, and a NaN hides either and is neither:
        // both are in doubt.
        let whole = |x: __m128| _mm_castps_si128(x);
        let float = |x: __m128i| _mm_castsi128_ps(x);
        let least = float(_mm_min_epi32(_mm_min_epi32(whole(u), whole(v)), whole(w)));
        let greatest = float(_mm_max_epi32(_mm_max_epi32(whole(u), whole(v)), whole(w)));
        let below = _mm_cmp_ps::<_CMP_LT_OQ>(least, zero);
        let opposite = _mm_and_ps(below, _mm_cmp_ps::<_CMP_GT_OQ>(greatest, zero));
        let crossing = !(_mm_movemask_ps(opposite) as u32) & 0b1111;
        if crossing == 0 {
            return Verdict { accepted: 0, doubtful: 0 };
        }
        let crossing = crossing & used();
        if crossing == 0 {
            return Verdict { accepted: 0, doubtful: 0 };
        }
        crossed(ray, vertices, &Edges { u, v, w }, crossing, t_max, out)
    }
}

/// `Lanes::quad_of`.
///
/// # Safety
/// The machine has AVX2.
#[inline(always)]
pub(super) unsafe fn quad_of(
    quad: &Quad,
    group: &Group,
    lane: usize,
    kind: Kind,
    out: &mut Crossings,
) -> Verdict {
    let lane = lane & 7;
    let [kx, ky, kz] = AXES[usize::from(kind.axis())];
    // SAFETY: by the caller; a lane is one of eight, an axis one of three, loads are of whole arrays.
    unsafe {
        let at = |row: &Row| *row.get_unchecked(lane);
        let origin = [at(&group.sheared[0]), at(&group.sheared[1]), at(&group.sheared[2]), 0.0];
        let shear = [at(&group.shear[0]), at(&group.shear[1]), at(&group.shear[2]), 0.0];
        let inv = |k: usize| at(group.inv.get_unchecked(k));
        let inv = [inv(kx), inv(ky), inv(kz), 0.0];
        let ray =
            Along { origin, shear, inv, t_min: at(&group.t_min), permute: _mm_setzero_si128() };
        let set = |x: f32| _mm256_set1_ps(x);
        let [ox, oy, oz] = [set(origin[0]), set(origin[1]), set(origin[2])];
        let [sx, sy] = [set(shear[0]), set(shear[1])];
        let long = |k: usize| _mm256_load_ps(quad.v01.get_unchecked(k).as_ptr());
        let (x, y) = (_mm256_sub_ps(long(kx), ox), _mm256_sub_ps(long(ky), oy));
        let z = _mm256_sub_ps(long(kz), oz);
        let from01 = [x, y, z];
        let x01 = _mm256_sub_ps(x, _mm256_mul_ps(sx, z));
        let y01 = _mm256_sub_ps(y, _mm256_mul_ps(sy, z));
        let short = |k: usize| _mm_load_ps(quad.v2.get_unchecked(k).as_ptr());
        let (x, y) = (_mm_sub_ps(short(kx), low(ox)), _mm_sub_ps(short(ky), low(oy)));
        let z = _mm_sub_ps(short(kz), low(oz));
        let x2 = _mm_sub_ps(x, _mm_mul_ps(low(sx), z));
        let y2 = _mm_sub_ps(y, _mm_mul_ps(low(sy), z));
        let sheared = Sheared { from01, from2: [x, y, z], x01, y01, x2, y2 };
        hits(&ray, &sheared, || quad.used, at(&group.t_max), out)
    }
}

/// `kx, ky, kz` by `kz`, which is below 3: the last are there so that nobody has to ask.
static AXES: [[usize; 3]; 4] = [[1, 2, 0], [2, 0, 1], [0, 1, 2], [0, 1, 2]];

/// `Lanes::quad`.
///
/// # Safety
/// The machine has AVX2.
#[inline(always)]
pub(super) unsafe fn quad(vertices: Vertices<'_>, record: &Record, to: &mut Quad) -> bool {
    // SAFETY: as in `sheared`.
    unsafe {
        if !can_be_loaded(vertices, record) {
            return false;
        }
        let bytes = _mm_loadu_si128(core::ptr::from_ref(record).cast());
        let words = vertices.words().as_ptr().add(3 * usize::from(record.base));
        let at = |i: u8| words.add(3 * usize::from(i));
        let record = in_place(record);
        let pair = |place: usize| {
            let [a, b, _] = record.index[place];
            let both = _mm256_castps128_ps256(_mm_loadu_ps(at(a)));
            _mm256_insertf128_ps::<1>(both, _mm_loadu_ps(at(b)))
        };
        let (p0, p1, p2, p3) = (pair(0), pair(1), pair(2), pair(3));
        let double = |v: __m256| _mm256_castps_pd(v);
        let single = |v: __m256d| _mm256_castpd_ps(v);
        let (xy01, xy23) = (double(_mm256_unpacklo_ps(p0, p1)), double(_mm256_unpacklo_ps(p2, p3)));
        let (z01, z23) = (double(_mm256_unpackhi_ps(p0, p1)), double(_mm256_unpackhi_ps(p2, p3)));
        _mm256_store_ps(to.v01[0].as_mut_ptr(), single(_mm256_unpacklo_pd(xy01, xy23)));
        _mm256_store_ps(to.v01[1].as_mut_ptr(), single(_mm256_unpackhi_pd(xy01, xy23)));
        _mm256_store_ps(to.v01[2].as_mut_ptr(), single(_mm256_unpacklo_pd(z01, z23)));
        let third = |place: usize| _mm_loadu_ps(at(record.index[place][2]));
        let (p0, p1, p2, p3) = (third(0), third(1), third(2), third(3));
        let (xy01, xy23) = (_mm_unpacklo_ps(p0, p1), _mm_unpacklo_ps(p2, p3));
        let (z01, z23) = (_mm_unpackhi_ps(p0, p1), _mm_unpackhi_ps(p2, p3));
        _mm_store_ps(to.v2[0].as_mut_ptr(), _mm_movelh_ps(xy01, xy23));
        _mm_store_ps(to.v2[1].as_mut_ptr(), _mm_movehl_ps(xy23, xy01));
        _mm_store_ps(to.v2[2].as_mut_ptr(), _mm_movelh_ps(z01, z23));
        to.used = used(bytes);
        true
    }
}

/// # Safety
/// The machine has AVX2.
#[inline(always)]
unsafe fn low(v: __m256) -> __m128 {
    // SAFETY: by the caller.
    unsafe { _mm256_castps256_ps128(v) }
}

/// # Safety
/// The machine has AVX2.
#[inline(always)]
unsafe fn high(v: __m256) -> __m128 {
    // SAFETY: by the caller.
    unsafe { _mm256_extractf128_ps::<1>(v) }
}

/// Without its sign.
///
/// # Safety
/// The machine has AVX2.
#[inline(always)]
unsafe fn magnitude(x: __m128) -> __m128 {
    // SAFETY: by the caller.
    unsafe { _mm_andnot_ps(_mm_set1_ps(-0.0), x) }
}

/// The greater of numbers that are not negative, as whole numbers: in a cycle, not four.
///
/// # Safety
/// The machine has AVX2.
#[inline(always)]
unsafe fn greater(a: __m128, b: __m128) -> __m128 {
    // SAFETY: by the caller.
    unsafe { _mm_castsi128_ps(_mm_max_epi32(_mm_castps_si128(a), _mm_castps_si128(b))) }
}

/// The greatest magnitude of three vertices' coordinates, by triangle. (No closure: one that is not inlined has calls for instructions, `tests/inlined`.)
///
/// # Safety
/// The machine has AVX2.
#[inline(always)]
unsafe fn widest(ab: __m256, c: __m128) -> __m128 {
    // SAFETY: by the caller.
    unsafe {
        let ab = _mm256_andnot_ps(_mm256_set1_ps(-0.0), ab);
        greater(greater(low(ab), high(ab)), magnitude(c))
    }
}

/// Where a ray enters and leaves the triangles' own boxes along an axis.
///
/// # Safety
/// The machine has AVX2.
#[inline(always)]
unsafe fn slab(ab: __m256, c: __m128, pad: __m128, inv: f32) -> (__m128, __m128) {
    // SAFETY: by the caller.
    unsafe {
        let inv = _mm_set1_ps(inv);
        // Rounding is monotone: the least of the differences is the difference of the least.
        let least = _mm_min_ps(_mm_min_ps(low(ab), high(ab)), c);
        let greatest = _mm_max_ps(_mm_max_ps(low(ab), high(ab)), c);
        let t0 = _mm_mul_ps(_mm_sub_ps(least, pad), inv);
        let t1 = _mm_mul_ps(_mm_add_ps(greatest, pad), inv);
        // The one that the sign of `inv` makes the first is the lesser: `least - pad < greatest + pad`, or all is one number.
        (_mm_min_ps(t0, t1), _mm_max_ps(t0, t1))
    }
}

/// The triangles among these that the ray hits.
///
/// # Safety
/// The machine has AVX2 and FMA.
#[inline(always)]
unsafe fn crossed(
    ray: &Along,
    vertices: &Sheared,
    &Edges { u, v, w }: &Edges,
    crossing: u32,
    t_max: f32,
    out: &mut Crossings,
) -> Verdict {
    // SAFETY: by the caller.
    unsafe {
        let &Sheared { from01, from2, x01, y01, x2, y2 } = vertices;
        let set = |x: f32| _mm_set1_ps(x);
        let zero = _mm_setzero_ps();
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
            _mm_add_ps(_mm_mul_ps(b0, z(low(from01[2]))), _mm_mul_ps(b1, z(high(from01[2])))),
            _mm_mul_ps(b2, z(from2[2])),
        );
        // Step 5.
        let [x_ab, y_ab, z_ab] = from01;
        let [x_c, y_c, z_c] = from2;
        let pad = greater(greater(widest(x_ab, x_c), widest(y_ab, y_c)), widest(z_ab, z_c));
        let pad = _mm_mul_ps(pad, set(PreparedRay::PAD));
        let [ix, iy, iz, _] = ray.inv;
        let (x0, x1) = slab(x_ab, x_c, pad, ix);
        let (y0, y1) = slab(y_ab, y_c, pad, iy);
        let (z0, z1) = slab(z_ab, z_c, pad, iz);
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
        {
            _mm_storeu_ps(out.t.as_mut_ptr(), t);
            _mm_storeu_ps(out.b1.as_mut_ptr(), b1);
            _mm_storeu_ps(out.b2.as_mut_ptr(), b2);
        }
        Verdict {
            accepted: crossing & sound & _mm_movemask_ps(within) as u32,
            doubtful: crossing & !sound,
        }
    }
}

/// The places of a record that hold a triangle: of one without, three bytes are alike.
///
/// # Safety
/// The machine has SSSE3.
#[inline(always)]
unsafe fn used(bytes: __m128i) -> u32 {
    // SAFETY: by the caller.
    unsafe {
        // The first bytes of all, then the second, then the third.
        let corners = _mm_setr_epi8(0, 3, 6, 9, 1, 4, 7, 10, 2, 5, 8, 11, -1, -1, -1, -1);
        let corners = _mm_shuffle_epi8(bytes, corners);
        let alike = _mm_cmpeq_epi8(corners, _mm_srli_si128::<4>(corners));
        let alike = _mm_movemask_epi8(alike) as u32;
        !(alike & alike >> 4) & 0b1111
    }
}

/// Whether sixteen bytes can be loaded at each vertex of a record.
///
/// # Safety
/// The machine has AVX2.
#[inline(always)]
unsafe fn can_be_loaded(vertices: Vertices<'_>, record: &Record) -> bool {
    let Some(last) = vertices.count().checked_sub(1 + usize::from(record.base)) else {
        return false;
    };
    // Nodes and records lie behind the vertices: in a large block a byte leads nowhere else.
    if last >= usize::from(u8::MAX) {
        return true;
    }
    // SAFETY: by the caller. A record has sixteen bytes.
    unsafe {
        let last = _mm_set1_epi8(last as i8);
        let bytes = _mm_loadu_si128(core::ptr::from_ref(record).cast());
        let within = _mm_cmpeq_epi8(_mm_max_epu8(bytes, last), last);
        _mm_movemask_epi8(within) & 0xfff == 0xfff
    }
}

/// Step 1 for twelve vertices; `z` is not yet multiplied. `None` if one does not exist.
///
/// # Safety
/// The machine has AVX2.
#[inline(always)]
unsafe fn sheared(ray: &Along, vertices: Vertices<'_>, record: &Record) -> Option<Sheared> {
    // SAFETY: by the caller. Every vertex that is loaded can be.
    unsafe {
        if !can_be_loaded(vertices, record) {
            return None;
        }
        let words = vertices.words().as_ptr().add(3 * usize::from(record.base));
        let at = |i: u8| words.add(3 * usize::from(i));
        let permute = ray.permute;
        let permute2 = _mm256_broadcastsi128_si256(permute);
        let record = in_place(record);
        let pair = |place: usize| {
            let [a, b, _] = record.index[place];
            let both = _mm256_castps128_ps256(_mm_loadu_ps(at(a)));
            let both = _mm256_insertf128_ps::<1>(both, _mm_loadu_ps(at(b)));
            _mm256_permutevar_ps(both, permute2)
        };
        let (p0, p1, p2, p3) = (pair(0), pair(1), pair(2), pair(3));
        let double = |v: __m256| _mm256_castps_pd(v);
        let single = |v: __m256d| _mm256_castpd_ps(v);
        let (xy01, xy23) = (double(_mm256_unpacklo_ps(p0, p1)), double(_mm256_unpacklo_ps(p2, p3)));
        let (z01, z23) = (double(_mm256_unpackhi_ps(p0, p1)), double(_mm256_unpackhi_ps(p2, p3)));
        let set = |x: f32| _mm256_set1_ps(x);
        let x = _mm256_sub_ps(single(_mm256_unpacklo_pd(xy01, xy23)), set(ray.origin[0]));
        let y = _mm256_sub_ps(single(_mm256_unpackhi_pd(xy01, xy23)), set(ray.origin[1]));
        let z = _mm256_sub_ps(single(_mm256_unpacklo_pd(z01, z23)), set(ray.origin[2]));
        let from01 = [x, y, z];
        let x01 = _mm256_sub_ps(x, _mm256_mul_ps(set(ray.shear[0]), z));
        let y01 = _mm256_sub_ps(y, _mm256_mul_ps(set(ray.shear[1]), z));
        let third = |place: usize| {
            let [_, _, c] = record.index[place];
            _mm_permutevar_ps(_mm_loadu_ps(at(c)), permute)
        };
        let (p0, p1, p2, p3) = (third(0), third(1), third(2), third(3));
        let (xy01, xy23) = (_mm_unpacklo_ps(p0, p1), _mm_unpacklo_ps(p2, p3));
        let (z01, z23) = (_mm_unpackhi_ps(p0, p1), _mm_unpackhi_ps(p2, p3));
        let set = |x: f32| _mm_set1_ps(x);
        let x = _mm_sub_ps(_mm_movelh_ps(xy01, xy23), set(ray.origin[0]));
        let y = _mm_sub_ps(_mm_movehl_ps(xy23, xy01), set(ray.origin[1]));
        let z = _mm_sub_ps(_mm_movelh_ps(z01, z23), set(ray.origin[2]));
        let x2 = _mm_sub_ps(x, _mm_mul_ps(set(ray.shear[0]), z));
        let y2 = _mm_sub_ps(y, _mm_mul_ps(set(ray.shear[1]), z));
        Some(Sheared { from01, from2: [x, y, z], x01, y01, x2, y2 })
    }
}
