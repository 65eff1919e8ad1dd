use bytemuck::{Pod, Zeroable};

/// Where a traversal is, in the fewest bytes: what a parked or migrating ray carries beside the ray and its best hit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct Trail {
    /// Three bits a level, the root's lowest: the octant taken there, by its place in the ray's order.
    path: [u32; 3],
    /// The block that comes next.
    block: u32,
    /// The child that is visited there, as its bits.
    child: u16,
    /// The level of that child.
    depth: u8,
    /// Levels above this one are known by the path alone.
    base: u8,
}

impl Trail {
    /// Before the root.
    pub const START: Self = Self { path: [0; 3], block: 0, child: 0, depth: 0, base: 0 };

    /// The block that it needs next.
    #[must_use]
    pub const fn block(&self) -> u32 {
        self.block
    }
}
