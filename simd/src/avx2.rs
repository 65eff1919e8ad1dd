//! Eight boxes and four triangles at a time.

#[allow(clippy::wildcard_imports, reason = "a kernel names a hundred instructions")]
use core::arch::x86_64::*;

use kiloray_core::block::format::{BlockHeader, Node, Record};
use kiloray_core::geometry::PreparedRay;
use kiloray_core::trace::{
    BeamFrame, BoxRay, Corners as Triangle, Crossings, Group, Lanes, Octants, Planes, Sides,
    Verdict,
};

mod bundle;

/// Lanes of AVX2 and FMA. A value of it proves that the machine has them.
#[derive(Debug, Clone, Copy)]
pub struct Avx2(());

impl Avx2 {
    /// The lanes, if the machine has AVX2, FMA, BMI1, BMI2, LZCNT and POPCNT.
    #[must_use]
    pub fn detect() -> Option<Self> {
        let found = std::is_x86_feature_detected!("avx2")
            && std::is_x86_feature_detected!("fma")
            && std::is_x86_feature_detected!("bmi1")
            && std::is_x86_feature_detected!("bmi2")
            && std::is_x86_feature_detected!("lzcnt")
            && std::is_x86_feature_detected!("popcnt");
        found.then_some(Self(()))
    }
}

/// A ray in the frame of a block; the fourth numbers mean nothing.
#[derive(Debug, Clone, Copy)]
#[repr(C, align(16))]
pub struct Frame {
    inv: [f32; 4],
    near: [f32; 4],
    far: [f32; 4],
    /// Where in a [`Node`] the bounds begin that the ray meets first, in bytes: of each axis 0 or 48 behind the lower ones.
    first: [u32; 3],
}

/// A ray for frames, and for four triangles.
#[derive(Debug, Clone, Copy)]
pub struct Ray {
    origin: __m128,
    inv: __m128,
    /// With the sign of `inv`.
    pad: __m128,
    /// The origin along `kx, ky, kz`.
    sheared: [f32; 3],
    /// The shear along `kx, ky`.
    shear: [f32; 2],
    /// See [`Frame::first`].
    first: [u32; 3],
    /// Takes the components x, y, z to the places of `kx, ky, kz`, twice.
    permute: &'static [i32; 8],
}

/// By `kz`: see [`Ray::permute`].
static PERMUTES: [[i32; 8]; 3] =
    [[1, 2, 0, 3, 1, 2, 0, 3], [2, 0, 1, 3, 2, 0, 1, 3], [0, 1, 2, 3, 0, 1, 2, 3]];

impl Lanes for Avx2 {
    type Frame = Frame;
    type Ray = Ray;

    #[inline(always)]
    fn ray(self, ray: &PreparedRay) -> Ray {
        let boxes = BoxRay::new(ray);
        let ([ox, oy, oz], [ix, iy, iz]) = (boxes.origin, boxes.inv);
        let (x, y, z) = ray.permuted(ray.origin);
        let [sx, sy, _] = ray.shear;
        // `inv` is never zero: its sign bit tells.
        let first = |inv: f32, lo: u32| lo + (inv.to_bits() >> 31) * 48;
        Ray {
            // SAFETY: a value of Avx2 exists, so the machine has AVX2.
            origin: unsafe { _mm_setr_ps(ox, oy, oz, 0.0) },
            // SAFETY: as above.
            inv: unsafe { _mm_setr_ps(ix, iy, iz, 1.0) },
            // SAFETY: as above.
            pad: unsafe {
                let sign = _mm_and_ps(_mm_setr_ps(ix, iy, iz, 1.0), _mm_set1_ps(-0.0));
                _mm_or_ps(_mm_set1_ps(boxes.pad), sign)
            },
            sheared: [x, y, z],
            shear: [sx, sy],
            first: [first(ix, 0), first(iy, 16), first(iz, 32)],
            permute: &PERMUTES[usize::from(ray.axis.min(2))],
        }
    }

