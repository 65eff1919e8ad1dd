//! The bits of a child, as the traversal asks them: an enum decoded at every visit costs a jump more.

use crate::block::format::Child;

/// No child.
pub(super) const EMPTY: u16 = Child::EMPTY;
/// The index of a node or reference, or the first record of a leaf.
pub(super) const INDEX: u16 = 0x0fff;
/// Bit 15 means nothing.
const KIND: u16 = 0x7000;

/// A node of the same block.
#[inline(always)]
pub(super) const fn is_node(child: u16) -> bool {
    child & KIND == NODE
}

/// Records.
#[inline(always)]
pub(super) const fn is_leaf(child: u16) -> bool {
    child & LEAF != 0
}

/// A node of another block.
#[inline(always)]
pub(super) const fn is_ref(child: u16) -> bool {
    child & KIND == REF
}

/// Where the records of a leaf begin, and how many there are.
#[inline(always)]
pub(super) const fn records(leaf: u16) -> (u16, u16) {
    (leaf & INDEX, (leaf >> 12 & 3) + 1)
}

const NODE: u16 = Child::Node(0).encode();
const REF: u16 = Child::Ref(0).encode();
/// The bit of a leaf.
pub(super) const LEAF: u16 = 0x4000;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bits_are_read_as_they_decode() {
        for bits in 0..=u16::MAX {
            match Child::decode(bits) {
                Child::Node(i) => assert!(is_node(bits) && i == bits & INDEX),
                Child::Ref(i) => assert!(is_ref(bits) && i == bits & INDEX),
                Child::Leaf { at, count } => {
                    assert!(is_leaf(bits) && records(bits) == (at, count));
                }
                Child::Empty => assert!(!is_node(bits) && !is_ref(bits) && !is_leaf(bits)),
            }
            let kinds = [is_node(bits), is_ref(bits), is_leaf(bits)];
            assert!(kinds.into_iter().filter(|&kind| kind).count() <= 1);
        }
    }
}
