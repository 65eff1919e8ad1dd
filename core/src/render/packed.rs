use crate::geometry::Ray;
use crate::path::PathKey;
use crate::shade::{Path, ShadowRay};
use bytemuck::{Pod, Zeroable};
use glam::Vec3;

/// A ray, its path and its pixel, as plain data.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(super) struct PathRay {
    origin: [f32; 3],
    t_min: f32,
    direction: [f32; 3],
    t_max: f32,
    throughput: [f32; 3],
    density: f32,
    key: [u32; 2],
    sample: u32,
    pixel: u16,
    medium: u16,
    depth: u32,
}

impl PathRay {
    pub(super) fn new(ray: &Ray, path: &Path, pixel: u16) -> Self {
        Self {
            origin: ray.origin.to_array(),
            t_min: ray.t_min,
            direction: ray.direction.to_array(),
            t_max: ray.t_max,
            throughput: path.throughput.to_array(),
            density: path.density,
            key: [path.key.path as u32, (path.key.path >> 32) as u32],
            sample: path.key.sample,
            pixel,
            medium: path.medium,
            depth: u32::from(path.depth),
        }
    }

    #[inline]
    pub(super) fn ray(&self) -> Ray {
        Ray {
            origin: self.origin.into(),
            direction: self.direction.into(),
            t_min: self.t_min,
            t_max: self.t_max,
        }
    }

    pub(super) fn path(&self) -> Path {
        let [low, high] = self.key.map(u64::from);
        Path {
            key: PathKey { path: high << 32 | low, sample: self.sample },
            throughput: self.throughput.into(),
            density: self.density,
            depth: self.depth as u8,
            medium: self.medium,
        }
    }

    pub(super) const fn pixel(&self) -> u16 {
        self.pixel
    }

    pub(super) const fn depth(&self) -> u32 {
        self.depth
    }
}

/// A shadow ray, its light and its pixel, as plain data. It begins at `t = 0`.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(super) struct Shadow {
    origin: [f32; 3],
    direction: [f32; 3],
    t_max: f32,
    light: [f32; 3],
    /// Index of the light.
    pub(super) source: u32,
    /// Index of the pixel in the tile.
    pub(super) pixel: u32,
}

impl Shadow {
    pub(super) fn new(shadow: &ShadowRay, source: u32, pixel: u16) -> Self {
        Self {
            origin: shadow.ray.origin.to_array(),
            direction: shadow.ray.direction.to_array(),
            t_max: shadow.ray.t_max,
            light: shadow.light.to_array(),
            source,
            pixel: u32::from(pixel),
        }
    }

    #[inline]
    pub(super) fn ray(&self) -> Ray {
        Ray {
            origin: self.origin.into(),
            direction: self.direction.into(),
            t_min: 0.0,
            t_max: self.t_max,
        }
    }

    pub(super) fn light(&self) -> Vec3 {
        self.light.into()
    }
}
