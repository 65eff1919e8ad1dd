//! A ray, and a ray in the frame of a block.

#[allow(clippy::wildcard_imports, reason = "a kernel names a hundred instructions")]
use core::arch::x86_64::*;
use core::mem::offset_of;

use kiloray_core::block::format::BlockHeader;
use kiloray_core::geometry::{self, PreparedRay};
use kiloray_core::trace::BoxRay;

use super::in_place;
use super::record::{Along, permute};

/// A ray in the frame of a block; the fourth numbers mean nothing.
#[derive(Debug, Clone, Copy)]
#[repr(C, align(16))]
pub struct Frame {
    pub(super) inv: [f32; 4],
    pub(super) near: [f32; 4],
    pub(super) far: [f32; 4],
    pub(super) sides: &'static Sides,
}

/// A frame in registers: each number in all lanes.
#[derive(Debug, Clone, Copy)]
pub struct Spread {
    pub(super) inv: [__m256; 3],
    pub(super) near: [__m256; 3],
    pub(super) far: [__m256; 3],
    pub(super) sides: &'static Sides,
}

impl Spread {
    /// # Safety
    /// The machine has AVX2.
    #[inline(always)]
    pub(super) unsafe fn of(frame: &Frame) -> Self {
        // SAFETY: by the caller.
        let spread = |[x, y, z, _]: &[f32; 4]| unsafe {
            [_mm256_broadcast_ss(x), _mm256_broadcast_ss(y), _mm256_broadcast_ss(z)]
        };
        Self {
            inv: spread(&frame.inv),
            near: spread(&frame.near),
            far: spread(&frame.far),
            sides: frame.sides,
        }
    }
}

/// Where in a [`Node`](kiloray_core::block::format::Node) the bounds begin that a ray meets first, by axis, and the others, in bytes.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sides {
    pub(super) first: [usize; 3],
    pub(super) last: [usize; 3],
}

/// Of a ray that descends the axes of these bits.
static SIDES: [Sides; 8] = sides();

const fn sides() -> [Sides; 8] {
    let mut table = [Sides { first: [0, 16, 32], last: [48, 64, 80] }; 8];
    let mut signs = 0;
    while signs < 8 {
        let mut axis = 0;
        while axis < 3 {
            if signs >> axis & 1 == 1 {
                let Sides { first, last } = &mut table[signs];
                (first[axis], last[axis]) = (last[axis], first[axis]);
            }
            axis += 1;
        }
        signs += 1;
    }
    table
}

/// A ray for frames, and for four triangles.
#[derive(Debug, Clone, Copy)]
pub struct Ray {
    origin: __m128,
    inv: __m128,
    /// With the sign of `inv`.
    pad: __m128,
    sides: &'static Sides,
    /// For triangles.
    pub(super) along: Along,
}

impl Ray {
    /// # Safety
    /// The machine has AVX2.
    #[inline(always)]
    pub(super) unsafe fn of(ray: &PreparedRay) -> Self {
        // SAFETY: by the caller.
        unsafe {
            let vector = |[x, y, z]: [f32; 3]| _mm_setr_ps(x, y, z, 0.0);
            let (origin, inv) = (vector(ray.origin.to_array()), vector(ray.inv.to_array()));
            let [x, y, z] = ray.shear;
            let shear = _mm_setr_ps(x, y, z, 0.0);
            let permute = permute(1_u32.unbounded_shl(ray.axis.into()));
            let along = Along::new(permute, shear, ray.t_min, origin, inv);
            let greatest = greatest(_mm_andnot_ps(_mm_set1_ps(-0.0), origin));
            if let Some(pad) = BoxRay::pad(greatest, z.abs()) {
                return Self::new(origin, inv, ray.signs, pad, along);
            }
            let sign = _mm_and_ps(inv, _mm_set1_ps(-0.0));
            let one = _mm_or_ps(_mm_set1_ps(1.0), sign);
            Self::new(_mm_setzero_ps(), one, ray.signs, f32::INFINITY, along)
        }
    }

    /// Of a ray with this [pad](BoxRay::pad).
    ///
    /// # Safety
    /// The machine has AVX2.
    #[inline(always)]
    unsafe fn new(origin: __m128, inv: __m128, signs: u8, pad: f32, along: Along) -> Self {
        // SAFETY: by the caller.
        unsafe {
            let sign = _mm_and_ps(inv, _mm_set1_ps(-0.0));
            let sides = &SIDES[usize::from(signs & 7)];
            Self { origin, inv, pad: _mm_or_ps(_mm_set1_ps(pad), sign), sides, along }
        }
    }
}

/// The greatest of the first three numbers, none of which is NaN.
///
/// # Safety
/// The machine has AVX2.
#[inline(always)]
unsafe fn greatest(v: __m128) -> f32 {
    // SAFETY: by the caller.
    unsafe {
        let y = _mm_shuffle_ps::<0b01_01_01_01>(v, v);
        let z = _mm_shuffle_ps::<0b10_10_10_10>(v, v);
        _mm_cvtss_f32(_mm_max_ss(_mm_max_ss(v, y), z))
    }
}

