//! The children that a ray meets, put down in its order.
//!
//! Slots are brought into the order of the ray first, then compared, so that the mask of what is met is in that order too; what is met
//! is then moved together (Fuetterling, Lojewski, Pfreundt, Ebert: Accelerated Single Ray Tracing for Wide Vector Units, 2017). There is no
//! branch for how many there are.

#[allow(clippy::wildcard_imports, reason = "a kernel names a hundred instructions")]
use core::arch::x86_64::*;
use core::fmt::Debug;

use kiloray_core::real::Part;
use kiloray_core::trace::{Met, Places, Turn};

use super::boxes::Hits;

/// How children are moved together. What it takes beside AVX2 a machine must have.
pub trait PutDown: Copy + Debug {
    /// Whether this machine can do it.
    fn is_possible() -> bool;

    /// Does a part in a function of its own that is compiled for such a machine.
    ///
    /// # Safety
    /// The machine has AVX2, and this is possible.
    unsafe fn apart<T: Part>(part: T) -> T::Result;

    /// [`Lanes::visit`](kiloray_core::trace::Lanes::visit) of boxes that were tested: `order` is the ray's word of the node, `child` its children by slot, as `first` has
    /// them. With a tag they get it and their places.
    ///
    /// # Safety
    /// The machine has AVX2, and this is possible.
    unsafe fn put_down(
        hits: &Hits,
        turn: Turn,
        order: u32,
        child: __m256i,
        first: impl Fn(usize) -> u32,
        tag: Option<u32>,
        to: Places<'_>,
    ) -> Met;
}

/// With a table of all masks.
#[derive(Debug, Clone, Copy)]
pub struct ByTable;

/// By the instructions of AVX-512.
#[derive(Debug, Clone, Copy)]
pub struct ByCompression;

const NONE: Met = Met { count: 0, first: 0 };

/// By which slots come down from a word, forward and backward: place `k` lies `SHIFTS[_][k]` bits up.
static SHIFTS: [[u32; 8]; 2] = [[0, 3, 6, 9, 12, 15, 18, 21], [21, 18, 15, 12, 9, 6, 3, 0]];

/// `Lanes::by_place`.
///
/// # Safety
/// The machine has AVX2.
#[inline(always)]
pub(super) unsafe fn by_place(turn: Turn, order: u32, slots: u8) -> u8 {
    // SAFETY: by the caller; the load is of eight numbers.
    unsafe {
        let shifts = &SHIFTS[usize::from(turn.is_backward())];
        let shifts = _mm256_loadu_si256(shifts.as_ptr().cast());
        let slot = _mm256_srlv_epi32(_mm256_set1_epi32(order as i32), shifts);
        let slot = _mm256_and_si256(slot, _mm256_set1_epi32(7));
        // The bit of the slot becomes the sign.
        let top = _mm256_sub_epi32(_mm256_set1_epi32(31), slot);
        let met = _mm256_sllv_epi32(_mm256_set1_epi32(slots.into()), top);
        _mm256_movemask_ps(_mm256_castsi256_ps(met)) as u8
    }
}

/// Slots in the order of a ray.
struct Ordered {
    enter: __m256,
    leave: __m256,
    /// Children, with what they get.
    child: __m256i,
}

/// # Safety
/// The machine has AVX2.
#[inline(always)]
unsafe fn in_order(
    hits: &Hits,
    turn: Turn,
    order: u32,
    child: __m256i,
    tag: Option<u32>,
) -> Ordered {
    // SAFETY: by the caller; the load is of eight numbers.
    unsafe {
        let shifts = &SHIFTS[usize::from(turn.is_backward())];
        let shifts = _mm256_loadu_si256(shifts.as_ptr().cast());
        let slots = _mm256_srlv_epi32(_mm256_set1_epi32(order as i32), shifts);
        let mut child = _mm256_permutevar8x32_epi32(child, slots);
        if let Some(tag) = tag {
            let places =
                _mm256_setr_epi32(0, 1 << 16, 2 << 16, 3 << 16, 4 << 16, 5 << 16, 6 << 16, 7 << 16);
            child = _mm256_or_si256(child, _mm256_or_si256(places, _mm256_set1_epi32(tag as i32)));
        }
        Ordered {
            enter: _mm256_permutevar8x32_ps(hits.enter, slots),
            leave: _mm256_permutevar8x32_ps(hits.leave, slots),
            child,
        }
    }
}

