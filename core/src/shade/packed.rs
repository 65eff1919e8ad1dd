use super::{Path, ShadowRay};
use crate::geometry::{Hit, PreparedRay, Primitive, Ray};
use crate::path::PathKey;
use bytemuck::{Pod, Zeroable};
use glam::Vec3;

/// A ray, its path and its pixel, as plain data: what waits in an arena, and travels in a message.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct PathRay {
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
    depth: u8,
    /// A [`Task`].
    task: u8,
    _zero: [u8; 2],
}

/// What is asked of a [`PathRay`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[repr(u8)]
pub enum Task {
    /// Its closest hit, and all that follows from it.
    Path = 0,
    /// What is in its way.
    Shadow = 1,
    /// What the lights bring to its hit, which is known.
    Lights = 2,
    /// What its hit, which is known, brings, and all that follows from it: what a [`Path`](Self::Path) brings whose hit it is.
    Hit = 3,
}

impl Task {
    /// Whether the hit is known: then no block is needed to begin.
    #[must_use]
    pub const fn knows_hit(self) -> bool {
        matches!(self, Self::Lights | Self::Hit)
    }
}

impl PathRay {
    /// Packs a ray, its path, and the index of the pixel in its tile.
    #[must_use]
    pub fn new(ray: &Ray, path: &Path, pixel: u16) -> Self {
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
            depth: path.depth,
            task: Task::Path as u8,
            _zero: [0; 2],
        }
    }

    /// A shadow ray under a name of its own: its throughput is the light that it brings if nothing is in its way.
    #[must_use]
    pub fn of_shadow(shadow: &Shadow, key: PathKey, pixel: u16) -> Self {
        let path = Path { throughput: shadow.light(), ..Path::camera(key) };
        Self::new(&shadow.ray(), &path, pixel).with_task(Task::Shadow)
    }

    /// The ray.
    #[inline]
    #[must_use]
    pub fn ray(&self) -> Ray {
        Ray {
            origin: self.origin.into(),
            direction: self.direction.into(),
            t_min: self.t_min,
            t_max: self.t_max,
        }
    }

    /// Where the ray goes.
    #[cfg(feature = "bundles")]
    #[inline(always)]
    pub(crate) fn direction(&self) -> Vec3 {
        self.direction.into()
    }

    /// What it carries.
    #[must_use]
    pub fn path(&self) -> Path {
        Path {
            key: self.key(),
            throughput: self.throughput.into(),
            density: self.density,
            depth: self.depth,
            medium: self.medium,
        }
    }

    /// The name of its path.
    #[must_use]
    pub fn key(&self) -> PathKey {
        let [low, high] = self.key.map(u64::from);
        PathKey { path: high << 32 | low, sample: self.sample }
    }

    /// Index of the pixel in its tile.
    #[must_use]
    pub const fn pixel(&self) -> u16 {
        self.pixel
    }

    /// How many rays came before it on its path.
    #[must_use]
    pub const fn depth(&self) -> u32 {
        self.depth as u32
    }

    /// Whether it only asks what is in its way.
    #[must_use]
    pub const fn is_shadow(&self) -> bool {
        self.task == Task::Shadow as u8
    }

    /// What is asked of it.
    #[must_use]
    pub const fn task(&self) -> Task {
        match self.task {
            1 => Task::Shadow,
            2 => Task::Lights,
            3 => Task::Hit,
            _ => Task::Path,
        }
    }

    /// The same ray, of which something else is asked.
    #[must_use]
    pub const fn with_task(self, task: Task) -> Self {
        Self { task: task as u8, ..self }
    }
}

/// A shadow ray, its light and its pixel, as plain data. It begins at `t = 0`.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Shadow {
    origin: [f32; 3],
    direction: [f32; 3],
    t_max: f32,
    light: [f32; 3],
    /// Index of the light.
    pub source: u32,
    /// Index of the pixel in the tile.
    pub pixel: u16,
    /// What waits for it, at a node of a mesh.
    pub root: u16,
}

impl Shadow {
    /// Packs a shadow ray to light `source`.
    #[must_use]
    pub fn new(shadow: &ShadowRay, source: u32, pixel: u16) -> Self {
        Self {
            origin: shadow.ray.origin.to_array(),
            direction: shadow.ray.direction.to_array(),
            t_max: shadow.ray.t_max,
            light: shadow.light.to_array(),
            source,
            pixel,
            root: 0,
        }
    }

    /// The ray.
    #[inline]
    #[must_use]
    pub fn ray(&self) -> Ray {
        Ray {
            origin: self.origin.into(),
            direction: self.direction.into(),
            t_min: 0.0,
            t_max: self.t_max,
        }
    }

