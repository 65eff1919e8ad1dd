use super::{Hop, NODES_MAX, NodeId, Port};

/// Most dimensions of a grid: a hypercube of [`NODES_MAX`] nodes has 15.
pub const DIMENSIONS_MAX: usize = 15;

/// Nodes at the integer points of a box, in one or more dimensions, the first counting fastest.
///
/// Ports: `2 d` leads down dimension `d`, `2 d + 1` up.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Grid {
    /// Size of each dimension; 1 beyond the last.
    size: [u16; DIMENSIONS_MAX],
    dimensions: u8,
    nodes: u16,
    /// The ends of a dimension are next to each other; a dimension of two does not need it.
    wrap: bool,
}

impl Grid {
    /// A box of these sizes. `None` if one is zero, or there are too many dimensions or nodes.
    #[must_use]
    pub fn new(sizes: &[u16], wrap: bool) -> Option<Self> {
        let mut size = [1; DIMENSIONS_MAX];
        size.get_mut(..sizes.len())?.copy_from_slice(sizes);
        let nodes = sizes.iter().try_fold(1_u32, |n, &s| n.checked_mul(u32::from(s)))?;
        let in_range = (1..=NODES_MAX).contains(&nodes) && !sizes.is_empty();
        in_range.then_some(Self { size, dimensions: sizes.len() as u8, nodes: nodes as u16, wrap })
    }

    /// Number of nodes.
    #[must_use]
    pub fn nodes(&self) -> u16 {
        self.nodes
    }

    /// Sizes by dimension.
    pub fn sizes(&self) -> impl Iterator<Item = u16> {
        self.size.into_iter().take(usize::from(self.dimensions))
    }

    /// Whether any dimension wraps round.
    #[must_use]
    pub fn wraps(&self) -> bool {
        self.wrap && self.size.iter().any(|&s| s > 2)
    }

    pub(super) fn ports(&self) -> u16 {
        2 * u16::from(self.dimensions)
    }

    pub(super) fn neighbour(&self, node: NodeId, port: u16) -> Option<NodeId> {
        let (place, size, stride) = self.place(node, port / 2)?;
        let ring = self.wrap && size > 2;
        let next = match port % 2 {
            0 if place > 0 => place - 1,
            0 if ring => size - 1,
            1 if place + 1 < size => place + 1,
            1 if ring => 0,
            _ => return None,
        };
        Some(NodeId((u32::from(node.0) + next * stride - place * stride) as u16))
    }

    /// Dimension order: the first dimension in which the two differ. On a ring the shorter way, upwards if both are alike.
    ///
    /// Class 0 is for packets that still have to cross the seam between the ends of the dimension, class 1
    /// for those that do not: the channels of a class are then used in one direction only, and no cycle closes.
    pub(super) fn route(&self, here: NodeId, to: NodeId) -> Option<Hop> {
        let (mut here, mut to) = (u32::from(here.0), u32::from(to.0));
        let sizes = self.size.iter().take(self.dimensions.into());
        for (size, dimension) in sizes.map(|&size| u32::from(size)).zip(0..) {
            let (a, b) = (here.checked_rem(size)?, to.checked_rem(size)?);
            if a == b {
                (here, to) = (here.checked_div(size)?, to.checked_div(size)?);
                continue;
            }
            let ring = self.wrap && size > 2;
            let up = if ring { 2 * ((b + size - a) % size) <= size } else { b > a };
            let crosses = (b > a) != up;
            return Some(Hop {
                port: Port(2 * dimension + u16::from(up)),
                class: u8::from(ring && !crosses),
            });
        }
        None
    }

    /// Steps along all dimensions, on a ring the shorter way.
    pub(super) fn distance(&self, a: NodeId, b: NodeId) -> u16 {
        let steps = (0..u16::from(self.dimensions)).filter_map(|dimension| {
            let (a, size, _) = self.place(a, dimension)?;
            let (b, ..) = self.place(b, dimension)?;
            let steps = a.abs_diff(b);
            Some(if self.wrap { steps.min(size.saturating_sub(steps)) } else { steps })
        });
        steps.fold(0_u32, u32::saturating_add) as u16
    }

    /// Half round every ring, at the end of every line.
    pub(super) fn antipode(&self) -> NodeId {
        let number = (0..u16::from(self.dimensions)).filter_map(|dimension| {
            let (_, size, stride) = self.place(NodeId(0), dimension)?;
            let place = if self.wrap { size / 2 } else { size.saturating_sub(1) };
            Some(place.saturating_mul(stride))
        });
        NodeId(number.fold(0_u32, u32::saturating_add) as u16)
    }

    /// Where a node lies in a dimension, the size of the dimension, and the distance of neighbours' numbers.
    fn place(&self, node: NodeId, dimension: u16) -> Option<(u32, u32, u32)> {
        let before = self.size.get(..usize::from(dimension))?;
        let size = u32::from(*self.size.get(usize::from(dimension))?);
        let stride = before.iter().fold(1_u32, |n, &s| n.saturating_mul(u32::from(s)));
        let place = u32::from(node.0).checked_div(stride)?.checked_rem(size)?;
        Some((place, size, stride))
    }
}
