//! The surfaces of a model as f32: merged vertices and boxed primitives.

use glam::Vec3;
use kiloray_core::block::octahedral;
use kiloray_core::geometry::Aabb;
use kiloray_core::scene::MaterialKind;

use super::bounds::Item;
use super::frame::Placement;
use super::options::CompileError;
use crate::model::{Model, NO_NORMAL};

/// The part of its size (the longest side of its box) by which a surface can move unnoticed: less than
/// a pixel where it is 100 pixels large.
const COARSE: f32 = 0.01;

/// Marks the group of spheres; the rest of a group is the material.
pub(crate) const GROUP_SPHERE: u32 = 1 << 16;

/// A vertex as blocks store it, by its bits: position and code of the shading normal.
pub(crate) type Vertex = ([u32; 3], u32);

/// What the tree is built from.
#[derive(Debug)]
pub(crate) struct Surfaces {
    /// One for each primitive that is kept, in the order of the model; the build reorders them.
    pub(crate) items: Vec<Item>,
    /// Vertices of the primitives, from [`Surfaces::sort_corners`] on in the order of the items: a triangle's corners, or a sphere's centre and radius.
    pub(crate) corners: Vec<[u32; 3]>,
    /// Merged vertices.
    pub(crate) vertices: Vec<Vertex>,
    /// Any vertex has a normal.
    pub(crate) normals: bool,
    pub(crate) triangles: u64,
    pub(crate) spheres: u64,
    /// Left out: void ones, and the others.
    pub(crate) void: u64,
    pub(crate) dropped: u64,
    /// Kept, and small beside their distance from the middle of the scene: rounding can move them by more than [`COARSE`] of their size.
    pub(crate) coarse: u64,
    /// The most that it can move one of these [scene units].
    pub(crate) coarse_error: f32,
    /// Greatest distance from an input vertex to the stored one [scene units].
    pub(crate) error: f64,
}

/// The bits of a coordinate; both zeros have the same.
fn bits(v: f32) -> u32 {
    (v + 0.0).to_bits()
}

pub(crate) fn position(vertex: &Vertex) -> [f32; 3] {
    vertex.0.map(f32::from_bits)
}

impl Surfaces {
    pub(crate) fn of(model: &Model, place: Placement) -> Result<Self, CompileError> {
        let count = model.triangles.len() as u64 + model.spheres.len() as u64;
        let limit = u64::from(u32::MAX) / 4;
        if count > limit {
            return Err(CompileError::TooMany { what: "surfaces", count, limit });
        }
        let mut surfaces = Self {
            items: Vec::with_capacity(count as usize),
            corners: Vec::with_capacity(count as usize),
            vertices: Vec::new(),
            normals: false,
            triangles: 0,
            spheres: 0,
            void: 0,
            dropped: 0,
            coarse: 0,
            coarse_error: 0.0,
            error: 0.0,
        };
        let void: Vec<bool> =
            model.materials.iter().map(|m| m.kind == MaterialKind::Void).collect();
        let material = |index: u16| {
            void.get(usize::from(index)).copied().ok_or(CompileError::Missing {
                what: "material",
                index: u64::from(index),
                len: void.len() as u64,
            })
        };
        let mut merged = Merged::default();
        let corners = Corners::of(model, place, &mut surfaces.error, &mut merged);
        for triangle in &model.triangles {
            let corner = corners.of_triangle(model, triangle, &mut merged)?;
            let [a, b, c] = corner.map(|i| merged.vertices[i as usize].0);
            if material(triangle.material)? {
                surfaces.void += 1;
                continue;
            }
            if a == b || b == c || c == a {
                surfaces.dropped += 1;
                continue;
            }
            let [a, b, c] = [a, b, c].map(|p| Vec3::from_array(p.map(f32::from_bits)));
            if !(a.is_finite() && b.is_finite() && c.is_finite()) {
                surfaces.dropped += 1;
                continue;
            }
            surfaces.triangles += 1;
            let own = Aabb::of_triangle([a, b, c]);
            surfaces.push(u32::from(triangle.material), corner, own);
        }
        for sphere in &model.spheres {
            let center = place.point(sphere.center);
            let radius = (sphere.radius * place.scale()) as f32;
            if material(sphere.material)? {
                surfaces.void += 1;
                continue;
            }
            if !(center.is_finite() && radius > 0.0) {
                surfaces.dropped += 1;
                continue;
            }
            let stored = center.as_vec3();
            let off = (stored.as_dvec3() - center).abs().max_element();
            let off_radius = (f64::from(radius) - sphere.radius * place.scale()).abs();
            surfaces.error = surfaces.error.max(off + off_radius);
            let inward = if sphere.inward { 1.0 } else { 0.0 };
            let center = merged.insert((stored.to_array().map(bits), octahedral::NONE));
            // No position has this zero: where all three corners are the same, the place counts as unused.
            let shape = [radius, inward, -0.0].map(f32::to_bits);
            let shape = merged.insert((shape, octahedral::NONE));
            surfaces.spheres += 1;
            let group = u32::from(sphere.material) | GROUP_SPHERE;
            surfaces.push(group, [center, shape, center], Aabb::of_sphere(stored, radius));
        }
        surfaces.vertices = merged.vertices;
        surfaces.normals = surfaces.vertices.iter().any(|v| v.1 != octahedral::NONE);
        Ok(surfaces)
    }

