//! The order of octants: front to back for the signs of a ray.

use crate::geometry::PreparedRay;

/// For each code of a node's three split axes, the bits of the slot that are to be flipped.
///
/// The code is the top bits of the first six children, slot 0 lowest.
pub type Octants = [u8; 64];

/// For each combination of a direction's signs (bit 0: x is negative, and so on), the flips.
static FLIPS: [Octants; 8] = flips();

/// For each flip and mask of slots the bits of its [`Visits`].
#[cfg(feature = "tables")]
static VISITS: [[u16; 256]; 8] = visits();

/// The flips of a ray.
#[inline(always)]
#[must_use]
pub fn first_octants(ray: &PreparedRay) -> &'static Octants {
    let sign = |x: f32| usize::from(x < 0.0);
    let signs = sign(ray.inv.x) | sign(ray.inv.y) << 1 | sign(ray.inv.z) << 2;
    let [all_positive, ..] = &FLIPS;
    FLIPS.get(signs).unwrap_or(all_positive)
}

/// The flips of a node whose axes have this code.
#[inline(always)]
pub(super) fn flip_of(octants: &Octants, axes: u8) -> u8 {
    octants.get(usize::from(axes)).copied().unwrap_or(0)
}

#[allow(clippy::indexing_slicing, reason = "evaluated while compiling")]
const fn flips() -> [Octants; 8] {
    let mut table = [[0; 64]; 8];
    let mut signs = 0;
    while signs < 8 {
        let mut code = 0;
        while code < 64 {
            let mut flip = 0;
            let mut plane = 0;
            while plane < 3 {
                let axis = code >> (2 * plane) & 3;
                let axis = if axis > 2 { 2 } else { axis };
                flip |= ((signs >> axis & 1) << (2 - plane)) as u8;
                plane += 1;
            }
            table[signs][code] = flip;
            code += 1;
        }
        signs += 1;
    }
    table
}

/// Which slots of a mask are visited in which order. One number, so that the first is known as soon as possible: the next node
/// waits for it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Visits(u16);

impl Visits {
    const fn new(mask: u32, flip: u32) -> Self {
        let ordered = permuted(mask, flip);
        let first = if ordered == 0 { 0 } else { ordered.trailing_zeros() ^ flip };
        Self((first | (ordered & ordered.wrapping_sub(1)) << 8) as u16)
    }

    /// The slots of a mask.
    #[cfg(not(feature = "tables"))]
    #[inline(always)]
    pub(super) fn of(mask: u32, flip: u8) -> Self {
        Self::new(mask & 255, u32::from(flip & 7))
    }

    /// The slots of a mask.
    #[cfg(feature = "tables")]
    #[inline(always)]
    pub(super) fn of(mask: u32, flip: u8) -> Self {
        let visits = VISITS.get(usize::from(flip & 7));
        Self(visits.and_then(|visits| visits.get((mask & 255) as usize)).copied().unwrap_or(0))
    }

    /// The slot that is visited first; without any, 0.
    #[inline(always)]
    pub(super) fn first(self) -> u32 {
        u32::from(self.0 & 7)
    }

    /// All of a mask that is not empty: bit `k` is slot `k ^ flip`.
    #[inline(always)]
    pub(super) fn all(self, flip: u8) -> u8 {
        self.others() | 1 << ((self.0 as u8 ^ flip) & 7)
    }

    /// The others: bit `k` is slot `k ^ flip`.
    #[inline(always)]
    pub(super) fn others(self) -> u8 {
        (self.0 >> 8) as u8
    }
}

#[cfg(feature = "tables")]
#[allow(clippy::indexing_slicing, reason = "evaluated while compiling")]
const fn visits() -> [[u16; 256]; 8] {
    let mut table = [[0; 256]; 8];
    let mut flip = 0;
    while flip < 8 {
        let mut mask = 0;
        while mask < 256 {
            table[flip][mask] = Visits::new(mask as u32, flip as u32).0;
            mask += 1;
        }
        flip += 1;
    }
    table
}

/// The mask of slots in the order of visits: bit `k` is slot `k ^ flip`.
#[inline(always)]
pub(super) const fn ordered(mask: u32, flip: u8) -> u32 {
    permuted(mask & 255, flip as u32)
}

#[inline(always)]
const fn permuted(mut mask: u32, flip: u32) -> u32 {
    if flip & 1 != 0 {
        mask = (mask & 0x55) << 1 | mask >> 1 & 0x55;
    }
    if flip & 2 != 0 {
        mask = (mask & 0x33) << 2 | mask >> 2 & 0x33;
    }
    if flip & 4 != 0 {
        mask = (mask & 0x0f) << 4 | mask >> 4 & 0x0f;
    }
    mask
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::block::format::Node;
    use crate::geometry::Ray;
    use glam::Vec3;

    #[test]
    fn the_octant_on_the_near_side_of_all_planes_is_first() {
        for signs in 0..8 {
            let d = [0, 1, 2].map(|a| if signs >> a & 1 == 1 { -1.0 } else { 1.0 });
            let ray =
                Ray { origin: Vec3::ZERO, direction: Vec3::from_array(d), t_min: 0.0, t_max: 1.0 };
            let octants = first_octants(&PreparedRay::new(&ray));
            for (code, &flip) in octants.iter().enumerate() {
                let mut node = Node::EMPTY;
                for slot in 0..6 {
                    node.child[slot] |= ((code >> slot & 1) as u16) << 15;
                }
                let [a0, a1, a2] = node.axes().map(|a| u8::from(d[usize::from(a)] < 0.0));
                assert_eq!(flip, a0 << 2 | a1 << 1 | a2);
            }
        }
    }

    #[test]
    fn visits_are_the_first_of_the_order_and_the_others() {
        for flip in 0..8 {
            for mask in 0..256 {
                let order: Vec<u32> = (0..8)
                    .map(|k| k ^ u32::from(flip))
                    .filter(|slot| mask >> slot & 1 == 1)
                    .collect();
                let visits = Visits::of(mask, flip);
                assert_eq!(visits.first(), order.first().copied().unwrap_or(0));
                let others = order.iter().skip(1).map(|slot| 1 << (slot ^ u32::from(flip)));
                assert_eq!(u32::from(visits.others()), others.sum::<u32>());
                if mask != 0 {
                    assert_eq!(u32::from(visits.all(flip)), ordered(mask, flip));
                }
            }
        }
    }

    #[test]
    fn order_is_a_permutation_of_the_mask() {
        assert_eq!(ordered(0b0000_0001, 0), 0b0000_0001);
        assert_eq!(ordered(0b0000_0001, 7), 0b1000_0000);
        assert_eq!(ordered(0b0001_0010, 4), 0b0010_0001);
        for flip in 0..8 {
            for mask in 0..256 {
                assert_eq!(ordered(ordered(mask, flip), flip), mask);
            }
        }
    }
}
