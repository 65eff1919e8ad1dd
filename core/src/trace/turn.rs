//! In which order a ray visits the slots of nodes.

use glam::Vec3;

/// The way of a ray through the slots of any node: a word of [`Node::order`](crate::block::format::Node::order), from its front or from
/// its back. It follows from the signs of the ray's direction.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Turn {
    word: u8,
    /// 0, or 7: places count from the back.
    flip: u8,
}

impl Turn {
    /// The way of rays in about this direction.
    #[inline(always)]
    pub(super) fn along(direction: Vec3) -> Self {
        let sign = |x: f32| u8::from(x < 0.0);
        Self::new(sign(direction.x) | sign(direction.y) << 1 | sign(direction.z) << 2, false)
    }

    /// The way of rays that descend the axes of these bits, or from their far end.
    #[inline(always)]
    #[must_use]
    pub const fn new(signs: u8, from_end: bool) -> Self {
        let backward = (signs & 4 != 0) != from_end;
        Self {
            word: if signs & 4 == 0 { signs & 3 } else { !signs & 3 },
            flip: if backward { 7 } else { 0 },
        }
    }

    /// The index of its word.
    #[inline(always)]
    #[must_use]
    pub const fn word(self) -> usize {
        self.word as usize
    }

    /// Whether it goes through the word from its back.
    #[inline(always)]
    #[must_use]
    pub const fn is_backward(self) -> bool {
        self.flip != 0
    }

    /// Its word of a node.
    #[inline(always)]
    #[must_use]
    pub fn of_node(self, order: &[u32; 4]) -> u32 {
        order.get(self.word()).copied().unwrap_or(0)
    }

    /// The slot in a place, 0 to 7, of this word.
    #[inline(always)]
    #[must_use]
    pub const fn slot(self, order: u32, place: u32) -> usize {
        (order >> (3 * ((place & 7) ^ self.flip as u32)) & 7) as usize
    }

    /// The place, 0 to 7, of a slot in this word.
    #[inline(always)]
    #[must_use]
    pub const fn place(self, order: u32, slot: usize) -> u32 {
        const ONES: u32 = 0o1111_1111;
        // The three bits of the place are those that differ nowhere.
        let differ = order ^ ((slot as u32 & 7) * ONES);
        let same = !(differ | differ >> 1 | differ >> 2) & ONES;
        let place = same.trailing_zeros() / 3;
        (place & 7) ^ self.flip as u32
    }

    /// A mask of slots by place.
    #[inline(always)]
    pub(super) fn by_place(self, order: u32, mask: u32) -> u32 {
        (0..8).fold(0, |all, place| all | (mask >> self.slot(order, place) & 1) << place)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::block::format::{Node, order_of};
    use crate::geometry::{PreparedRay, Ray};

    #[test]
    fn a_ray_and_its_opposite_go_through_the_same_word() {
        let slots = [3, 1, 7, 0, 2, 6, 5, 4];
        let order = [0, 1, 2, 3].map(|i| order_of(slots.map(|slot| slot ^ i)));
        let node = Node { order, ..Node::EMPTY };
        for signs in 0..8_u8 {
            let direction = [0, 1, 2].map(|a| if signs >> a & 1 == 1 { -1.0 } else { 1.0 });
            let direction = Vec3::from_array(direction);
            let ray = Ray { origin: Vec3::ZERO, direction, t_min: 0.0, t_max: 1.0 };
            let turn = Turn::new(PreparedRay::new(&ray).signs, false);
            assert_eq!(turn, Turn::along(direction));
            let back = Turn::new(signs, true);
            assert_eq!((back.word(), back.is_backward()), (turn.word(), !turn.is_backward()));
            let descends = if signs < 4 { signs } else { 7 - signs };
            assert_eq!(turn.word(), usize::from(descends));
            let word = turn.of_node(&node.order);
            let mut visited = slots.map(|slot| usize::from(slot ^ descends));
            if signs >= 4 {
                visited.reverse();
            }
            assert_eq!(std::array::from_fn(|place| turn.slot(word, place as u32)), visited);
            for (place, &slot) in visited.iter().enumerate() {
                assert_eq!(turn.place(word, slot), place as u32);
            }
            let mask = 0b0110_1001;
            let by_place = turn.by_place(word, mask);
            for (place, slot) in visited.into_iter().enumerate() {
                assert_eq!(by_place >> place & 1, mask >> slot & 1);
            }
        }
    }
}
