//! Shading: what a ray brings, its point, its shadow rays and children, with any tables.
#![no_std]
#![no_main]

use core::hint::black_box;
use kiloray_core::geometry::{Hit, Ray};
use kiloray_core::material::{OpticalDepth, crossing};
use kiloray_core::path::PathKey;
use kiloray_core::scene::Needs;
use kiloray_core::shade::{Counts, Path, Shader, Tables, Visibility};
use kiloray_no_panic::{any, any_shading, entry};

/// A tracer that the compiler cannot see through.
struct Unknown;

impl Visibility for Unknown {
    type Error = u8;

    fn closest(&mut self, _: &Ray) -> Result<Option<Hit>, u8> {
        black_box(Ok(None))
    }

    fn depths(&mut self, rays: &[Ray], depths: &mut [OpticalDepth]) -> Result<(), u8> {
        black_box((rays, depths));
        black_box(Ok(()))
    }
}

entry!({
    let needs = Needs { bits: any(), radiance_max: any() };
    let tables = Tables::new(black_box(&[]), black_box(&[]), needs);
    #[cfg(feature = "many-lights")]
    let tables = Tables { tree: black_box(&[]), ..tables };
    let settings = any_shading();
    let shader = Shader::new(tables, settings);
    let path = Path::camera(PathKey::camera(any(), any(), any()));
    let ray: Ray = black_box(Ray {
        origin: glam::Vec3::ZERO,
        direction: glam::Vec3::Z,
        t_min: 0.0,
        t_max: 1.0,
    });
    let _ = black_box(shader.trace(&mut Unknown, &ray, path, &mut Counts::default()));
    if let (Some(hit), Some(material)) = (black_box(None::<Hit>), tables.materials.first()) {
        black_box(crossing(material, &ray, &hit));
    }
});
