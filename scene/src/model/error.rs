use thiserror::Error;

/// Why a model cannot hold what was asked for.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum ModelError {
    /// More materials than an index of 16 bits names.
    #[error("more than {} materials; merge those that are equal", super::MATERIALS_MAX)]
    Materials,
    /// More vertices, normals, triangles or spheres than an index of 32 bits names.
    #[error("more than {} {what}; split the scene", u32::MAX - 1)]
    Count {
        /// What there are too many of.
        what: &'static str,
    },
    /// There is no memory for more.
    #[error("more {what} than there is memory for; split the scene, or give more memory")]
    Memory {
        /// What there are too many of.
        what: &'static str,
    },
    /// A material has a value that cannot be rendered.
    #[error("material `{name}`: {what}")]
    Material {
        /// Its name.
        name: String,
        /// Which value, and what it may be.
        what: &'static str,
    },
    /// A view has a value that cannot be rendered.
    #[error("view: {what}")]
    View {
        /// Which value, and what it may be.
        what: &'static str,
    },
    /// A distant source has a value that cannot be rendered.
    #[error("source: {what}")]
    Source {
        /// Which value, and what it may be.
        what: &'static str,
    },
}
