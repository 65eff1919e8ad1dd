use core::{fmt, num::IntErrorKind};

use super::{DIMENSIONS_MAX, Grid, NODES_MAX, Topology};

/// Why a topology cannot be had.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TopologyError {
    /// The name is not one of the known ones.
    UnknownName,
    /// What follows the colon is not a list of sizes, as in `8x8`, or not one number for a tree.
    BadSizes,
    /// The sizes give another number of nodes than was asked for.
    OtherCount {
        /// The product of the sizes.
        sizes: u32,
        /// The number asked for.
        nodes: u32,
    },
    /// A hypercube has a power of two of nodes.
    NotPowerOfTwo,
    /// No nodes, or more than [`NODES_MAX`].
    Count,
}

impl fmt::Display for TopologyError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::UnknownName => f.write_str(
                "unknown topology: line, ring, mesh[:8x8], torus[:4x4x4], hypercube, tree[:4] and full are known",
            ),
            Self::BadSizes => f.write_str(
                "bad sizes: a mesh or torus takes up to 15 sizes above zero as in 8x8, a tree its number of children, others none: they follow from the number of nodes",
            ),
            Self::OtherCount { sizes, nodes } => {
                write!(f, "the sizes of the topology make {sizes} nodes, not {nodes}")
            }
            Self::NotPowerOfTwo => f.write_str("a hypercube has a power of two of nodes"),
            Self::Count => write!(f, "a mesh has 1 to {NODES_MAX} nodes"),
        }
    }
}

impl core::error::Error for TopologyError {}

impl Topology {
    /// Reads `line`, `ring`, `mesh`, `mesh:8x8`, `torus:4x4x4`, `hypercube`, `tree`, `tree:4` or `full` for a number of nodes.
    ///
    /// A mesh or torus without sizes is the two-dimensional one closest to a square; a tree without a number is binary.
    ///
    /// # Errors
    /// See [`TopologyError`].
    pub fn parse(text: &str, nodes: u32) -> Result<Self, TopologyError> {
        let count = u16::try_from(nodes).ok().filter(|&n| n > 0 && nodes <= NODES_MAX);
        let count = count.ok_or(TopologyError::Count)?;
        // An array of one: the standard library's search for a lone char holds a panic.
        let (name, sizes) = match text.split_once([':']) {
            Some((name, sizes)) => (name, Some(sizes)),
            None => (text, None),
        };
        let plain =
            |topology| if sizes.is_none() { Ok(topology) } else { Err(TopologyError::BadSizes) };
        let grid = |sizes: &[u16], wrap| {
            Grid::new(sizes, wrap).map(Self::Grid).ok_or(TopologyError::Count)
        };
        match name {
            "line" => plain(grid(&[count], false)?),
            "ring" => plain(grid(&[count], true)?),
            "full" => plain(Self::Full { nodes: count }),
            "hypercube" if !count.is_power_of_two() => Err(TopologyError::NotPowerOfTwo),
            "hypercube" => {
                let dimensions = (count.trailing_zeros() as usize).max(1);
                let side = if count == 1 { 1 } else { 2 };
                let sizes = [side; DIMENSIONS_MAX];
                plain(grid(sizes.get(..dimensions).unwrap_or(&[1]), false)?)
            }
            "tree" => {
                let arity = match sizes {
                    Some(arity) => match size(arity) {
                        Err(TopologyError::Count) => u16::MAX,
                        arity => arity?,
                    },
                    None => 2,
                };
                // More children than there are nodes would be ports that nothing is joined to.
                let arity = arity.min(count.saturating_sub(1).max(1));
                Ok(Self::Tree { nodes: count, arity })
            }
            "mesh" | "torus" => {
                let wrap = name == "torus";
                match sizes {
                    Some(sizes) => parse_grid(sizes, nodes, wrap),
                    None => {
                        let [a, b] = nearest_square(count);
                        grid(&[a, b], wrap)
                    }
                }
            }
            _ => Err(TopologyError::UnknownName),
        }
    }
}

/// A size, or a number of children: [`TopologyError::Count`] for one that is greater than any.
fn size(text: &str) -> Result<u16, TopologyError> {
    match text.parse() {
        Ok(0) => Err(TopologyError::BadSizes),
        Ok(size) => Ok(size),
        Err(error) if *error.kind() == IntErrorKind::PosOverflow => Err(TopologyError::Count),
        Err(_) => Err(TopologyError::BadSizes),
    }
}

fn parse_grid(text: &str, nodes: u32, wrap: bool) -> Result<Topology, TopologyError> {
    let mut sizes = [1; DIMENSIONS_MAX];
    let mut dimensions = 0;
    let mut product = 1_u32;
    for part in text.split(['x']) {
        let slot = sizes.get_mut(dimensions).ok_or(TopologyError::BadSizes)?;
        *slot = size(part)?;
        product = product.saturating_mul(u32::from(*slot));
        dimensions += 1;
    }
    if product != nodes {
        return Err(TopologyError::OtherCount { sizes: product, nodes });
    }
    let grid = sizes.get(..dimensions).and_then(|sizes| Grid::new(sizes, wrap));
    grid.map(Topology::Grid).ok_or(TopologyError::Count)
}

/// The two factors of `n` that are nearest to each other, the greater first.
fn nearest_square(n: u16) -> [u16; 2] {
    let lesser = (1..=n.isqrt()).rev().find(|&side| n.checked_rem(side) == Some(0)).unwrap_or(1);
    [n.checked_div(lesser).unwrap_or(n), lesser]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_and_sizes_are_read() {
        let sizes = |text, nodes| match Topology::parse(text, nodes) {
            Ok(Topology::Grid(grid)) => grid.sizes().collect::<std::vec::Vec<_>>(),
            other => panic!("{other:?}"),
        };
        assert_eq!(sizes("torus:8x8", 64), [8, 8]);
        assert_eq!(sizes("mesh", 12), [4, 3]);
        assert_eq!(sizes("mesh", 13), [13, 1]);
        assert_eq!(sizes("torus:4x4x4", 64), [4, 4, 4]);
        assert_eq!(sizes("hypercube", 16), [2, 2, 2, 2]);
        assert_eq!(sizes("hypercube", 1), [1]);
        assert_eq!(sizes("line", 7), [7]);
        let tree = |text, nodes: u16, arity| {
            assert_eq!(Topology::parse(text, nodes.into()), Ok(Topology::Tree { nodes, arity }));
        };
        tree("tree:3", 9, 3);
        tree("tree:8", 9, 8);
        tree("tree:65535", 9, 8);
        tree("tree:70000", 9, 8);
        tree("tree", 1, 1);
    }

    #[test]
    fn what_cannot_be_had_is_refused_by_cause() {
        use TopologyError as E;
        for (text, nodes, error) in [
            ("torus:8x8", 63, E::OtherCount { sizes: 64, nodes: 63 }),
            ("torus:8x", 8, E::BadSizes),
            ("mesh:0x4", 4, E::BadSizes),
            ("mesh:99999999x99999999", 4, E::Count),
            ("mesh:70000x70000", 64, E::Count),
            ("mesh:1x1x1x1x1x1x1x1x1x1x1x1x1x1x1x1", 1, E::BadSizes),
            ("ring:4", 4, E::BadSizes),
            ("tree:0", 4, E::BadSizes),
            ("hypercube", 12, E::NotPowerOfTwo),
            ("ring", 0, E::Count),
            ("ring", 40_000, E::Count),
            ("star", 4, E::UnknownName),
        ] {
            assert_eq!(Topology::parse(text, nodes), Err(error), "{text}");
        }
    }
}
