//! Scenes of a few primitives, traced by the reference tests of a hit, against closed forms.

use super::*;
use crate::geometry::{Hit, PreparedRay, Primitive, Ray};
use crate::material::{OpticalDepth, crossing};
use crate::path::PathKey;
use crate::scene::{Light, LightKind, Material, MaterialKind, Needs};
use bytemuck::Zeroable;
use core::convert::Infallible;
use glam::Vec3;
use std::vec::Vec;

mod direct;
mod furnace;
#[cfg(feature = "specular")]
mod specular;
#[cfg(feature = "many-lights")]
mod tree;
#[cfg(feature = "specular")]
mod twice;
mod unshadowed;

/// A scene, and its tracer.
#[derive(Default)]
struct Scene {
    materials: Vec<Material>,
    lights: Vec<Light>,
    primitives: Vec<(u16, Primitive)>,
    settings: Settings,
}

fn material(kind: MaterialKind) -> Material {
    Material { kind: kind as u32, ior: 1.5, ..Material::zeroed() }
}

fn matt(reflectance: f32) -> Material {
    Material { diffuse: [reflectance; 3], ..material(MaterialKind::Opaque) }
}

fn light(kind: LightKind, position: Vec3, u: Vec3, v: Vec3, radiance: f32) -> Light {
    Light {
        kind: kind as u32,
        material: u32::MAX,
        reach: f32::INFINITY,
        position: position.into(),
        u: u.into(),
        v: v.into(),
        radiance: [radiance; 3],
        cone_cos: -1.0,
        focus: 0.0,
        cone: [0.0; 3],
    }
}

impl Scene {
    fn material(&mut self, material: Material) -> u16 {
        self.materials.push(material);
        (self.materials.len() - 1) as u16
    }

    fn triangle(&mut self, material: u16, vertices: [Vec3; 3]) {
        self.primitives.push((material, Primitive::Triangle { vertices, normals: None }));
    }

    /// Front on the side of `u × v`.
    fn rectangle(&mut self, material: u16, corner: Vec3, u: Vec3, v: Vec3) {
        self.triangle(material, [corner, corner + u, corner + u + v]);
        self.triangle(material, [corner, corner + u + v, corner + v]);
    }

    fn sphere(&mut self, material: u16, center: Vec3, radius: f32) {
        self.primitives.push((material, Primitive::Sphere { center, radius, inward: false }));
    }

    /// A light of the table with its surface in the scene.
    fn lamp(&mut self, mut light: Light) {
        let index = self.lights.len() as u32 + 1;
        let material = self.material(Material {
            emission: light.radiance,
            light: index,
            ..material(MaterialKind::Light)
        });
        light.material = u32::from(material);
        let (p, u, v) = (Vec3::from(light.position), Vec3::from(light.u), Vec3::from(light.v));
        match LightKind::from_u32(light.kind).unwrap() {
            LightKind::Parallelogram => self.rectangle(material, p, u, v),
            LightKind::Triangle => self.triangle(material, [p, p + u, p + v]),
            LightKind::Sphere => self.sphere(material, p, u.x),
            _ => panic!("no surface"),
        }
        self.lights.push(light);
    }

    fn shader(&self) -> Shader<'_> {
        let brightest = self.lights.iter().flat_map(|l| l.radiance).fold(1.0, f32::max);
        let needs = Needs { bits: u32::MAX, radiance_max: brightest };
        let tables = Tables::new(&self.materials, &self.lights, needs);
        Shader::new(tables, self.settings)
    }

    /// The mean radiance along a ray, over the samples of a pixel.
    fn seen(&self, ray: &Ray, pixel: u32) -> (Vec3, Counts) {
        let shader = self.shader();
        let mut sum = Sum::ZERO;
        let mut counts = Counts::default();
        for sample in 0..self.settings.samples {
            let path = Path::camera(PathKey::camera(self.settings.seed, pixel, sample));
            let Ok(light) = shader.trace(&mut Brute(self), ray, path, &mut counts);
            sum.add(light);
        }
        (shader.unit().resolve(sum, self.settings.samples), counts)
    }
}

/// Asks every primitive.
struct Brute<'a>(&'a Scene);

impl Brute<'_> {
    fn hits(&self, ray: &Ray) -> impl Iterator<Item = Hit> {
        let prepared = PreparedRay::new(ray);
        self.0.primitives.iter().filter_map(move |&(material, primitive)| match primitive {
            Primitive::Triangle { vertices, .. } => {
                let hit = prepared.triangle(vertices)?;
                Some(Hit { t: hit.t, b1: hit.b1, b2: hit.b2, material, primitive, block: 0 })
            }
            Primitive::Sphere { center, radius, .. } => {
                let t = prepared.sphere(center, radius)?;
                Some(Hit { t, b1: 0.0, b2: 0.0, material, primitive, block: 0 })
            }
        })
    }
}

impl Visibility for Brute<'_> {
    type Error = Infallible;

    fn closest(&mut self, ray: &Ray) -> Result<Option<Hit>, Infallible> {
        Ok(self.hits(ray).reduce(|a, b| if b.is_closer_than(&a) { b } else { a }))
    }

    fn depths(&mut self, rays: &[Ray], depths: &mut [OpticalDepth]) -> Result<(), Infallible> {
        for (ray, depth) in rays.iter().zip(depths) {
            *depth = self.hits(ray).fold(OpticalDepth::CLEAR, |depth, hit| {
                depth.and(crossing(&self.0.materials[usize::from(hit.material)], ray, &hit))
            });
        }
        Ok(())
    }
}

/// A ray down onto a place of the plane z = 0.
fn down(x: f32, y: f32) -> Ray {
    Ray { origin: Vec3::new(x, y, 0.01), direction: Vec3::NEG_Z, t_min: 0.0, t_max: f32::INFINITY }
}

/// A large floor of a material in the plane z = 0.
fn floor(scene: &mut Scene, of: Material) {
    let material = scene.material(of);
    let corner = Vec3::new(-40.0, -41.0, 0.0);
    scene.rectangle(material, corner, Vec3::X * 83.0, Vec3::Y * 81.0);
}
