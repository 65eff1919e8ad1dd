//! Eight boxes, or four triangles, at a time.

#[allow(clippy::wildcard_imports, reason = "a kernel names a hundred instructions")]
use core::arch::x86_64::*;

use kiloray_core::block::ExpandedNode;
use kiloray_core::block::format::{BlockHeader, Node, Record};
use kiloray_core::geometry::PreparedRay;
use kiloray_core::trace::{
    BeamFrame, BoxRay, Corners, Crossings, Group, Lanes, Octants, Planes, Sides, Verdict,
};

mod bundle;
mod record;

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
    /// See [`Frame::first`].
    first: [u32; 3],
    /// For triangles.
    along: record::Along,
}

impl Lanes for Avx2 {
    type Frame = Frame;
    type Ray = Ray;

    #[inline(always)]
    fn ray(self, ray: &PreparedRay) -> Ray {
        let boxes = BoxRay::new(ray);
        let ([ox, oy, oz], [ix, iy, iz]) = (boxes.origin, boxes.inv);
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
            first: [first(ix, 0), first(iy, 16), first(iz, 32)],
            along: record::Along::new(ray),
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
        let frame = in_place(frame);
        let [fx, fy, fz] = frame.first.map(|offset| offset as usize);
        // SAFETY: a value of Avx2 exists, so the machine has AVX2 and FMA. Offsets are 0, 16 or 32, or 48 more, by
        // the only constructor of Frame: sixteen bytes from there lie in the 96 bytes of bounds.
        unsafe {
            let bounds = |offset: usize| {
                let q = _mm_loadu_si128(bytes.add(offset).cast());
                _mm256_cvtepi32_ps(_mm256_cvtepu16_epi32(q))
            };
            let first = [bounds(fx), bounds(fy), bounds(fz)];
            let last = [bounds(48 - fx), bounds(80 - fy), bounds(112 - fz)];
            met(frame, first, last, t_min, t_max, near)
        }
    }

    #[inline(always)]
    fn expanded_slots(
        self,
        frame: &Frame,
        node: &ExpandedNode,
        t_min: f32,
        t_max: f32,
        near: &mut [f32; 8],
    ) -> u32 {
        let bytes = core::ptr::from_ref(node).cast::<u8>();
        let [fx, fy, fz] = frame.first.map(|offset| 2 * offset as usize);
        // SAFETY: as above; bounds are twice as long: 32 bytes from twice those offsets lie in their 192, and are aligned as the
        // node is.
        unsafe {
            let bounds = |offset: usize| _mm256_load_ps(bytes.add(offset).cast());
            let first = [bounds(fx), bounds(fy), bounds(fz)];
            let last = [bounds(96 - fx), bounds(160 - fy), bounds(224 - fz)];
            met(frame, first, last, t_min, t_max, near)
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
    fn record(
        self,
        ray: &Ray,
        words: &[f32],
        record: &Record,
        t_max: f32,
        crossings: &mut Crossings,
    ) -> Verdict {
        // SAFETY: a value of Avx2 exists, so the machine has what it takes.
        unsafe { record::record(&ray.along, words, record, t_max, crossings) }
    }

    #[cold]
    #[inline(never)]
    fn in_doubt<R>(self, task: impl FnOnce() -> R) -> R {
        task()
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
    fn triangle(self, group: &Group, triangle: &Corners, crossings: &mut Crossings) -> Verdict {
        // SAFETY: as above.
        unsafe { bundle::triangle(group, triangle, crossings) }
    }
}

/// The same frame, of which the compiler does not know that. It would spread its numbers over nine registers on the way into a block
/// where two nodes are visited, and keep them in memory for want of registers: a load that spreads a number costs no more than any other.
#[inline(always)]
fn in_place(frame: &Frame) -> &Frame {
    let mut place = core::ptr::from_ref(frame);
    // SAFETY: it does nothing.
    unsafe {
        core::arch::asm!("/* {0} */", inout(reg) place, options(nostack, preserves_flags, readonly));
    }
    // SAFETY: the reference that came in.
    unsafe { &*place }
}

/// The slots of eight boxes that a ray meets, of bounds in the order in which it meets them by axis, and where it enters them.
///
/// # Safety
/// The machine has AVX2 and FMA.
#[inline(always)]
unsafe fn met(
    frame: &Frame,
    [x0, y0, z0]: [__m256; 3],
    [x1, y1, z1]: [__m256; 3],
    t_min: f32,
    t_max: f32,
    near: &mut [f32; 8],
) -> u32 {
    // SAFETY: the caller's; the store is of eight f32.
    unsafe {
        let ix = _mm256_broadcast_ss(&frame.inv[0]);
        let iy = _mm256_broadcast_ss(&frame.inv[1]);
        let iz = _mm256_broadcast_ss(&frame.inv[2]);
        let x0 = _mm256_fmadd_ps(x0, ix, _mm256_broadcast_ss(&frame.near[0]));
        let y0 = _mm256_fmadd_ps(y0, iy, _mm256_broadcast_ss(&frame.near[1]));
        let z0 = _mm256_fmadd_ps(z0, iz, _mm256_broadcast_ss(&frame.near[2]));
        let x1 = _mm256_fmadd_ps(x1, ix, _mm256_broadcast_ss(&frame.far[0]));
        let y1 = _mm256_fmadd_ps(y1, iy, _mm256_broadcast_ss(&frame.far[1]));
        let z1 = _mm256_fmadd_ps(z1, iz, _mm256_broadcast_ss(&frame.far[2]));
        let enter = _mm256_max_ps(_mm256_max_ps(x0, y0), _mm256_max_ps(z0, _mm256_set1_ps(t_min)));
        let leave = _mm256_min_ps(_mm256_min_ps(x1, y1), _mm256_min_ps(z1, _mm256_set1_ps(t_max)));
        _mm256_storeu_ps(near.as_mut_ptr(), enter);
        _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LE_OQ>(enter, leave)) as u32
    }
}
