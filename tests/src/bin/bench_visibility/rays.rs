//! The rays that `embree_bench` has traced, in scene coordinates.

use std::path::Path;

use glam::{DVec3, Vec3};
use kiloray_core::geometry::Ray;
use kiloray_core::scene::Frame;

use crate::Error;

/// Kinds of rays, as the program calls them.
pub(crate) const KINDS: [&str; 3] = ["primary", "bounce", "shadow"];

/// Rays of each kind.
pub(crate) struct Sets([Vec<Ray>; 3]);

impl Sets {
    /// The kinds, and their rays.
    pub(crate) fn all(&self) -> impl Iterator<Item = (&'static str, &[Ray])> {
        KINDS.into_iter().zip(self.0.iter().map(Vec::as_slice))
    }

    /// Those of a kind.
    pub(crate) fn of(&self, kind: &str) -> &[Ray] {
        self.all().find(|(of, _)| *of == kind).map_or(&[], |(_, rays)| rays)
    }
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
    Ok(Sets([list()?, list()?, list()?]))
}
