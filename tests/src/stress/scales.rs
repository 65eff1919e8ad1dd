//! One scene at several sizes and distances from the origin: how far its hits are from the surface that was put in.

use std::collections::BTreeMap;

use fastrand::Rng;
use glam::DVec3;
use kiloray_core::geometry::{Primitive, Ray};
use kiloray_core::trace::{Cursor, Tracer};
use kiloray_scene::model::{Material, Model};
use kiloray_simd::Auto;

use super::{compiled, direction, in_cube, weights};
use crate::oracle::{POINT_BOUND, U};

/// What accuracy remains at a size and a distance.
#[derive(Debug, Clone, Copy)]
pub struct Row {
    /// Size of the scene.
    pub size: f64,
    /// Distance from the origin, in sizes.
    pub offset: f64,
    /// Rays that hit.
    pub hits: u64,
    /// Greatest distance between a hit and the plane of the triangle as put in \[sizes\].
    pub worst: f64,
    /// What f32 allows: the bound of the test, and the rounding of the vertices \[sizes\].
    pub allowed: f64,
}

/// Traces `rays` rays at the triangles of a random scene of this size, so far from the origin.
///
/// # Errors
/// What the compiler says.
pub fn measure(size: f64, offset: f64, rays: u64) -> Result<Row, String> {
    let mut rng = Rng::with_seed(7);
    let mut model = Model::default();
    let material = model.add_material(Material::default()).map_err(|e| e.to_string())?;
    let away = DVec3::new(1.0, -0.7, 0.4) * offset;
    for _ in 0..2000 {
        let at = in_cube(&mut rng);
        let points = [0; 3].map(|_| (at + in_cube(&mut rng) * 0.1 + away) * size);
        model.add_triangle(material, points).map_err(|e| e.to_string())?;
    }
    let file = compiled(&model, 4 << 10)?;
    let mut view = file.view();
    let frame = view.header().frame;
    let unit = 2_f64.powi(frame.exponent);
    let to_scene = |p: DVec3| (p - DVec3::from_array(frame.center)) / unit;
    let exact: Vec<[DVec3; 3]> = model
        .triangles
        .iter()
        .map(|t| t.vertices.map(|v| to_scene(model.vertices[v as usize])))
        .collect();
    let rounded = |t: &[DVec3; 3]| t.map(|v| v.as_vec3().to_array().map(|x| (x + 0.0).to_bits()));
    let by_rounded: BTreeMap<_, _> = exact.iter().map(|t| (rounded(t), t)).collect();

    let (tracer, mut cursor) = (Auto::detect(), Cursor::new());
    let mut row = Row { size, offset, hits: 0, worst: 0.0, allowed: 0.0 };
    for _ in 0..rays {
        let triangle = &exact[rng.usize(0..exact.len())];
        let w = weights(&mut rng);
        let target = triangle[0] * w[0] + triangle[1] * w[1] + triangle[2] * w[2];
        let origin = (target + direction(&mut rng) * rng.f64()).as_vec3();
        let direction = target.as_vec3() - origin;
        let ray = Ray { origin, direction, t_min: 0.0, t_max: f32::INFINITY };
        let Ok(Some(hit)) = tracer.closest(&mut cursor, &mut view, &ray) else { continue };
        let Primitive::Triangle { vertices, .. } = hit.primitive else { continue };
        let key = vertices.map(|v| v.to_array().map(|x| (x + 0.0).to_bits()));
        let Some(&&[a, b, c]) = by_rounded.get(&key) else {
            return Err("a hit is of a triangle that was not put in".into());
        };
        let point = origin.as_dvec3() + ray.direction.as_dvec3() * f64::from(hit.t);
        let normal = (b - a).cross(c - a).normalize_or_zero();
        let reach = [a, b, c]
            .iter()
            .fold(0.0_f64, |m, v| m.max((*v - origin.as_dvec3()).abs().max_element()));
        // A vertex moves by half an ulp per axis; the plane through three moved ones by no more, inside the triangle.
        let allowed = POINT_BOUND * reach + 3_f64.sqrt() * U;
        let off = (point - a).dot(normal).abs();
        row.hits += 1;
        // Scene units are at most two sizes.
        row.worst = row.worst.max(off);
        row.allowed = row.allowed.max(allowed);
        if off > allowed {
            return Err(format!("{off:e} off, {allowed:e} allowed: {ray:?}"));
        }
    }
    Ok(row)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn accuracy_depends_on_neither_size_nor_place() {
        let near = measure(1.0, 0.0, 2000).unwrap();
        for (size, offset) in [(1e-6, 0.0), (1e6, 0.0), (1e-6, 1e4), (1e6, 1e4)] {
            let row = measure(size, offset, 2000).unwrap();
            assert!(row.worst <= 2.0 * near.allowed, "{row:?}");
        }
    }
}
