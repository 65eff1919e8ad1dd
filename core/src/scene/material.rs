use bytemuck::{Pod, Zeroable};

/// How a surface answers light. Radiance's materials and their units (the Radiance reference
/// manual, "materials"), each reduced to what shading uses.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u32)]
pub enum MaterialKind {
    /// Diffuse reflection, and a glossy lobe where `specular` is above zero: plastic and metal
    /// (Ward 1992), and trans with `transmit`. A smooth specular part (roughness 0, .018 and more) grows towards grazing angles as in Radiance, and all else
    /// loses what it takes.
    Opaque = 0,
    /// A perfect mirror of reflectance `specular`.
    Mirror = 1,
    /// A refracting interface (Fresnel) of index `ior`; inside, light is absorbed by `exp(-absorption * d)`.
    Dielectric = 2,
    /// A thin pane of index `ior` and transmissivity `transmit` at normal incidence; not refracted.
    Glass = 3,
    /// Emits `emission`, reflects nothing. One-sided on polygons: only the front emits.
    Light = 4,
    /// Nothing: light passes (a light's `void` alternative). No ray sees it.
    Void = 5,
}

impl MaterialKind {
    /// The kind with this number.
    #[must_use]
    pub const fn from_u32(kind: u32) -> Option<Self> {
        Some(match kind {
            0 => Self::Opaque,
            1 => Self::Mirror,
            2 => Self::Dielectric,
            3 => Self::Glass,
            4 => Self::Light,
            5 => Self::Void,
            _ => return None,
        })
    }
}

/// An entry of the material table. RGB throughout.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Material {
    /// A [`MaterialKind`].
    pub kind: u32,
    /// RMS slope of the glossy lobe's facets; 0 for a perfect mirror.
    pub roughness: f32,
    /// Index of refraction of the inside (dielectric) or of the pane (glass).
    pub ior: f32,
    /// Part of `transmit` that goes on undeviated (trans).
    pub transmit_specular: f32,
    /// Diffuse reflectance.
    pub diffuse: [f32; 3],
    /// Specular reflectance at normal incidence.
    pub specular: [f32; 3],
    /// Transmittance: of trans (diffuse and specular together), transmissivity of glass.
    pub transmit: [f32; 3],
    /// Absorption inside a dielectric [1 / scene unit].
    pub absorption: [f32; 3],
    /// Emitted radiance [W / (m² sr)].
    pub emission: [f32; 3],
    /// One more than the index of the first light whose visible surface it is; 0 for none. Lights of one material follow each other
    /// in the table. By it a ray that finds the surface knows how likely light sampling was to find it too; so the fewer lights
    /// share a material, the less there is to search (the compiler gives each its own where the numbers allow).
    pub light: u32,
}

const _: () = assert!(size_of::<Material>() == 80);
