use std::io;
use std::path::PathBuf;

use kiloray_core::block::FileError;
use kiloray_core::network::TopologyError;
use kiloray_core::store::{ArenaFull, BudgetError};
use kiloray_render::PictureError;
use kiloray_scene::kilo::KiloError;

use crate::Place;

/// Why a process cannot begin, or a mesh of them not go on.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A file or directory of ours.
    #[error("{}: {source}", path.display())]
    Io {
        /// Its path.
        path: PathBuf,
        /// What the system says.
        source: io::Error,
    },
    /// A configuration that cannot be read.
    #[error("{}: {cause}", path.display())]
    Config {
        /// Its path.
        path: PathBuf,
        /// What is wrong, and where.
        cause: String,
    },
    /// A configuration that makes no sense.
    #[error("{0}")]
    Options(String),
    /// The scene.
    #[error("{0}")]
    Scene(#[from] KiloError),
    /// A block of a node's share.
    #[error("{}: {error}", path.display())]
    Share {
        /// The scene's file.
        path: PathBuf,
        /// What is wrong.
        error: FileError,
    },
    /// There is no such picture.
    #[error(transparent)]
    Picture(#[from] PictureError),
    /// No such mesh.
    #[error("{0}")]
    Topology(#[from] TopologyError),
    /// A node's memory is too small.
    #[error("{0}")]
    Budget(#[from] BudgetError),
    /// The plan and the node disagree.
    #[error("{0}")]
    Arena(#[from] ArenaFull),
    /// The network.
    #[error("{0}")]
    Network(String),
    /// A node cannot take part, or the host not be worked for.
    #[error("{}{node} {cause}", if *node == Place::HOST { "the " } else { "node " })]
    Node {
        /// Which.
        node: Place,
        /// Why.
        cause: String,
    },
}
