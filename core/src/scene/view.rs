use bytemuck::{Pod, Zeroable};

/// How pixels become rays.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u32)]
pub enum ViewKind {
    /// Radiance's `-vtv`: sizes are angles.
    Perspective = 0,
    /// Radiance's `-vtl`: sizes are lengths.
    Parallel = 1,
}

impl ViewKind {
    /// The kind with this number.
    #[must_use]
    pub const fn from_u32(kind: u32) -> Option<Self> {
        match kind {
            0 => Some(Self::Perspective),
            1 => Some(Self::Parallel),
            _ => None,
        }
    }
}

/// A camera, in scene coordinates.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct View {
    /// A [`ViewKind`].
    pub kind: u32,
    /// Name, UTF-8, padded with zeros.
    pub name: [u8; 20],
    /// Eye, or centre of the parallel view.
    pub position: [f32; 3],
    /// Unit viewing direction.
    pub direction: [f32; 3],
    /// Up; not parallel to `direction`, any length.
    pub up: [f32; 3],
    /// Horizontal and vertical size: full angles \[degrees\], or lengths [scene units].
    pub size: [f32; 2],
    /// Shift and lift of the image centre, in image widths and heights.
    pub offset: [f32; 2],
    /// Fore and aft clipping distance; 0 for none.
    pub clip: [f32; 2],
}

const _: () = assert!(size_of::<View>() == 84);
