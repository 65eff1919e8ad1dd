//! Rays from inside closed meshes.

use std::collections::BTreeMap;

use fastrand::Rng;
use glam::DVec3;
use kiloray_core::geometry::{Primitive, Ray};
use kiloray_core::trace::{Cursor, Tracer};
use kiloray_scene::kilo::KiloFile;
use kiloray_scene::model::Model;
use kiloray_simd::Auto;

use super::{compiled, direction, primitives};

/// A corner, by its coordinates.
type Corner = [u64; 3];

/// Edges of a mesh that keep it from being closed: those that are not between two triangles, in opposite directions.
#[must_use]
pub fn open_edges(model: &Model) -> usize {
    let mut edges: BTreeMap<(Corner, Corner), i64> = BTreeMap::new();
    let corner = |i: u32| model.vertices[i as usize].to_array().map(|x| (x + 0.0).to_bits());
    for triangle in &model.triangles {
        let [a, b, c] = triangle.vertices.map(corner);
        for (from, to) in [(a, b), (b, c), (c, a)] {
            let (edge, sign) = if from < to { ((from, to), 1) } else { ((to, from), -1) };
            *edges.entry(edge).or_default() += sign;
        }
    }
    edges.values().filter(|&&sum| sum != 0).count()
}

/// A closed mesh, ready to be shot at from inside.
#[derive(Debug)]
pub struct Mesh {
    file: KiloFile,
    corners: Vec<[DVec3; 3]>,
}

/// A ray that has got out.
#[derive(Debug, Clone, Copy)]
pub struct Leak {
    /// The ray.
    pub ray: Ray,
}

impl Mesh {
    /// Compiles a mesh to blocks of 4 KiB.
    ///
    /// # Errors
    /// What the compiler says.
    pub fn new(model: &Model) -> Result<Self, String> {
        let file = compiled(model, 4 << 10)?;
        let corners = primitives(&file.view()).into_iter().filter_map(|(p, _)| match p {
            Primitive::Triangle { vertices, .. } => Some(vertices.map(|v| v.as_dvec3())),
            Primitive::Sphere { .. } => None,
        });
        let corners = corners.collect();
        Ok(Self { file, corners })
    }

    /// Shoots `rays` rays from inside: half in any direction, half at corners and edges.
    ///
    /// A point is inside if it lies half way between the first two crossings of a line from outside: of a closed
    /// mesh, however it is bent.
    ///
    /// # Errors
    /// The first ray that hits nothing.
    pub fn shoot(&self, seed: u64, rays: u64) -> Result<u64, Leak> {
        let mut rng = Rng::with_seed(seed);
        let (tracer, mut cursor) = (Auto::detect(), Cursor::new());
        let mut view = self.file.view();
        let mut shot = 0;
        while shot < rays {
            let Some(inside) = self.inside(&mut rng) else { continue };
            for _ in 0..1000.min(rays - shot) {
                let towards =
                    if rng.bool() { direction(&mut rng) } else { self.edge(&mut rng) - inside };
                let ray = Ray {
                    origin: inside.as_vec3(),
                    direction: towards.as_vec3(),
                    t_min: 0.0,
                    t_max: f32::INFINITY,
                };
                shot += 1;
                if !matches!(tracer.closest(&mut cursor, &mut view, &ray), Ok(Some(_))) {
                    return Err(Leak { ray });
                }
            }
        }
        Ok(shot)
    }

    fn edge(&self, rng: &mut Rng) -> DVec3 {
        let [a, b, _] = self.corners[rng.usize(0..self.corners.len())];
        let s = if rng.bool() { 0.0 } else { rng.f64() };
        a + (b - a) * s
    }

    fn inside(&self, rng: &mut Rng) -> Option<DVec3> {
        let (from, target) = (direction(rng) * 4.0, self.edge(rng) + direction(rng) * 0.1);
        let ray = Ray {
            origin: from.as_vec3(),
            direction: (target - from).as_vec3(),
            t_min: 0.0,
            t_max: f32::INFINITY,
        };
        let mut crossings = Vec::new();
        let (tracer, mut view) = (Auto::detect(), self.file.view());
        let every = tracer.every(&mut Cursor::new(), &mut view, &ray, |hit| {
            crossings.push(hit.t);
            false
        });
        every.ok()?;
        crossings.sort_by(f32::total_cmp);
        // An even number, well apart: not one through an edge, which counts for both its triangles.
        let apart = crossings.windows(2).all(|w| w[1] - w[0] > 1e-3);
        let (&first, &second) = (crossings.first()?, crossings.get(1)?);
        let middle = f64::from(first + second) / 2.0;
        (apart && crossings.len().is_multiple_of(2))
            .then(|| ray.origin.as_dvec3() + ray.direction.as_dvec3() * middle)
    }
}
