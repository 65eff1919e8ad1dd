//! The children that a ray meets, put down in its order.
//!
//! Slots are brought into the order of the ray, so that the mask of what is met is in that order too; what is met is then moved together
//! (Fuetterling, Lojewski, Pfreundt, Ebert: Accelerated Single Ray Tracing for Wide Vector Units, 2017). There is no branch for how many there are;
//! with AVX2 there is one for a child alone.

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

    /// [`Lanes::visit`](kiloray_core::trace::Lanes::visit) of boxes that were tested: `order` is the ray's word of the node, `first` has its children as well, with
    /// [`Met::lines`]. With a tag they get it and their places; without one a child alone need not be put down.
    ///
    /// # Safety
    /// The machine has AVX2, and this is possible.
    unsafe fn put_down(
        hits: &Hits,
        turn: Turn,
        order: u32,
        children: Children<'_>,
        first: impl Fn(usize) -> (u32, u8),
        tag: Option<u32>,
        to: Places<'_>,
    ) -> Met;
}

/// The children of a node, by slot.
#[derive(Debug, Clone, Copy)]
pub enum Children<'n> {
    /// Eight numbers of two bytes.
    Stored(__m128i),
    /// Of four bytes, as they are in the top, and their lines.
    Expanded(__m256i, &'n [u8; 8]),
}

/// With a table of all masks.
#[derive(Debug, Clone, Copy)]
pub struct ByTable;

/// By the instructions of AVX-512.
#[derive(Debug, Clone, Copy)]
pub struct ByCompression;

