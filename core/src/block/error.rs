use core::fmt;

/// Why the bytes of a block are refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum BlockError {
    /// The bytes do not begin at a multiple of 16 in memory.
    Alignment,
    /// The length is not the file's block size, or not a power of two from 1 to 64 KiB.
    Length,
    /// The checksum does not match.
    Checksum,
    /// It is another block than was asked for.
    Number {
        /// The number in its header.
        found: u32,
    },
    /// Origin or scale of the frame: not finite, not a power of two, or out of range.
    Frame,
    /// Its parts do not fit its length, or a count is out of range.
    Counts,
    /// A flag or a byte that must be zero is not.
    Reserved,
    /// A child that is undefined, out of range, not behind its parent, or had twice.
    Child {
        /// The node.
        node: u16,
        /// The slot.
        slot: u8,
    },
    /// An order of a node's slots that does not name each of them once.
    Order {
        /// The node.
        node: u16,
    },
    /// Levels or nesting: more than the header says, or than the format allows.
    Depth,
    /// A record: no primitive, an index out of range, or a material that the scene does not have.
    Record {
        /// Its index.
        record: u16,
    },
    /// Spheres, which this build leaves out.
    SpheresLeftOut,
    /// A vertex that does not lie in the cube [-1, 1]³.
    Vertex {
        /// Its index.
        vertex: u16,
    },
    /// A reference to a block that does not exist, or is not behind this one.
    Ref {
        /// Its index.
        index: u16,
    },
}

impl fmt::Display for BlockError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Alignment => f.write_str("the block is not aligned to 16 bytes"),
            Self::Length => f.write_str("the length is not the block size"),
            Self::Checksum => f.write_str("the checksum of the block does not match"),
            Self::Number { found } => write!(f, "this is block {found}, not the one asked for"),
            Self::Frame => f.write_str("the block's frame is not finite or not a power of two"),
            Self::Counts => f.write_str("the parts of the block do not fit into it"),
            Self::Reserved => f.write_str("bytes that must be zero are not"),
            Self::Child { node, slot } => {
                write!(f, "slot {slot} of node {node} is undefined, out of range or had twice")
            }
            Self::Order { node } => {
                write!(f, "an order of node {node} does not name each of its slots once")
            }
            Self::Depth => f.write_str("the tree is deeper than the block's header allows"),
            Self::Record { record } => {
                write!(f, "record {record} is empty, or an index or its material is out of range")
            }
            Self::SpheresLeftOut => f.write_str("the block holds spheres, which are left out here"),
            Self::Vertex { vertex } => write!(f, "vertex {vertex} is not in [-1, 1]³"),
            Self::Ref { index } => write!(f, "reference {index} leads nowhere, or back"),
        }
    }
}

impl core::error::Error for BlockError {}
