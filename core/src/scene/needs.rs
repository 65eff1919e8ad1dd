use bytemuck::{Pod, Zeroable};

/// What the scene needs, found by the compiler, so that the rest is skipped.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Needs {
    /// Bits of what occurs: `Needs::SPECULAR` and the others.
    pub bits: u32,
    /// Greatest component of any emitted radiance, and of any intensity of a point or spot (scene units: it lights a white surface that bright at a
    /// distance of 0.56): fixes the unit of the pixel sums.
    pub radiance_max: f32,
}

impl Needs {
    /// A material reflects or transmits in a direction: specular rays are traced.
    pub const SPECULAR: u32 = 1;
    /// A material that shadow rays pass, weakened: they collect optical depth. Without it they stop at any hit.
    pub const TRANSPARENT: u32 = 2;
    /// Spheres occur.
    pub const SPHERES: u32 = 4;
    /// Shading normals occur.
    pub const NORMALS: u32 = 8;
    /// A glossy lobe occurs.
    pub const GLOSSY: u32 = 16;
    /// A dielectric occurs.
    pub const DIELECTRIC: u32 = 32;
    /// Light comes from beyond the scene: rays that escape see it.
    pub const DISTANT: u32 = 64;
}
