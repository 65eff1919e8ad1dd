//! The rays that `embree_bench` has traced, in scene coordinates.

use std::path::Path;

use glam::{DVec3, Vec3};
use kiloray_core::geometry::Ray;
use kiloray_core::scene::Frame;

use crate::Error;

/// Primary, bounce and shadow rays.
pub(crate) struct Sets {
    pub(crate) sets: [(&'static str, Vec<Ray>); 3],
}

/// Reads three lists: a count, then origin, greatest t, direction and pixel of each.
pub(crate) fn read(path: &Path, frame: &Frame) -> Result<Sets, Error> {
    let bytes = std::fs::read(path)?;
    let mut rest = bytes.as_slice();
    let mut take = |n: usize| -> Result<&[u8], Error> {
        let (part, behind) = rest.split_at_checked(n).ok_or("the ray file ends too soon")?;
        rest = behind;
        Ok(part)
    };
    let unit = f64::from(frame.exponent).exp2();
    let center = DVec3::from_array(frame.center);
    let mut list = || -> Result<Vec<Ray>, Error> {
        let count = u32::from_le_bytes(take(4)?.try_into()?) as usize;
        let ray = |ray: &[u8]| {
            let at = |i: usize| {
                f32::from_le_bytes([ray[4 * i], ray[4 * i + 1], ray[4 * i + 2], ray[4 * i + 3]])
            };
            let origin = Vec3::new(at(0), at(1), at(2)).as_dvec3();
            let direction = Vec3::new(at(4), at(5), at(6)).as_dvec3();
            Ray {
                origin: ((origin - center) / unit).as_vec3(),
                direction: (direction / unit).as_vec3(),
                t_min: 0.0,
                t_max: at(3),
            }
        };
        Ok(take(32 * count)?.chunks_exact(32).map(ray).collect())
    };
    Ok(Sets { sets: [("primary", list()?), ("bounce", list()?), ("shadow", list()?)] })
}
