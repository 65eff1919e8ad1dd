//! A ray, and a ray in the frame of a block.

#[allow(clippy::wildcard_imports, reason = "a kernel names a hundred instructions")]
use core::arch::x86_64::*;
use core::mem::offset_of;

use kiloray_core::block::format::BlockHeader;
use kiloray_core::geometry::rounding::{max, min};
use kiloray_core::geometry::{self, PreparedRay};
use kiloray_core::trace::BoxRay;

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
            let greatest = greatest(_mm_andnot_ps(_mm_set1_ps(-0.0), origin));
            let along = Along::new(ray.axis, ray.shear, ray.t_min, origin, inv);
            Self::new(origin, inv, ray.signs, greatest, along)
        }
    }

    /// Of a ray whose origin has this greatest magnitude of a coordinate.
    ///
    /// # Safety
    /// The machine has AVX2.
    #[inline(always)]
    unsafe fn new(origin: __m128, inv: __m128, signs: u8, greatest: f32, along: Along) -> Self {
        // SAFETY: by the caller.
        unsafe {
            let sign = _mm_and_ps(inv, _mm_set1_ps(-0.0));
            let sides = &SIDES[usize::from(signs & 7)];
            match BoxRay::pad(greatest, along.least()) {
                Some(pad) => {
                    Self { origin, inv, pad: _mm_or_ps(_mm_set1_ps(pad), sign), sides, along }
                }
                None => Self {
                    origin: _mm_setzero_ps(),
                    inv: _mm_or_ps(_mm_set1_ps(1.0), sign),
                    pad: _mm_or_ps(_mm_set1_ps(f32::INFINITY), sign),
                    sides,
                    along,
                },
            }
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
    // SAFETY: by the caller. A ray is eight numbers: origin, direction, `t_min`, `t_max`; each load lies in them. Stores lie in the fifteen of a prepared ray.
    unsafe {
        let numbers = core::ptr::from_ref(ray).cast::<f32>();
        let signs = _mm_set1_ps(-0.0);
        let magnitude = |v: __m128| _mm_andnot_ps(signs, v);
        let whole = _mm256_loadu_ps(numbers);
        let all = _mm256_andnot_ps(_mm256_set1_ps(-0.0), whole);
        let (finite, any) = (f32::MAX, f32::INFINITY);
        // Not true of a NaN.
        let limits = _mm256_setr_ps(finite, finite, finite, finite, finite, finite, any, any);
        if _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LE_OQ>(all, limits)) != 0xff {
            return None;
        }
        let direction = _mm_loadu_ps(numbers.add(3));
        let size = magnitude(direction);
        // The least axis among equals.
        let no_less = |others: __m128| _mm_cmp_ps::<_CMP_GE_OQ>(size, others);
        let yzx = no_less(_mm_shuffle_ps::<0b11_00_10_01>(size, size));
        let zxy = no_less(_mm_shuffle_ps::<0b11_01_00_10>(size, size));
        let axis = _mm_movemask_ps(_mm_and_ps(yzx, zxy)).trailing_zeros() as u8;
        let permuted = _mm_permutevar_ps(direction, permute(axis));
        let z = _mm_shuffle_ps::<0b10_10_10_10>(permuted, permuted);
        let greatest_of = _mm_cvtss_f32(magnitude(z));
        if !(PreparedRay::DIRECTION_MIN..=PreparedRay::DIRECTION_MAX).contains(&greatest_of) {
            return None;
        }
        let one = _mm_set1_ps(1.0);
        let shear = _mm_div_ps(_mm_blend_ps::<0b1100>(permuted, one), z);
        let mut inv = _mm_div_ps(one, direction);
        let least = _mm_set1_ps(greatest_of * PreparedRay::CLAMP);
        let small = _mm_cmp_ps::<_CMP_LT_OQ>(size, least);
        if _mm_movemask_ps(small) & 0b111 != 0 {
            // Few rays are so near an axis: the others need not wait to know.
            let raised = _mm_or_ps(least, _mm_and_ps(signs, direction));
            inv = _mm_div_ps(one, _mm_blendv_ps(direction, raised, small));
        }
        let origin = _mm_loadu_ps(numbers);
        let (t_min, t_max) = (max(ray.t_min, 0.0), min(ray.t_max, f32::MAX));
        let along = Along::new(axis, first_three(shear), t_min, origin, inv);
        let greatest = greatest(magnitude(origin));
        // As `inv` has them, and sooner.
        let signs = _mm_movemask_ps(direction) as u8 & 7;
        let wide = Ray::new(origin, inv, signs, greatest, along);
        let place = core::ptr::from_mut(to).cast::<f32>();
        _mm256_storeu_ps(place, whole);
        _mm_storeu_ps(place.add(8), inv);
        _mm_storeu_ps(place.add(11), shear);
        (to.axis, to.signs, to.t_min, to.t_max) = (axis, signs, t_min, t_max);
        Some(wide)
    }
}

/// # Safety
/// The machine has AVX2.
#[inline(always)]
unsafe fn first_three(v: __m128) -> [f32; 3] {
    // SAFETY: by the caller.
    unsafe {
        let at = |v: __m128| _mm_cvtss_f32(v);
        [at(v), at(_mm_movehdup_ps(v)), at(_mm_movehl_ps(v, v))]
    }
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
