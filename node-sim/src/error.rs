use kiloray_core::store::{ArenaFull, BudgetError};
use kiloray_render::PictureError;

/// Why there is no picture.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// There is no such picture.
    #[error(transparent)]
    Picture(#[from] PictureError),
    /// A node's memory is too small.
    #[error("{0}")]
    Budget(#[from] BudgetError),
    /// The plan and the node disagree.
    #[error("{0}")]
    Arena(#[from] ArenaFull),
    /// This machine does not have the memory of all nodes.
    #[error("the memory of {nodes} nodes, {bytes} bytes each, cannot be had: {cause}")]
    Memory {
        /// Nodes.
        nodes: usize,
        /// The arena of each \[bytes\].
        bytes: usize,
        /// Why.
        cause: std::io::Error,
    },
    /// A packet holds no ray, or too small a part of a block.
    #[error("packets of {packet} bytes are too small: at least {least} are needed")]
    Packet {
        /// What was asked for \[bytes\].
        packet: u16,
        /// The least \[bytes\].
        least: u16,
    },
    /// A link that carries nothing.
    #[error("a link without bandwidth carries nothing")]
    Bandwidth,
    /// A rate above 1, or of nothing.
    #[error("a rate of {count} in {of} cannot be")]
    Rate {
        /// So many times.
        count: u32,
        /// In so many.
        of: u32,
    },
    /// Every packet is lost.
    #[error("when all packets are lost, no picture can be made")]
    AllLost,
    /// A fault is for a node that does not exist.
    #[error("there is no node {node}: the mesh has nodes 0 to {last}")]
    NoNode {
        /// The node.
        node: u16,
        /// The last one.
        last: u16,
    },
    /// A factor that is none.
    #[error("node {node} cannot be slow by a factor of {factor}: it must be above 0")]
    Factor {
        /// The node.
        node: u16,
        /// The factor.
        factor: f64,
    },
    /// A node that has two factors.
    #[error("node {node} is slow by two factors: give one")]
    SlowTwice {
        /// The node.
        node: u16,
    },
    /// A machine that cannot be.
    #[error(
        "profile {name}: {operation} cannot take {ns} ns: from 0 to a second, and a ray takes some time"
    )]
    Profile {
        /// What the profile is called.
        name: String,
        /// Which operation.
        operation: &'static str,
        /// Its time \[ns\].
        ns: f64,
    },
    /// Nobody is left to render.
    #[error("all {nodes} nodes die: nobody is left to render")]
    AllDie {
        /// How many.
        nodes: u16,
    },
    /// Threads cannot be had.
    #[error("{threads} threads cannot be had: {cause}")]
    Threads {
        /// How many were asked for.
        threads: usize,
        /// Why.
        cause: rayon::ThreadPoolBuildError,
    },
}