const NONE: Met = Met { count: 0, first: 0, lines: 0 };

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
    children: Children<'_>,
    tag: Option<u32>,
) -> Ordered {
    // SAFETY: by the caller; the load is of eight numbers.
    unsafe {
        let shifts = &SHIFTS[usize::from(turn.is_backward())];
        let shifts = _mm256_loadu_si256(shifts.as_ptr().cast());
        let slots = _mm256_srlv_epi32(_mm256_set1_epi32(order as i32), shifts);
        let children = match children {
            Children::Stored(children) => _mm256_cvtepu16_epi32(children),
            Children::Expanded(children, _) => children,
        };
        let mut child = _mm256_permutevar8x32_epi32(children, slots);
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

/// For each mask of places, where the last eight come from, those of the mask at the end, in their order.
#[repr(align(64))]
struct Together([[u8; 8]; 256]);

static TOGETHER: Together = Together(together());

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

/// Where the places of a mask come from, in eight bytes.
///
/// # Safety
/// The machine has AVX2.
#[inline(always)]
unsafe fn from(mask: u32) -> __m128i {
    // SAFETY: by the caller; the load is of one mask's row.
    unsafe { _mm_loadl_epi64(TOGETHER.0[mask as usize & 255].as_ptr().cast()) }
}

/// How the eight slots of a word become bytes: of each the two bytes of the word that it lies in, and what takes it to their top.
#[repr(align(16))]
struct Lift {
    bytes: [[u8; 2]; 8],
    factor: [u16; 8],
}

/// Forward and backward.
static LIFTS: [Lift; 2] = [lift(false), lift(true)];

const fn lift(backward: bool) -> Lift {
    let mut lift = Lift { bytes: [[0; 2]; 8], factor: [0; 8] };
    let mut place = 0;
    while place < 8 {
        let bit = 3 * if backward { 7 - place } else { place };
        let byte = bit / 8;
        lift.bytes[place] = [byte as u8, byte as u8 + 1];
        lift.factor[place] = 1 << (13 - bit % 8);
        place += 1;
    }
    lift
}

/// The slots of a word in the order of a ray, in eight bytes.
///
/// # Safety
/// The machine has AVX2.
#[inline(always)]
unsafe fn slots(turn: Turn, order: u32) -> __m128i {
    let Lift { bytes, factor } = &LIFTS[usize::from(turn.is_backward())];
    // SAFETY: by the caller; loads are of whole arrays, as aligned as what they lie in.
    unsafe {
        let word =
            _mm_shuffle_epi8(_mm_set1_epi32(order as i32), _mm_load_si128(bytes.as_ptr().cast()));
        let top = _mm_mullo_epi16(word, _mm_load_si128(factor.as_ptr().cast()));
        let slots = _mm_srli_epi16::<13>(top);
        _mm_packus_epi16(slots, slots)
    }
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

    /// Compares first, and brings the verdicts, of a byte each, into the order: moving 32 bytes across their halves takes eight cycles on some
    /// machines, and the next node waits for the mask.
    #[inline(always)]
    unsafe fn put_down(
        hits: &Hits,
        turn: Turn,
        order: u32,
        children: Children<'_>,
        first: impl Fn(usize) -> (u32, u8),
        tag: Option<u32>,
        to: Places<'_>,
    ) -> Met {
        // SAFETY: by the caller; the stores are of eight numbers each.
        unsafe {
            let met = _mm256_cmp_ps::<_CMP_LE_OQ>(hits.enter, hits.leave);
            let any = _mm256_movemask_ps(met) as u32;
            if any == 0 {
                return NONE;
            }
            if any & any.wrapping_sub(1) == 0 {
                // So it is with about half of all nodes, and the next one need not wait for the order.
                let slot = any.trailing_zeros();
                let (first, lines) = first(slot as usize);
                let Some(tag) = tag else { return Met { count: 1, first, lines } };
                let first = first | tag | turn.place(order, slot as usize) << 16;
                let slot = _mm256_castsi128_si256(_mm_cvtsi32_si128(slot as i32));
                if let Some(near) = to.near {
                    near[7] = _mm256_cvtss_f32(_mm256_permutevar8x32_ps(hits.enter, slot));
                }
                to.entry[7] = first;
                return Met { count: 1, first, lines };
            }
            let slots = slots(turn, order);
            let met = _mm256_castps_si256(met);
            let met =
                _mm_packs_epi32(_mm256_castsi256_si128(met), _mm256_extracti128_si256::<1>(met));
            let met = _mm_shuffle_epi8(_mm_packs_epi16(met, _mm_setzero_si128()), slots);
            let mask = _mm_movemask_epi8(met) as u32 & 0xff;
            let from = from(mask);
            let index = _mm256_cvtepu8_epi32(_mm_shuffle_epi8(slots, from));
            let children = match children {
                Children::Stored(children) => _mm256_cvtepu16_epi32(children),
                Children::Expanded(children, _) => children,
            };
            let mut entry = _mm256_permutevar8x32_epi32(children, index);
            if let Some(tag) = tag {
                let places = _mm256_slli_epi32::<16>(_mm256_cvtepu8_epi32(from));
                let tag = _mm256_set1_epi32(tag as i32);
                entry = _mm256_or_si256(_mm256_or_si256(entry, tag), places);
            }
            if let Some(near) = to.near {
                let enter = _mm256_permutevar8x32_ps(hits.enter, index);
                _mm256_storeu_ps(near.as_mut_ptr(), enter);
            }
            _mm256_storeu_si256(to.entry.as_mut_ptr().cast(), entry);
            // Not from there: the next node waits for it.
            let place = mask.trailing_zeros();
            let (first, lines) = first(turn.slot(order, place));
            let first = first | tag.map_or(0, |tag| tag | place << 16);
            Met { count: mask.count_ones(), first, lines }
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
        children: Children<'_>,
        _: impl Fn(usize) -> (u32, u8),
        tag: Option<u32>,
        to: Places<'_>,
    ) -> Met {
        // SAFETY: by the caller; the stores are of eight numbers each.
        unsafe {
            let Ordered { enter, leave, child } = in_order(hits, turn, order, children, tag);
            let mask = _mm256_cmp_ps_mask::<_CMP_LE_OQ>(enter, leave);
            if mask == 0 {
                return NONE;
            }
            // The next node waits for the first. What waits longer goes by the table: places that begin anywhere would take a mask of their own.
            let first = _mm256_cvtsi256_si32(_mm256_maskz_compress_epi32(mask, child)) as u32;
            let from = _mm256_cvtepu8_epi32(from(mask.into()));
            if let Some(near) = to.near {
                _mm256_storeu_ps(near.as_mut_ptr(), _mm256_permutevar8x32_ps(enter, from));
            }
            let entry = _mm256_permutevar8x32_epi32(child, from);
            _mm256_storeu_si256(to.entry.as_mut_ptr().cast(), entry);
            let lines = match children {
                Children::Stored(_) => 0,
                Children::Expanded(_, lines) => lines[turn.slot(order, mask.trailing_zeros())],
            };
            Met { count: mask.count_ones(), first, lines }
        }
    }
}
