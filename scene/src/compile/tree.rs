//! The tree between build and cut.

use kiloray_core::block::format::Node as StoredNode;

use super::bounds::Bounds;

/// What is in a slot.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kid {
    Empty,
    /// A node: a greater index than its parent's.
    Node(u32),
    /// Items, of one leaf.
    Leaf {
        first: u32,
        count: u32,
    },
}

/// Up to eight children.
#[derive(Debug, Clone)]
pub(crate) struct Node {
    pub(crate) bounds: [Bounds; 8],
    pub(crate) kids: [Kid; 8],
    /// As it is stored.
    pub(crate) order: [u32; 4],
}

impl Node {
    pub(crate) const EMPTY: Self =
        Self { bounds: [Bounds::EMPTY; 8], kids: [Kid::Empty; 8], order: StoredNode::EMPTY.order };

    /// The nodes below, in the order of the slots.
    pub(crate) fn nodes(&self) -> impl DoubleEndedIterator<Item = (usize, u32)> {
        self.kids.iter().enumerate().filter_map(|(slot, kid)| match *kid {
            Kid::Node(node) => Some((slot, node)),
            _ => None,
        })
    }

    /// The leaves below: first item and count.
    pub(crate) fn leaves(&self) -> impl Iterator<Item = (usize, u32, u32)> {
        self.kids.iter().enumerate().filter_map(|(slot, kid)| match *kid {
            Kid::Leaf { first, count } => Some((slot, first, count)),
            _ => None,
        })
    }

    pub(crate) fn all(&self) -> Bounds {
        let mut all = Bounds::EMPTY;
        for bounds in &self.bounds {
            all.grow(&bounds.0);
        }
        all
    }

    pub(crate) fn area(&self) -> f32 {
        self.all().area()
    }
}