    #[inline(always)]
    fn frame(self, ray: &Ray, header: &BlockHeader) -> Frame {
        let mut frame = Frame { inv: [0.0; 4], near: [0.0; 4], far: [0.0; 4], first: ray.first };
        // SAFETY: a value of Avx2 exists, so the machine has AVX2. Both loads lie in the header: origin and the first of
        // scale, scale and the four bytes behind it. The fourth number is not used.
        unsafe {
            let origin = _mm_loadu_ps(header.origin.as_ptr());
            let scale = _mm_loadu_ps(header.scale.as_ptr());
            let inv = ray.inv;
            let sign = _mm_set1_ps(-0.0);
            let pad = ray.pad;
            let d = _mm_sub_ps(ray.origin, origin);
            _mm_store_ps(frame.inv.as_mut_ptr(), _mm_mul_ps(inv, scale));
            let near = _mm_mul_ps(_mm_add_ps(d, pad), _mm_xor_ps(inv, sign));
            _mm_store_ps(frame.near.as_mut_ptr(), near);
            _mm_store_ps(frame.far.as_mut_ptr(), _mm_mul_ps(_mm_sub_ps(pad, d), inv));
        }
        frame
    }

    #[inline(always)]
    fn slots(self, frame: &Frame, node: &Node, t_min: f32, t_max: f32, near: &mut [f32; 8]) -> u32 {
        let bytes = core::ptr::from_ref(node).cast::<u8>();
        let [fx, fy, fz] = frame.first.map(|offset| offset as usize);
        // SAFETY: a value of Avx2 exists, so the machine has AVX2 and FMA. Offsets are 0, 16 or 32, or 48 more, by
        // the only constructor of Frame: sixteen bytes from there lie in the 96 bytes of bounds.
        unsafe {
            let bounds = |offset: usize| {
                let q = _mm_loadu_si128(bytes.add(offset).cast());
                _mm256_cvtepi32_ps(_mm256_cvtepu16_epi32(q))
            };
            let ix = _mm256_broadcast_ss(&frame.inv[0]);
            let iy = _mm256_broadcast_ss(&frame.inv[1]);
            let iz = _mm256_broadcast_ss(&frame.inv[2]);
            let x0 = _mm256_fmadd_ps(bounds(fx), ix, _mm256_broadcast_ss(&frame.near[0]));
            let y0 = _mm256_fmadd_ps(bounds(fy), iy, _mm256_broadcast_ss(&frame.near[1]));
            let z0 = _mm256_fmadd_ps(bounds(fz), iz, _mm256_broadcast_ss(&frame.near[2]));
            let x1 = _mm256_fmadd_ps(bounds(48 - fx), ix, _mm256_broadcast_ss(&frame.far[0]));
            let y1 = _mm256_fmadd_ps(bounds(80 - fy), iy, _mm256_broadcast_ss(&frame.far[1]));
            let z1 = _mm256_fmadd_ps(bounds(112 - fz), iz, _mm256_broadcast_ss(&frame.far[2]));
            let enter =
                _mm256_max_ps(_mm256_max_ps(x0, y0), _mm256_max_ps(z0, _mm256_set1_ps(t_min)));
            let leave =
                _mm256_min_ps(_mm256_min_ps(x1, y1), _mm256_min_ps(z1, _mm256_set1_ps(t_max)));
            _mm256_storeu_ps(near.as_mut_ptr(), enter);
            _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LE_OQ>(enter, leave)) as u32
        }
    }

    #[inline(always)]
    fn flip(self, octants: &Octants, node: &Node) -> u8 {
        // SAFETY: a value of Avx2 exists, so the machine has AVX2; the load is of eight u16.
        let code = unsafe {
            let child = _mm_loadu_si128(node.child.as_ptr().cast());
            _mm_movemask_epi8(_mm_packs_epi16(child, child))
        };
        octants[code as usize & 63]
    }

    #[inline(always)]
    fn candidates(self, ray: &Ray, words: &[f32], record: &Record) -> u32 {
        // SAFETY: a value of Avx2 exists, so the machine has AVX2. Loads of vertices are checked by `gather`.
        unsafe {
            let Some(Corners { ab: [abx, aby, abz], c: [cx, cy, cz], used }) =
                gather(ray, words, record)
            else {
                return 0b1111;
            };
            let [ox, oy, oz] = all(ray.sheared);
            let (sx, sy) = (_mm256_set1_ps(ray.shear[0]), _mm256_set1_ps(ray.shear[1]));
            let half = |v: __m256| _mm256_castps256_ps128(v);
            // Step 1 of the definition for vertices 0 and 1 (low and high half), and for vertex 2.
            let abz = _mm256_sub_ps(abz, oz);
            let abx = _mm256_sub_ps(_mm256_sub_ps(abx, ox), _mm256_mul_ps(sx, abz));
            let aby = _mm256_sub_ps(_mm256_sub_ps(aby, oy), _mm256_mul_ps(sy, abz));
            let cz = _mm_sub_ps(cz, half(oz));
            let cx = _mm_sub_ps(_mm_sub_ps(cx, half(ox)), _mm_mul_ps(half(sx), cz));
            let cy = _mm_sub_ps(_mm_sub_ps(cy, half(oy)), _mm_mul_ps(half(sy), cz));
            // Step 2: V in the low half, -U in the high one: the same products, exchanged.
            let v_u = _mm256_sub_ps(
                _mm256_mul_ps(abx, _mm256_set_m128(cy, cy)),
                _mm256_mul_ps(aby, _mm256_set_m128(cx, cx)),
            );
            let high = |v: __m256| _mm256_extractf128_ps::<1>(v);
            let w = _mm_sub_ps(_mm_mul_ps(high(abx), half(aby)), _mm_mul_ps(high(aby), half(abx)));
            let v = half(v_u);
            let u = _mm_xor_ps(high(v_u), _mm_set1_ps(-0.0));
            // A NaN is neither: `min` and `max` give one of the three numbers or a NaN.
            let least = _mm_min_ps(_mm_min_ps(u, v), w);
            let greatest = _mm_max_ps(_mm_max_ps(u, v), w);
            let zero = _mm_setzero_ps();
            let opposite = _mm_and_ps(
                _mm_cmp_ps::<_CMP_LT_OQ>(least, zero),
                _mm_cmp_ps::<_CMP_GT_OQ>(greatest, zero),
            );
            !(_mm_movemask_ps(opposite) as u32) & used
        }
    }

    #[inline(always)]
    fn beam(self, beam: &BeamFrame, node: &Node, t_min: f32, t_max: f32, to: &mut Planes) -> u32 {
        // SAFETY: a value of Avx2 exists, so the machine has AVX2 and FMA.
        unsafe { bundle::beam(beam, node, t_min, t_max, to) }
    }

    #[inline(always)]
    fn meets(self, group: &Group, sides: &Sides) -> u32 {
        // SAFETY: as above.
        unsafe { bundle::meets(group, sides) }
    }

    #[inline(always)]
    fn triangle(self, group: &Group, triangle: &Triangle, crossings: &mut Crossings) -> Verdict {
        // SAFETY: as above.
        unsafe { bundle::triangle(group, triangle, crossings) }
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
unsafe fn gather(ray: &Ray, words: &[f32], record: &Record) -> Option<Corners> {
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

/// Each of three numbers eight times.
#[inline(always)]
fn all([x, y, z]: [f32; 3]) -> [__m256; 3] {
    // SAFETY: only called with a value of Avx2 at hand.
    unsafe { [_mm256_set1_ps(x), _mm256_set1_ps(y), _mm256_set1_ps(z)] }
}
