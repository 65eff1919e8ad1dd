//! The order of octants: front to back for the signs of a ray.

use crate::geometry::PreparedRay;

/// For each code of a node's three split axes, the bits of the slot that are to be flipped.
///
/// The code is the top bits of the first six children, slot 0 lowest.
pub type Octants = [u8; 64];

/// For each combination of a direction's signs (bit 0: x is negative, and so on), the flips.
static FLIPS: [Octants; 8] = flips();

/// For each flip and mask of slots, the mask in the order of visits: bit `k` is slot `k ^ flip`.
#[cfg(feature = "tables")]
static ORDER: [[u8; 256]; 8] = order();

/// The flips of a ray.
#[inline(always)]
#[must_use]
pub fn first_octants(ray: &PreparedRay) -> &'static Octants {
    let sign = |x: f32| usize::from(x < 0.0);
    let signs = sign(ray.inv.x) | sign(ray.inv.y) << 1 | sign(ray.inv.z) << 2;
    let [all_positive, ..] = &FLIPS;
    FLIPS.get(signs).unwrap_or(all_positive)
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

#[cfg(feature = "tables")]
#[allow(clippy::indexing_slicing, reason = "evaluated while compiling")]
const fn order() -> [[u8; 256]; 8] {
    let mut table = [[0; 256]; 8];
    let mut flip = 0;
    while flip < 8 {
        let mut mask = 0;
        while mask < 256 {
            let mut k = 0;
            while k < 8 {
                table[flip][mask] |= ((mask >> (k ^ flip) & 1) << k) as u8;
                k += 1;
            }
            mask += 1;
        }
        flip += 1;
    }
    table
}

/// The mask of slots in the order of visits.
#[cfg(not(feature = "tables"))]
#[inline(always)]
pub(super) fn ordered(mask: u32, flip: u8) -> u32 {
    let flip = u32::from(flip);
    let exchange = |mask: u32, by: u32, low: u32| {
        if flip & by != 0 { (mask & low) << by | mask >> by & low } else { mask }
    };
    exchange(exchange(exchange(mask & 255, 1, 0x55), 2, 0x33), 4, 0x0f)
}

/// The mask of slots in the order of visits.
#[cfg(feature = "tables")]
#[inline(always)]
pub(super) fn ordered(mask: u32, flip: u8) -> u32 {
    ORDER
        .get(usize::from(flip & 7))
        .and_then(|order| order.get((mask & 255) as usize))
        .map_or(0, |&mask| u32::from(mask))
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
