//! Models to compile.

use glam::DVec3;

use crate::model::{Material, Model, NO_NORMAL, Triangle};

/// Triangles that share no vertex.
pub(super) fn soup(triangles: Vec<[DVec3; 3]>) -> Model {
    let mut model = Model { materials: vec![Material::default()], ..Model::default() };
    for corners in triangles {
        let first = model.vertices.len() as u32;
        model.vertices.extend(corners);
        let vertices = [first, first + 1, first + 2];
        model.triangles.push(Triangle { vertices, normals: [NO_NORMAL; 3], material: 0 });
    }
    model
}

/// A height field of `2 n²` triangles.
pub(super) fn field(n: u32) -> Model {
    let mut model = Model { materials: vec![Material::default()], ..Model::default() };
    for i in 0..=n {
        for j in 0..=n {
            let (x, y) = (f64::from(i), f64::from(j));
            model.vertices.push(DVec3::new(x, y, (x * 0.3).sin() * (y * 0.2).cos() * 4.0));
        }
    }
    for i in 0..n {
        for j in 0..n {
            let a = i * (n + 1) + j;
            for vertices in [[a, a + n + 1, a + 1], [a + 1, a + n + 1, a + n + 2]] {
                model.triangles.push(Triangle { vertices, normals: [NO_NORMAL; 3], material: 0 });
            }
        }
    }
    model
}