/// For each mask of places, where the last eight come from: those of the mask at the end, in their order.
static TOGETHER: [[u8; 8]; 256] = together();

const fn together() -> [[u8; 8]; 256] {
    let mut table = [[0; 8]; 256];
    let mut mask = 0;
    while mask < 256 {
        let (mut to, mut place) = (8, 8);
        while place > 0 {
            place -= 1;
            if mask >> place & 1 == 1 {
                to -= 1;
                table[mask][to] = place as u8;
            }
        }
        mask += 1;
    }
    table
}

impl PutDown for ByTable {
    fn is_possible() -> bool {
        true
    }

    #[inline(never)]
    #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
    unsafe fn apart<T: Part>(part: T) -> T::Result {
        part.run()
    }

    #[inline(always)]
    unsafe fn put_down(
        hits: &Hits,
        turn: Turn,
        order: u32,
        child: __m256i,
        first: impl Fn(usize) -> u32,
        tag: Option<u32>,
        to: Places<'_>,
    ) -> Met {
        // SAFETY: by the caller; the load is of eight bytes, the stores of eight numbers each.
        unsafe {
            let Ordered { enter, leave, child } = in_order(hits, turn, order, child, tag);
            let mask = _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LE_OQ>(enter, leave)) as u32;
            if mask == 0 {
                return NONE;
            }
            let from = _mm_loadl_epi64(TOGETHER[mask as usize & 255].as_ptr().cast());
            let from = _mm256_cvtepu8_epi32(from);
            let near = _mm256_permutevar8x32_ps(enter, from);
            let entry = _mm256_permutevar8x32_epi32(child, from);
            _mm256_storeu_ps(to.near.as_mut_ptr(), near);
            _mm256_storeu_si256(to.entry.as_mut_ptr().cast(), entry);
            // Not from there: the next node waits for it.
            let place = mask.trailing_zeros();
            let first = first(turn.slot(order, place)) | tag.map_or(0, |tag| tag | place << 16);
            Met { count: mask.count_ones(), first }
        }
    }
}

impl PutDown for ByCompression {
    fn is_possible() -> bool {
        std::is_x86_feature_detected!("avx512f")
            && std::is_x86_feature_detected!("avx512vl")
            && std::is_x86_feature_detected!("avx512bw")
            && std::is_x86_feature_detected!("avx512dq")
    }

    #[inline(never)]
    #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt,avx512f,avx512vl,avx512bw,avx512dq")]
    unsafe fn apart<T: Part>(part: T) -> T::Result {
        part.run()
    }

    #[inline(always)]
    unsafe fn put_down(
        hits: &Hits,
        turn: Turn,
        order: u32,
        child: __m256i,
        _: impl Fn(usize) -> u32,
        tag: Option<u32>,
        to: Places<'_>,
    ) -> Met {
        // SAFETY: by the caller; the load is of eight bytes, the stores of eight numbers each.
        unsafe {
            let Ordered { enter, leave, child } = in_order(hits, turn, order, child, tag);
            let mask = _mm256_cmp_ps_mask::<_CMP_LE_OQ>(enter, leave);
            if mask == 0 {
                return NONE;
            }
            // The next node waits for the first. What waits longer goes by the table: places that begin anywhere would take a mask of their own.
            let first = _mm256_cvtsi256_si32(_mm256_maskz_compress_epi32(mask, child)) as u32;
            let from = _mm_loadl_epi64(TOGETHER[usize::from(mask)].as_ptr().cast());
            let from = _mm256_cvtepu8_epi32(from);
            _mm256_storeu_ps(to.near.as_mut_ptr(), _mm256_permutevar8x32_ps(enter, from));
            let entry = _mm256_permutevar8x32_epi32(child, from);
            _mm256_storeu_si256(to.entry.as_mut_ptr().cast(), entry);
            Met { count: mask.count_ones(), first }
        }
    }
}