    /// What shadow rays are sorted by: their light, and `by_signs` the signs of their directions.
    #[inline]
    #[must_use]
    pub(crate) fn order(&self, by_signs: bool) -> u32 {
        let signs = if by_signs { PreparedRay::signs(self.direction.into()) } else { 0 };
        self.source << 3 | u32::from(signs)
    }

    /// What it brings if nothing is in its way.
    #[must_use]
    pub fn light(&self) -> Vec3 {
        self.light.into()
    }
}

/// A hit, or none, as plain data.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct PackedHit {
    t: f32,
    b1: f32,
    b2: f32,
    material: u16,
    kind: u16,
    data: [u32; 12],
    block: u32,
}

/// In [`PackedHit::kind`].
const TRIANGLE: u16 = 1;
const SMOOTH_TRIANGLE: u16 = 2;
const SPHERE: u16 = 3;
const BUBBLE: u16 = 4;

impl PackedHit {
    /// No hit.
    pub const NONE: Self =
        Self { t: 0.0, b1: 0.0, b2: 0.0, material: 0, kind: 0, data: [0; 12], block: 0 };

    /// Packs a hit.
    #[must_use]
    pub fn new(hit: Option<&Hit>) -> Self {
        let Some(hit) = hit else { return Self::NONE };
        let bits = |v: Vec3| v.to_array().map(f32::to_bits);
        let (kind, data) = match hit.primitive {
            Primitive::Triangle { vertices, normals } => {
                let kind = if normals.is_some() { SMOOTH_TRIANGLE } else { TRIANGLE };
                let [[a, b, c], [d, e, f], [g, h, i]] = vertices.map(bits);
                let [n0, n1, n2] = normals.unwrap_or_default();
                (kind, [a, b, c, d, e, f, g, h, i, n0, n1, n2])
            }
            Primitive::Sphere { center, radius, inward } => {
                let [a, b, c] = bits(center);
                let kind = if inward { BUBBLE } else { SPHERE };
                (kind, [a, b, c, radius.to_bits(), 0, 0, 0, 0, 0, 0, 0, 0])
            }
        };
        let Hit { t, b1, b2, material, block, .. } = *hit;
        Self { t, b1, b2, material, kind, data, block }
    }

    /// In place of a hit the optical depth of a shadow ray.
    #[must_use]
    pub fn of_depth([a, b, c]: [u32; 3]) -> Self {
        let mut data = [0; 12];
        data.iter_mut().zip([a, b, c]).for_each(|(place, steps)| *place = steps);
        Self { data, ..Self::NONE }
    }

    /// The optical depth of a shadow ray.
    #[must_use]
    pub fn depth(&self) -> [u32; 3] {
        let [a, b, c, ..] = self.data;
        [a, b, c]
    }

    /// The block that it lies in; of no hit 0.
    #[must_use]
    pub const fn block(&self) -> u32 {
        self.block
    }

    /// The hit.
    #[must_use]
    pub fn get(&self) -> Option<Hit> {
        let [a, b, c, d, e, f, g, h, i, n0, n1, n2] = self.data;
        let v = |x, y, z| Vec3::from([x, y, z].map(f32::from_bits));
        let primitive = match self.kind {
            TRIANGLE | SMOOTH_TRIANGLE => Primitive::Triangle {
                vertices: [v(a, b, c), v(d, e, f), v(g, h, i)],
                normals: (self.kind == SMOOTH_TRIANGLE).then_some([n0, n1, n2]),
            },
            SPHERE | BUBBLE => Primitive::Sphere {
                center: v(a, b, c),
                radius: f32::from_bits(d),
                inward: self.kind == BUBBLE,
            },
            _ => return None,
        };
        let Self { t, b1, b2, material, block, .. } = *self;
        Some(Hit { t, b1, b2, material, primitive, block })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn a_packed_hit_is_the_hit(
            [t, b1, b2, x, y, z] in any::<[f32; 6]>().prop_map(|v| v.map(|x| if x.is_nan() { 0.0 } else { x })),
            material: u16,
            normals: Option<[u32; 3]>,
            sphere: bool,
            inward: bool,
            block: u32,
        ) {
            let a = Vec3::new(x, y, z);
            let primitive = if sphere {
                Primitive::Sphere { center: a, radius: b1, inward }
            } else {
                Primitive::Triangle { vertices: [a, a + Vec3::X, Vec3::new(t, b1, b2)], normals }
            };
            let hit = Hit { t, b1, b2, material, primitive, block };
            let packed = PackedHit::new(Some(&hit));
            prop_assert_eq!(packed.get(), Some(hit));
            prop_assert_eq!(packed.block(), block);
            prop_assert_eq!(PackedHit::new(None).get(), None);
        }
    }
}
