//! Long runs against the oracle, each with a seed that makes it again.
//!
//! * [`hits`]: random rays over thousands of random scenes, every closest hit held against brute force in f64.
//! * [`leaks`]: rays from inside closed meshes, of which none may get out.
//! * [`scales`]: scenes a million times smaller and larger, and far from the origin: what accuracy remains.

pub mod hits;
pub mod leaks;
mod rays;
pub mod scales;
mod scenes;
mod sieve;

use fastrand::Rng;
use glam::{DVec3, Vec3};
use kiloray_core::block::KiloView;
use kiloray_core::block::format::RECORD_SPHERES;
use kiloray_core::geometry::Primitive;
use kiloray_scene::compile::{Options, compile};
use kiloray_scene::kilo::KiloFile;
use kiloray_scene::model::Model;

/// Compiles a model that the tests themselves have made.
fn compiled(model: &Model, block_bytes: usize) -> Result<KiloFile, String> {
    let options = Options::blocks_of(block_bytes);
    compile(model, &options, &mut ()).map(KiloFile::from_compiled).map_err(|e| e.to_string())
}

/// What the blocks of a file hold, in their order. Normals are left out.
fn primitives(view: &KiloView<'_>) -> Vec<(Primitive, u16)> {
    let mut all = Vec::new();
    for block in (0..view.blocks()).filter_map(|b| view.trusted_block(b)) {
        for record in block.records() {
            let base = usize::from(record.base & !RECORD_SPHERES);
            for index in record.index.iter().filter(|[a, b, c]| a != b || b != c) {
                let corner =
                    |i: usize| block.vertex(base + usize::from(index[i])).unwrap_or(Vec3::NAN);
                let primitive = if record.base & RECORD_SPHERES != 0 {
                    let shape = corner(1);
                    Primitive::Sphere { center: corner(0), radius: shape.x, inward: shape.y != 0.0 }
                } else {
                    Primitive::Triangle {
                        vertices: [corner(0), corner(1), corner(2)],
                        normals: None,
                    }
                };
                all.push((primitive, record.material));
            }
        }
    }
    all
}

/// A uniform number of [0, 1).
fn unit(rng: &mut Rng) -> f64 {
    rng.f64()
}

/// A uniform point of the cube from -1 to 1.
fn in_cube(rng: &mut Rng) -> DVec3 {
    DVec3::new(rng.f64(), rng.f64(), rng.f64()) * 2.0 - 1.0
}

/// A uniform direction (Marsaglia 1972, by rejection).
fn direction(rng: &mut Rng) -> DVec3 {
    loop {
        let d = in_cube(rng);
        let len = d.length();
        if len > 0.01 && len <= 1.0 {
            return d / len;
        }
    }
}

/// Weights of the three corners of a triangle, uniform.
fn weights(rng: &mut Rng) -> [f64; 3] {
    let (a, b) = (rng.f64(), rng.f64());
    let (a, b) = if a + b > 1.0 { (1.0 - a, 1.0 - b) } else { (a, b) };
    [1.0 - a - b, a, b]
}
