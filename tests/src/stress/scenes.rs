//! Random scenes that are hard for a tracer.

use std::f64::consts::TAU;

use fastrand::Rng;
use glam::DVec3;
use kiloray_scene::model::{Material, Model, ModelError};

use super::{direction, in_cube, unit};

/// Kinds of scenes.
pub(super) const KINDS: usize = 8;

/// A scene of a kind, of up to about a thousand triangles, at any scale from 1e-20 to 1e20 and up to
/// ten thousand of its sizes from the origin.
pub(super) fn scene(rng: &mut Rng, kind: usize) -> Result<Model, ModelError> {
    let mut model = Model::default();
    for _ in 0..4 {
        model.add_material(Material::default())?;
    }
    let scale = 10_f64.powf(rng.f64() * 40.0 - 20.0);
    let offset = in_cube(rng) * [0.0, 0.0, 1.0, 1e4][rng.usize(0..4)];
    let mut build = Build { place: |p: DVec3| (p + offset) * scale, model };
    let count = 1000_f64.powf(unit(rng)).ceil() as usize;
    match kind {
        0 => build.soup(rng, count)?,
        1 => build.slivers(rng, count)?,
        2 => build.globe(rng, count)?,
        3 => build.field(rng, count)?,
        4 => build.boxes(rng, count)?,
        5 => build.ties(rng, count)?,
        6 => build.fans(rng, count)?,
        _ => {
            for _ in 0..count / 4 + 1 {
                let radius = 10_f64.powf(-3.0 * unit(rng)) * scale;
                let center = (build.place)(in_cube(rng));
                build.model.add_sphere(rng.u16(0..4), center, radius, rng.bool())?;
            }
            build.soup(rng, count / 4)?;
        }
    }
    Ok(build.model)
}

struct Build<P> {
    place: P,
    model: Model,
}

impl<P: Fn(DVec3) -> DVec3> Build<P> {
    fn add(&mut self, rng: &mut Rng, points: [DVec3; 3]) -> Result<(), ModelError> {
        let points = points.map(&self.place);
        self.model.add_triangle(rng.u16(0..4), points)
    }

    /// Triangles of sizes over six orders of magnitude, anywhere.
    fn soup(&mut self, rng: &mut Rng, count: usize) -> Result<(), ModelError> {
        for _ in 0..count {
            let size = 10_f64.powf(-6.0 * unit(rng));
            let at = in_cube(rng);
            let points = [0; 3].map(|_| at + in_cube(rng) * size);
            self.add(rng, points)?;
        }
        Ok(())
    }

    /// Long ones, down to 1e-6 of their length wide, some side by side.
    fn slivers(&mut self, rng: &mut Rng, count: usize) -> Result<(), ModelError> {
        for _ in 0..count / 2 + 1 {
            let (a, b) = (in_cube(rng), in_cube(rng));
            let width = 10_f64.powf(-6.0 * unit(rng));
            let c = a + (b - a) * unit(rng) + direction(rng) * width;
            let d = b + direction(rng) * width;
            self.add(rng, [a, b, c])?;
            self.add(rng, [c, b, d])?;
        }
        Ok(())
    }

    /// A closed surface in bands, with a bumpy radius.
    fn globe(&mut self, rng: &mut Rng, count: usize) -> Result<(), ModelError> {
        let n = ((count / 4) as f64).sqrt() as usize + 3;
        let bump: Vec<f64> = (0..n * 2 * n).map(|_| 0.7 + 0.3 * unit(rng)).collect();
        let at = |i: usize, j: usize| {
            let (theta, phi) =
                (i as f64 / n as f64 * TAU / 2.0, (j % (2 * n)) as f64 / n as f64 * TAU / 2.0);
            let r = if i == 0 || i == n { 0.8 } else { bump[i * 2 * n + j % (2 * n)] };
            let pole = f64::from(u8::from(i != 0 && i != n));
            r * DVec3::new(
                theta.sin() * phi.cos() * pole,
                theta.sin() * phi.sin() * pole,
                theta.cos(),
            )
        };
        for i in 0..n {
            for j in 0..2 * n {
                if i != 0 {
                    self.add(rng, [at(i, j), at(i + 1, j), at(i, j + 1)])?;
                }
                if i != n - 1 {
                    self.add(rng, [at(i, j + 1), at(i + 1, j), at(i + 1, j + 1)])?;
                }
            }
        }
        Ok(())
    }

    /// A grid over the ground: every inner vertex is shared by six.
    fn field(&mut self, rng: &mut Rng, count: usize) -> Result<(), ModelError> {
        let n = ((count / 2) as f64).sqrt() as usize + 1;
        let high = [0.0, 1e-6, 0.3][rng.usize(0..3)];
        let height: Vec<f64> = (0..(n + 1) * (n + 1)).map(|_| unit(rng) * high).collect();
        let at = |i: usize, j: usize| {
            DVec3::new(i as f64 / n as f64, j as f64 / n as f64, height[i * (n + 1) + j])
        };
        for i in 0..n {
            for j in 0..n {
                self.add(rng, [at(i, j), at(i + 1, j), at(i, j + 1)])?;
                self.add(rng, [at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)])?;
            }
        }
        Ok(())
    }

    /// Boxes along the axes, on a coarse lattice: walls that touch and coincide.
    fn boxes(&mut self, rng: &mut Rng, count: usize) -> Result<(), ModelError> {
        for _ in 0..count / 12 + 1 {
            let mut step = || rng.i32(-4..5).into();
            let (a, b) = (
                DVec3::new(step(), step(), step()) / 4.0,
                DVec3::new(step(), step(), step()) / 4.0,
            );
            let corner = |i: usize| {
                let pick = |axis: usize| if i >> axis & 1 == 0 { a[axis] } else { b[axis] };
                DVec3::new(pick(0), pick(1), pick(2))
            };
            for face in
                [[0, 1, 3, 2], [4, 5, 7, 6], [0, 1, 5, 4], [2, 3, 7, 6], [0, 2, 6, 4], [1, 3, 7, 5]]
            {
                let [p, q, r, s] = face.map(corner);
                self.add(rng, [p, q, r])?;
                self.add(rng, [p, r, s])?;
            }
        }
        Ok(())
    }

    /// Triangles on a lattice, each more than once, of several materials.
    fn ties(&mut self, rng: &mut Rng, count: usize) -> Result<(), ModelError> {
        for _ in 0..count / 3 + 1 {
            let points = [0; 3].map(|_| (in_cube(rng) * 3.0).round() / 3.0);
            let [a, b, c] = points;
            for points in [points, [b, c, a], [c, b, a]] {
                self.add(rng, points)?;
            }
        }
        Ok(())
    }

    /// Many triangles round one vertex.
    fn fans(&mut self, rng: &mut Rng, count: usize) -> Result<(), ModelError> {
        let spokes = rng.usize(3..60);
        for _ in 0..count / spokes + 1 {
            let (hub, u, v) = (in_cube(rng), direction(rng), direction(rng));
            let size = 10_f64.powf(-3.0 * unit(rng));
            let rim = |i: usize| {
                let a = (i % spokes) as f64 / spokes as f64 * TAU;
                hub + (u * a.cos() + v * a.sin()) * size
            };
            for i in 0..spokes {
                self.add(rng, [hub, rim(i), rim(i + 1)])?;
            }
        }
        Ok(())
    }
}