    /// Puts the corners into the order that the build gave the items.
    pub(crate) fn sort_corners(&mut self) {
        let corners = &self.corners;
        self.corners = self.items.iter().map(|item| corners[item.primitive as usize]).collect();
    }

    fn push(&mut self, group: u32, corners: [u32; 3], own: Aabb) {
        let reach = own.min.abs().max(own.max.abs()).max_element();
        // A number is rounded by at most half of the step to the next.
        let error = reach * f32::EPSILON / 2.0;
        if error > COARSE * (own.max - own.min).max_element() {
            self.coarse += 1;
            self.coarse_error = self.coarse_error.max(error);
        }
        let primitive = self.corners.len() as u32;
        self.items.push(Item::new(primitive, group, own.min.to_array(), own.max.to_array()));
        self.corners.push(corners);
    }
}

/// The merged vertices of the model's vertices, and the codes of its normals.
struct Corners {
    merged: Vec<u32>,
    codes: Vec<u32>,
}

impl Corners {
    fn of(model: &Model, place: Placement, error: &mut f64, merged: &mut Merged) -> Self {
        let codes = model.normals.iter().map(|n| octahedral::encode(n.as_vec3())).collect();
        let mut used = vec![false; model.vertices.len()];
        for triangle in &model.triangles {
            for &v in &triangle.vertices {
                if let Some(used) = used.get_mut(v as usize) {
                    *used = true;
                }
            }
        }
        let mut ids = vec![u32::MAX; model.vertices.len()];
        for ((id, p), used) in ids.iter_mut().zip(&model.vertices).zip(used) {
            if used {
                let exact = place.point(*p);
                let stored = exact.as_vec3();
                *error = error.max((stored.as_dvec3() - exact).abs().max_element());
                *id = merged.insert((stored.to_array().map(bits), octahedral::NONE));
            }
        }
        Self { merged: ids, codes }
    }

    fn of_triangle(
        &self,
        model: &Model,
        triangle: &crate::model::Triangle,
        merged: &mut Merged,
    ) -> Result<[u32; 3], CompileError> {
        let mut corner = [0; 3];
        for ((corner, &v), &n) in corner.iter_mut().zip(&triangle.vertices).zip(&triangle.normals) {
            *corner = *self.merged.get(v as usize).ok_or(CompileError::Missing {
                what: "vertex",
                index: u64::from(v),
                len: model.vertices.len() as u64,
            })?;
            if n != NO_NORMAL {
                let code = *self.codes.get(n as usize).ok_or(CompileError::Missing {
                    what: "normal",
                    index: u64::from(n),
                    len: model.normals.len() as u64,
                })?;
                if code != octahedral::NONE {
                    let position = merged.vertices[*corner as usize].0;
                    *corner = merged.insert((position, code));
                }
            }
        }
        Ok(corner)
    }
}

/// Vertices by their bits: open addressing, at most half full.
#[derive(Default)]
struct Merged {
    vertices: Vec<Vertex>,
    /// Index of a vertex plus one; 0 is free.
    slots: Vec<u32>,
}

impl Merged {
    fn insert(&mut self, vertex: Vertex) -> u32 {
        if self.vertices.len() * 2 >= self.slots.len() {
            self.grow();
        }
        let mask = self.slots.len() - 1;
        let mut at = hash(&vertex) as usize & mask;
        loop {
            match self.slots[at] {
                0 => break,
                id if self.vertices[id as usize - 1] == vertex => return id - 1,
                _ => at = (at + 1) & mask,
            }
        }
        self.vertices.push(vertex);
        self.slots[at] = self.vertices.len() as u32;
        self.vertices.len() as u32 - 1
    }

    fn grow(&mut self) {
        let len = (self.slots.len() * 2).max(64);
        self.slots.clear();
        self.slots.resize(len, 0);
        for (i, vertex) in self.vertices.iter().enumerate() {
            let mut at = hash(vertex) as usize & (len - 1);
            while self.slots[at] != 0 {
                at = (at + 1) & (len - 1);
            }
            self.slots[at] = i as u32 + 1;
        }
    }
}

/// Multiplies and folds, as `fxhash` and `wyhash` do; neighbours in space end far apart.
fn hash((p, n): &Vertex) -> u64 {
    let fold = |a: u64, b: u64| {
        let wide = u128::from(a) * u128::from(b);
        wide as u64 ^ (wide >> 64) as u64
    };
    let xy = u64::from(p[0]) | u64::from(p[1]) << 32;
    let zn = u64::from(p[2]) | u64::from(*n) << 32;
    fold(xy ^ 0xa076_1d64_78bd_642f, zn ^ 0xe703_7ed1_a0b4_28db) ^ fold(xy, 0x8ebc_6af0_9c88_c6e3)
}
