//! Materials, vertices and triangles.

use glam::DVec3;
use kiloray_core::scene::MaterialKind;

use super::{
    COORDINATE_MAX, Emitter, IOR, MATERIALS_MAX, Material, Model, ModelError, NO_NORMAL, Triangle,
};

impl Model {
    /// Enters a material and gives its index.
    ///
    /// # Errors
    /// If there are [`MATERIALS_MAX`] already, or if a value cannot be rendered.
    pub fn add_material(&mut self, material: Material) -> Result<u16, ModelError> {
        material.check()?;
        if self.materials.len() >= MATERIALS_MAX {
            return Err(ModelError::Materials);
        }
        self.materials.push(material);
        Ok((self.materials.len() - 1) as u16)
    }

    /// Enters a vertex, whatever its value, and gives its index for [`add_face`](Self::add_face).
    ///
    /// # Errors
    /// If there are too many.
    pub fn add_vertex(&mut self, point: DVec3) -> Result<u32, ModelError> {
        push(&mut self.vertices, point, "vertices")
    }

    /// Enters a shading normal of any length and gives its index, [`NO_NORMAL`] if it has no
    /// direction.
    ///
    /// # Errors
    /// If there are too many.
    pub fn add_normal(&mut self, normal: DVec3) -> Result<u32, ModelError> {
        match direction(normal) {
            Some(unit) => push(&mut self.normals, unit, "normals"),
            None => {
                self.note("a shading normal without direction: not used");
                Ok(NO_NORMAL)
            }
        }
    }

    /// Enters a triangle of a mesh by indices of vertices and of shading normals ([`NO_NORMAL`]
    /// for none), counter-clockwise seen from its front. A bad one is dropped and counted.
    ///
    /// # Errors
    /// If there are too many.
    pub fn add_face(
        &mut self,
        material: u16,
        vertices: [u32; 3],
        normals: [u32; 3],
    ) -> Result<(), ModelError> {
        if let Some(points) = self.push_face(material, vertices, normals)? {
            self.light_triangle(material, points);
        }
        Ok(())
    }

    /// Enters a triangle, counter-clockwise seen from its front. A bad one is dropped and counted.
    ///
    /// # Errors
    /// If there are too many.
    pub fn add_triangle(&mut self, material: u16, points: [DVec3; 3]) -> Result<(), ModelError> {
        self.add_polygon(material, &points)
    }

    /// Counts something that was ignored or repaired, with the current place.
    pub fn note(&mut self, text: &str) {
        self.notes.add(text);
    }

    /// Enters a triangle without its light, and gives its corners; `None` if it was dropped.
    pub(super) fn push_face(
        &mut self,
        material: u16,
        vertices: [u32; 3],
        normals: [u32; 3],
    ) -> Result<Option<[DVec3; 3]>, ModelError> {
        if !self.has_material(material) {
            return Ok(None);
        }
        let corner = |i: u32| self.vertices.get(i as usize).copied();
        let [Some(a), Some(b), Some(c)] = vertices.map(corner) else {
            self.note("a face with a vertex index out of range: dropped");
            return Ok(None);
        };
        let points = [a, b, c];
        if !points.into_iter().all(is_valid) {
            self.note("a face with a coordinate that is no number or beyond 1e100: dropped");
            return Ok(None);
        }
        if area_direction(points).is_none() {
            self.note("a face without area: dropped");
            return Ok(None);
        }
        if self.is_void(material) {
            return Ok(Some(points));
        }
        let normals =
            normals.map(|n| if (n as usize) < self.normals.len() { n } else { NO_NORMAL });
        let normals = if normals.contains(&NO_NORMAL) { [NO_NORMAL; 3] } else { normals };
        push(&mut self.triangles, Triangle { vertices, normals, material }, "triangles")?;
        Ok(Some(points))
    }

    /// The index names a material; if not, that is counted.
    pub(super) fn has_material(&mut self, material: u16) -> bool {
        let known = usize::from(material) < self.materials.len();
        if !known {
            self.note("a surface whose material does not exist: dropped");
        }
        known
    }
}

/// Appends with a `u32` index, if there is memory; `u32::MAX` is kept free for "none".
pub(super) fn push<T>(list: &mut Vec<T>, item: T, what: &'static str) -> Result<u32, ModelError> {
    let index = u32::try_from(list.len()).ok().filter(|&i| i < NO_NORMAL);
    let index = index.ok_or(ModelError::Count { what })?;
    list.try_reserve(1).map_err(|_| ModelError::Memory { what })?;
    list.push(item);
    Ok(index)
}

/// Finite, and small enough to multiply.
pub(super) fn is_valid(point: DVec3) -> bool {
    // A comparison with NaN is false.
    point.abs().to_array().into_iter().all(|c| c <= COORDINATE_MAX)
}

/// The unit vector along `v`, for vectors of any finite length; `None` for zero and NaN.
pub(super) fn direction(v: DVec3) -> Option<DVec3> {
    let size = v.abs().max_element();
    (v.is_finite() && size > 0.0).then(|| (v / size).normalize())
}

/// The direction of a triangle's front, scaled at will; `None` if its area cannot be told from
/// zero.
///
/// An edge is uncertain by half an ulp of its corners, `ε·m` for coordinates up to `m`; so is the
/// cross product of edges up to `s`, by `2ε·m·s`, and by as much again through its own rounding.
pub(super) fn area_direction([a, b, c]: [DVec3; 3]) -> Option<DVec3> {
    let (e1, e2) = (b - a, c - a);
    let size = e1.abs().max(e2.abs()).max_element();
    let reach = a.abs().max(b.abs()).max(c.abs()).max_element();
    if size <= 0.0 {
        return None;
    }
    let cross = (e1 / size).cross(e2 / size);
    let doubt = 4.0 * f64::EPSILON * (1.0 + reach / size);
    // Decimal input is rounded before it gets here, so exact zero would miss most collinear
    // corners. What is kept may still be thin: a sliver is a surface.
    (cross.abs().max_element() > doubt).then_some(cross)
}

impl Material {
    /// Whether it can be rendered.
    ///
    /// # Errors
    /// If a value is no number, below zero, or else without sense.
    pub fn check(&self) -> Result<(), ModelError> {
        match fault(self) {
            Some(what) => Err(ModelError::Material { name: self.name.clone(), what }),
            None => Ok(()),
        }
    }

    /// What its surfaces shine with, seen or not.
    pub(crate) fn radiance(&self) -> DVec3 {
        match self.emitter {
            Emitter::Illum { radiance } => radiance,
            Emitter::None | Emitter::Sampled { .. } => self.emission,
        }
    }
}

/// What is wrong with a material, if anything.
fn fault(m: &Material) -> Option<&'static str> {
    let hidden = if let Emitter::Illum { radiance } = m.emitter { radiance } else { DVec3::ZERO };
    let colors = [m.diffuse, m.specular, m.transmit, m.absorption, m.emission, hidden];
    let scalars = [m.roughness, m.ior, m.transmit_specular];
    // f32 holds them later.
    let finite = |x: f64| x.abs() <= 1e30;
    if !colors.iter().flat_map(|c| c.to_array()).chain(scalars).all(finite) {
        return Some("a value is no number or beyond 1e30");
    }
    if colors.iter().any(|c| c.min_element() < 0.0) || scalars.iter().any(|&x| x < 0.0) {
        return Some("a value is below zero");
    }
    if matches!(m.kind, MaterialKind::Dielectric | MaterialKind::Glass) && !IOR.contains(&m.ior) {
        return Some("an index of refraction is not from 0.01 to 100");
    }
    None
}
