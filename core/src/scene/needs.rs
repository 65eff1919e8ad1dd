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
    /// There are so many lights that they have a tree.
    pub const MANY_LIGHTS: u32 = 128;

    /// Bits of what this build leaves out, by its features.
    pub const LEFT_OUT: u32 = {
        let mut bits = 0;
        if !cfg!(feature = "specular") {
            bits |= Self::SPECULAR | Self::GLOSSY | Self::DIELECTRIC;
        }
        if !cfg!(feature = "transparent") {
            bits |= Self::TRANSPARENT;
        }
        if !cfg!(feature = "sphere") {
            bits |= Self::SPHERES;
        }
        if !cfg!(feature = "many-lights") {
            bits |= Self::MANY_LIGHTS;
        }
        bits
    };

    /// Whether any of these bits occurs, of what this build can do: asked before code that only they need.
    #[must_use]
    #[inline]
    pub const fn any(&self, bits: u32) -> bool {
        self.bits & bits & !Self::LEFT_OUT != 0
    }
}
