use bytemuck::{Pod, Zeroable};

/// From scene coordinates to the coordinates of the input: `input = center + 2^exponent * scene`.
///
/// The compiler chooses it so that all surfaces fit the cube [-1, 1]³. The scale is a power of two
/// and costs no accuracy; radiance does not depend on it, while intensities (`W/sr`) and
/// absorption (per length) are converted by the compiler.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Frame {
    /// The scene's origin, input coordinates.
    pub center: [f64; 3],
    /// Binary exponent of the scene's unit, in input units.
    pub exponent: i32,
    /// Greatest distance between a vertex of the input and what is stored [input units].
    pub position_error: f32,
}
