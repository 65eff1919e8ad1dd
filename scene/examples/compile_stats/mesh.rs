//! Meshes from files and formulas.

use std::error::Error;

use glam::DVec3;
use kiloray_scene::model::{Material, Model, NO_NORMAL, Triangle};

/// Where rays come from and go to, input coordinates.
pub(crate) struct Camera {
    pub(crate) eye: DVec3,
    pub(crate) target: DVec3,
    pub(crate) up: DVec3,
    /// Vertical angle \[degrees\].
    pub(crate) angle: f64,
    pub(crate) light: DVec3,
}

/// The mesh with this name: a `.ktri` or `.obj` file, or a number of triangles.
pub(crate) fn load(mesh: &str) -> Result<(Model, Camera), Box<dyn Error>> {
    if mesh.ends_with(".ktri") {
        let bytes = std::fs::read(mesh)?;
        return Ok(ktri(&bytes).ok_or("not a KTRI file")?);
    }
    let model = if mesh.ends_with(".obj") {
        obj(&std::fs::read_to_string(mesh)?)?
    } else {
        sinc(mesh.parse()?)
    };
    let lo = model.vertices.iter().fold(DVec3::INFINITY, |a, b| a.min(*b));
    let hi = model.vertices.iter().fold(DVec3::NEG_INFINITY, |a, b| a.max(*b));
    let (middle, size) = ((lo + hi) * 0.5, (hi - lo).length());
    let camera = Camera {
        eye: middle + DVec3::new(0.7, 0.5, 0.9).normalize() * size,
        target: middle,
        up: DVec3::Y,
        angle: 40.0,
        light: middle + DVec3::new(0.3, 0.9, 0.5) * size,
    };
    Ok((model, camera))
}

fn model(vertices: Vec<DVec3>, corners: impl Iterator<Item = [u32; 3]>) -> Model {
    let triangles = corners
        .map(|vertices| Triangle { vertices, normals: [NO_NORMAL; 3], material: 0 })
        .collect();
    Model { materials: vec![Material::default()], vertices, triangles, ..Model::default() }
}

fn ktri(bytes: &[u8]) -> Option<(Model, Camera)> {
    let word = |at: usize| Some(u32::from_le_bytes(*bytes.get(at..)?.first_chunk()?));
    let (vertices, triangles) = (word(4)? as usize, word(8)? as usize);
    let xyz = 12 + 13 * 4;
    let real = |at: usize| Some(f64::from(f32::from_bits(word(at)?)));
    let points = (0..vertices)
        .map(|i| xyz + 12 * i)
        .map(|at| Some(DVec3::new(real(at)?, real(at + 4)?, real(at + 8)?)))
        .collect::<Option<_>>()?;
    let ijk = xyz + 12 * vertices;
    let corners: Vec<[u32; 3]> = (0..triangles)
        .map(|i| ijk + 12 * i)
        .map(|at| Some([word(at)?, word(at + 4)?, word(at + 8)?]))
        .collect::<Option<_>>()?;
    let at = |i: usize| Some(DVec3::new(real(12 + 4 * i)?, real(16 + 4 * i)?, real(20 + 4 * i)?));
    let camera =
        Camera { eye: at(0)?, target: at(3)?, up: at(6)?, angle: real(12 + 36)?, light: at(10)? };
    Some((model(points, corners.into_iter()), camera))
}

fn obj(text: &str) -> Result<Model, Box<dyn Error>> {
    let (mut points, mut corners) = (Vec::new(), Vec::new());
    for line in text.lines() {
        let mut words = line.split_whitespace();
        match words.next() {
            Some("v") => {
                let v: Vec<f64> = words.map(str::parse).collect::<Result<_, _>>()?;
                points.push(DVec3::from_slice(&v));
            }
            Some("f") => {
                let index = |word: &str| word.split('/').next().unwrap_or("").parse::<u32>();
                let v: Vec<u32> = words.map(index).collect::<Result<_, _>>()?;
                corners.extend((2..v.len()).map(|i| [v[0] - 1, v[i - 1] - 1, v[i] - 1]));
            }
            _ => {}
        }
    }
    Ok(model(points, corners.into_iter()))
}

fn sinc(triangles: usize) -> Model {
    let n = ((triangles / 2) as f64).sqrt().ceil().max(1.0) as u32;
    let points = (0..=n).flat_map(|i| {
        (0..=n).map(move |j| {
            let (x, y) = (f64::from(i) / f64::from(n) - 0.5, f64::from(j) / f64::from(n) - 0.5);
            let r = 40.0 * x.hypot(y);
            DVec3::new(x, y, if r > 0.0 { r.sin() / r } else { 1.0 })
        })
    });
    let corners = (0..n * n).flat_map(|k| {
        let a = k / n * (n + 1) + k % n;
        [[a, a + n + 1, a + 1], [a + 1, a + n + 1, a + n + 2]]
    });
    model(points.collect(), corners)
}

/// Gives every vertex the mean normal of its triangles, and every run of 1280 triangles one of eight
/// materials.
pub(crate) fn smooth(model: &mut Model) {
    model.materials = vec![Material::default(); 8];
    model.normals = vec![DVec3::ZERO; model.vertices.len()];
    for (i, triangle) in model.triangles.iter_mut().enumerate() {
        let [a, b, c] = triangle.vertices.map(|v| model.vertices[v as usize]);
        triangle.material = (i / 1280 % 8) as u16;
        triangle.normals = triangle.vertices;
        for v in triangle.vertices {
            model.normals[v as usize] += (b - a).cross(c - a);
        }
    }
    for normal in &mut model.normals {
        *normal = normal.normalize_or(DVec3::Z);
    }
}
