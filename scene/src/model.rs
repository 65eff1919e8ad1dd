//! A scene as read: triangles, spheres, materials, lights and views in f64, in input coordinates.
//!
//! Importers and built-in scenes build a [`Model`] with its `add_` functions; the compiler turns it
//! into blocks.
//!
//! The `add_` functions keep these promises for what they enter:
//! - every coordinate is finite and at most [`COORDINATE_MAX`], every index is in range, every
//!   triangle has an area and every sphere a radius. What breaks this is dropped, and counted in
//!   [`Model::notes`] with the place of the first;
//! - a surface whose material emits for others ([`Emitter::Sampled`]) has its entries in
//!   [`Model::lights`];
//! - a limit of the format ([`MATERIALS_MAX`], `u32` indices) that is passed is a [`ModelError`].
//!
//! Vertices that no triangle names may occur; bounds are those of triangles and spheres.

mod error;
mod lights;
mod mesh;
mod notes;
mod polygon;
mod rings;
mod round;
mod shapes;
#[cfg(test)]
mod tests;

use std::path::PathBuf;

use glam::DVec3;

pub use error::ModelError;
pub use notes::{Note, Notes, Place};
pub use round::SIDES;

/// Greatest number of materials.
pub const MATERIALS_MAX: usize = u16::MAX as usize;
/// Greatest magnitude of a coordinate or radius: squares and products of three stay finite.
pub const COORDINATE_MAX: f64 = 1e100;

/// Indices of refraction that a dielectric or a pane can have, against what is around it: far more than matter has.
pub const IOR: std::ops::RangeInclusive<f64> = 0.01..=100.0;

/// No shading normal.
pub const NO_NORMAL: u32 = u32::MAX;

/// A scene in input coordinates.
#[derive(Debug, Clone, Default)]
pub struct Model {
    /// Materials; surfaces name them by index.
    pub materials: Vec<Material>,
    /// Corners of triangles.
    pub vertices: Vec<DVec3>,
    /// Unit shading normals.
    pub normals: Vec<DVec3>,
    /// Triangles.
    pub triangles: Vec<Triangle>,
    /// Spheres.
    pub spheres: Vec<Sphere>,
    /// What direct lighting samples. Surfaces that emit were entered by the `add_` functions.
    pub lights: Vec<Light>,
    /// Views, the first is the default.
    pub views: Vec<View>,
    /// What was ignored or repaired, with how often: printed once each, in this order.
    pub notes: Notes,
    /// The files that it was read from, also those that others name.
    pub files: Vec<PathBuf>,
}

/// A triangle, counter-clockwise seen from its front.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Triangle {
    /// Indices into `vertices`.
    pub vertices: [u32; 3],
    /// Indices into `normals`, or [`NO_NORMAL`].
    pub normals: [u32; 3],
    /// Index into `materials`.
    pub material: u16,
}

/// A sphere.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sphere {
    /// Centre.
    pub center: DVec3,
    /// Radius, above zero.
    pub radius: f64,
    /// Index into `materials`.
    pub material: u16,
    /// The surface faces the centre.
    pub inward: bool,
}

/// A material, as `kiloray_core::scene::Material` but in f64 and input units.
#[derive(Debug, Clone, PartialEq)]
pub struct Material {
    /// Its name in the input.
    pub name: String,
    /// What it is.
    pub kind: kiloray_core::scene::MaterialKind,
    /// RMS facet slope.
    pub roughness: f64,
    /// Index of refraction.
    pub ior: f64,
    /// Undeviated part of `transmit`.
    pub transmit_specular: f64,
    /// Diffuse reflectance.
    pub diffuse: DVec3,
    /// Specular reflectance.
    pub specular: DVec3,
    /// Transmittance.
    pub transmit: DVec3,
    /// Absorption [1 / input unit].
    pub absorption: DVec3,
    /// Emitted radiance [W / (m² sr)].
    pub emission: DVec3,
    /// How its surfaces become entries of the light table.
    pub emitter: Emitter,
}

/// How surfaces of a material light others.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Emitter {
    /// They do not (or are seen only: a glow of radius 0).
    #[default]
    None,
    /// They are sampled; to the distance `reach` at most.
    Sampled {
        /// [input units], infinity for no limit.
        reach: f64,
        /// What makes it a spotlight.
        cone: Option<Cone>,
    },
    /// They are sampled with a radiance that nobody sees: what is seen is the material itself
    /// (Radiance's `illum` with an alternate material).
    Illum {
        /// [W / (m² sr)].
        radiance: DVec3,
    },
}

/// A light to sample, input coordinates. See `kiloray_core::scene::LightKind` for the shapes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Light {
    /// Its shape.
    pub kind: kiloray_core::scene::LightKind,
    /// The material of its visible surface, if it has one.
    pub material: Option<u16>,
    /// Reach [input units].
    pub reach: f64,
    /// Corner, centre or place.
    pub position: DVec3,
    /// First edge, radius or direction.
    pub u: DVec3,
    /// Second edge or radius; the cosine of a cone in `x`.
    pub v: DVec3,
    /// Radiance, or intensity.
    pub radiance: DVec3,
    /// What makes it a spotlight.
    pub cone: Option<Cone>,
}

/// Where the light of a spotlight goes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cone {
    /// Unit.
    pub axis: DVec3,
    /// \[rad\].
    pub half_angle: f64,
    /// Focal length [input units]: at distance `d` it brings the part `(d / (d + focus))²` of its light.
    pub focus: f64,
}

/// A camera, input coordinates. See `kiloray_core::scene::View`.
#[derive(Debug, Clone, PartialEq)]
pub struct View {
    /// Perspective or parallel.
    pub kind: kiloray_core::scene::ViewKind,
    /// Its name.
    pub name: String,
    /// Eye.
    pub position: DVec3,
    /// Unit direction.
    pub direction: DVec3,
    /// Up.
    pub up: DVec3,
    /// Full angles \[degrees\] or lengths.
    pub size: [f64; 2],
    /// Shift and lift, in image sizes.
    pub offset: [f64; 2],
    /// Fore and aft clipping distances, 0 for none.
    pub clip: [f64; 2],
}

impl Default for Material {
    /// Grey, diffuse, reflectance ½.
    fn default() -> Self {
        Self {
            name: String::new(),
            kind: kiloray_core::scene::MaterialKind::Opaque,
            roughness: 0.0,
            ior: 1.5,
            transmit_specular: 0.0,
            diffuse: DVec3::splat(0.5),
            specular: DVec3::ZERO,
            transmit: DVec3::ZERO,
            absorption: DVec3::ZERO,
            emission: DVec3::ZERO,
            emitter: Emitter::None,
        }
    }
}