/// `Lanes::prepare`: the operations of `PreparedRay::of`, several at a time.
///
/// # Safety
/// The machine has AVX2.
#[inline(always)]
pub(super) unsafe fn prepare(ray: &geometry::Ray, to: &mut PreparedRay) -> Option<Ray> {
    const {
        assert!(size_of::<geometry::Ray>() == 32);
        // A prepared ray begins as a ray does; what goes on behind `inv` and `shear` is written after them.
        assert!(offset_of!(PreparedRay, t_max) == 28 && offset_of!(PreparedRay, inv) == 32);
        assert!(offset_of!(PreparedRay, shear) == 44 && offset_of!(PreparedRay, axis) == 56);
        assert!(size_of::<PreparedRay>() == 60);
    };
    // Of components of the direction between these nothing else is asked.
    const SMALL: f32 = 1.0 / BoxRay::INV_MAX;
    const LARGE: f32 = BoxRay::INV_MAX;
    // SAFETY: by the caller. A ray is eight numbers: origin, direction, `t_min`, `t_max`; each load lies in them. Stores lie in the fifteen of a prepared ray.
    unsafe {
        let whole = _mm256_loadu_ps(core::ptr::from_ref(ray).cast());
        let all = _mm256_andnot_ps(_mm256_set1_ps(-0.0), whole);
        let (far, any) = (BoxRay::ORIGIN_MAX, f32::INFINITY);
        let least = _mm256_setr_ps(0.0, 0.0, 0.0, SMALL, SMALL, SMALL, 0.0, 0.0);
        let most = _mm256_setr_ps(far, far, far, LARGE, LARGE, LARGE, any, any);
        // Not true of a NaN.
        let above = _mm256_cmp_ps::<_CMP_LE_OQ>(least, all);
        let below = _mm256_cmp_ps::<_CMP_LE_OQ>(all, most);
        if _mm256_movemask_ps(_mm256_and_ps(above, below)) != 0xff {
            // Few are so near an axis, so far away, or so fast or slow.
            return prepare_rarely(ray, to).then(|| Ray::of(to));
        }
        // Of what was loaded already the compiler would take it by way of whole numbers.
        let direction = _mm_loadu_ps(core::ptr::from_ref(in_place(ray)).cast::<f32>().add(3));
        let size = _mm_andnot_ps(_mm_set1_ps(-0.0), direction);
        let no_less = |others: __m128| _mm_cmp_ps::<_CMP_GE_OQ>(size, others);
        let yzx = no_less(_mm_shuffle_ps::<0b11_00_10_01>(size, size));
        let zxy = no_less(_mm_shuffle_ps::<0b11_01_00_10>(size, size));
        // The least axis among equals.
        let axes = _mm_movemask_ps(_mm_and_ps(yzx, zxy)) as u32;
        let permute = permute(axes);
        let permuted = _mm_permutevar_ps(direction, permute);
        let z = _mm_shuffle_ps::<0b10_10_10_10>(permuted, permuted);
        let one = _mm_set1_ps(1.0);
        let shear = _mm_div_ps(_mm_blend_ps::<0b1100>(permuted, one), z);
        let inv = _mm_div_ps(one, direction);
        let origin = _mm256_castps256_ps128(whole);
        // Two components and the ends of `t`.
        let (none, finite) = (-f32::MAX, f32::MAX);
        let ends = _mm256_extractf128_ps::<1>(whole);
        let ends = _mm_max_ps(ends, _mm_setr_ps(none, none, 0.0, -any));
        let ends = _mm_min_ps(ends, _mm_setr_ps(finite, finite, any, finite));
        let t_min = _mm_cvtss_f32(_mm_movehl_ps(ends, ends));
        // As `inv` has them, and sooner.
        let signs = _mm_movemask_ps(direction) as u8 & 7;
        let greatest = greatest(_mm_andnot_ps(_mm_set1_ps(-0.0), origin));
        let along = Along::new(permute, shear, t_min, origin, inv);
        let wide = Ray::new(origin, inv, signs, BoxRay::sound_pad(greatest), along);
        let place = core::ptr::from_mut(to).cast::<f32>();
        _mm256_storeu_ps(place, _mm256_insertf128_ps::<1>(whole, ends));
        _mm_storeu_ps(place.add(8), inv);
        _mm_storeu_ps(place.add(11), shear);
        (to.axis, to.signs) = (axes.trailing_zeros() as u8, signs);
        Some(wide)
    }
}

/// Prepares any ray, if it can hit anything.
#[cold]
#[inline(never)]
fn prepare_rarely(ray: &geometry::Ray, to: &mut PreparedRay) -> bool {
    let prepared = PreparedRay::of(ray);
    *to = prepared.unwrap_or(PreparedRay::NONE);
    prepared.is_some()
}

impl Frame {
    /// # Safety
    /// The machine has AVX2.
    #[inline(always)]
    pub(super) unsafe fn new(ray: &Ray, header: &BlockHeader) -> Self {
        let mut frame = Self { inv: [0.0; 4], near: [0.0; 4], far: [0.0; 4], sides: ray.sides };
        // SAFETY: by the caller. Both loads lie in the header: origin and the first of scale, scale and the four bytes
        // behind it. The fourth number is not used.
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
}
