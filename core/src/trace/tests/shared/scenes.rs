//! Small scenes and rays that have broken other tracers.

use std::vec::Vec;

use glam::Vec3;

use super::writer::{Item, triangle};
use crate::geometry::{Primitive, Ray};

/// A generator for tests (SplitMix64).
pub(crate) struct Random(pub(crate) u64);

impl Random {
    pub(crate) fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let x = (self.0 ^ self.0 >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let x = (x ^ x >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        x ^ x >> 31
    }

    pub(crate) fn below(&mut self, n: u32) -> u32 {
        (self.bits() >> 32) as u32 % n
    }

    /// In [-1, 1).
    pub(crate) fn signed(&mut self) -> f32 {
        (self.bits() >> 40) as f32 / (1 << 23) as f32 - 1.0
    }

    pub(crate) fn point(&mut self) -> [f32; 3] {
        [self.signed(), self.signed(), self.signed()]
    }

    /// A magnitude of two to the `-n` to 1.
    pub(crate) fn scale(&mut self, n: u32) -> f32 {
        (-(self.below(n) as f32)).exp2()
    }
}

fn near(p: [f32; 3], size: f32, random: &mut Random) -> [f32; 3] {
    p.map(|x| x + size * random.signed())
}

/// Triangles of many sizes, slivers, points, lines, flat ones, coincident ones and spheres.
pub(crate) fn clutter(count: usize, spheres: bool, random: &mut Random) -> Vec<Item> {
    let mut items: Vec<Item> = Vec::new();
    while items.len() < count {
        let a = random.point();
        let size = random.scale(12);
        let material = random.below(5) as u16;
        let b = near(a, size, random);
        let item = match random.below(12) {
            // A sliver 1e-6 wide.
            0 => {
                let along = [b[0] + 1.0, b[1] - 0.5, b[2] + 0.25];
                triangle(b, along, along.map(|x| x + 1e-6 * random.signed()), material)
            }
            // A point, and a line.
            1 => triangle(a, a, a, material),
            2 => triangle(a, b, b, material),
            // In an axis plane: its box is flat.
            3 => {
                let axis = random.below(3) as usize;
                let flat = |mut p: [f32; 3]| {
                    p[axis] = a[axis];
                    p
                };
                triangle(a, flat(b), flat(near(a, size, random)), material)
            }
            // On a coarse lattice: shared edges and vertices, planes through boxes' faces.
            4..=6 => {
                let lattice = |p: [f32; 3]| p.map(|x| (x * 4.0).round() / 4.0);
                triangle(lattice(a), lattice(random.point()), lattice(random.point()), material)
            }
            // Coincident with an earlier one: the same, another material, or turned.
            7 if !items.is_empty() => {
                let earlier = items[random.below(items.len() as u32) as usize];
                match earlier.0 {
                    Primitive::Triangle { vertices: [a, b, c], .. } => {
                        let [a, b, c] = [a, b, c].map(|v| v.to_array());
                        match random.below(3) {
                            0 => earlier,
                            1 => triangle(a, b, c, material),
                            _ => triangle(b, c, a, earlier.1),
                        }
                    }
                    Primitive::Sphere { .. } => (earlier.0, material),
                }
            }
            8 if spheres => {
                let center = Vec3::from_array(a);
                let inward = random.below(2) == 0;
                (Primitive::Sphere { center, radius: size * 0.3, inward }, material)
            }
            9 => {
                let normals = Some([random.bits() as u32, 7, 9]);
                let vertices = [a, b, near(a, size, random)].map(Vec3::from_array);
                (Primitive::Triangle { vertices, normals }, material)
            }
            _ => triangle(a, b, near(a, size, random), material),
        };
        items.push(item);
    }
    // Into the cube of scene coordinates.
    for item in &mut items {
        match &mut item.0 {
            Primitive::Triangle { vertices, .. } => *vertices = vertices.map(|v| v * 0.125),
            Primitive::Sphere { center, radius, .. } => {
                *center *= 0.125;
                *radius *= 0.125;
            }
        }
    }
    items
}

/// Rays at the primitives and past them, of all the kinds that have broken other tracers.
pub(crate) fn rays(items: &[Item], count: usize, random: &mut Random) -> Vec<Ray> {
    (0..count).map(|_| ray(items, random)).collect()
}

fn ray(items: &[Item], random: &mut Random) -> Ray {
    let mut target = Vec3::from_array(random.point()) * 0.125;
    if let Some(item) = items.get(random.below(items.len() as u32 + 1) as usize) {
        target = match item.0 {
            // A vertex, a point of an edge, a point inside.
            Primitive::Triangle { vertices: [a, b, c], .. } => match random.below(4) {
                0 => a,
                1 => a * 0.5 + b * 0.5,
                2 => (a + b + c) / 3.0,
                _ => a + (b - a) * random.signed().abs(),
            },
            Primitive::Sphere { center, radius, .. } => {
                center + Vec3::from_array(random.point()) * radius
            }
        };
    }
    let mut origin = Vec3::from_array(random.point()) * 0.25;
    let mut length = 1.0;
    match random.below(10) {
        // Far away, and very far.
        0 => origin *= 1e4,
        1 => origin *= 1e7,
        // On a primitive, and on a lattice plane.
        2 => origin = target - Vec3::from_array(random.point()) * 0.03,
        3 => origin = (origin * 32.0).round() / 32.0,
        4 => length = 2.0_f32.powi(random.below(100) as i32 - 50),
        _ => {}
    }
    let mut direction = (target - origin) * length;
    // Parallel to a plane or an axis, with either zero.
    let zero = [0.0, -0.0];
    match random.below(6) {
        0 => direction[random.below(3) as usize] = zero[random.below(2) as usize],
        1 => {
            let axis = random.below(3) as usize;
            let kept = if direction[axis] == 0.0 { 1.0 } else { direction[axis] };
            direction = Vec3::from_array([0; 3].map(|_: i32| zero[random.below(2) as usize]));
            direction[axis] = kept;
            // Through the target: in planes of boxes and of flat triangles.
            let at = origin[axis];
            origin = target;
            origin[axis] = at;
        }
        // Components that differ wildly.
        2 => direction[random.below(3) as usize] *= 1e-30,
        _ => {}
    }
    let (t_min, t_max) = match random.below(6) {
        0 => (0.0, 1.0 / length),
        1 => (0.5 / length, 1.0 / length),
        2 => (1.0 / length, 1.0 / length),
        _ => (0.0, f32::INFINITY),
    };
    Ray { origin, direction, t_min, t_max }
}

/// Rays that are none.
pub(crate) fn no_rays() -> Vec<Ray> {
    let ray = Ray { origin: Vec3::ZERO, direction: Vec3::X, t_min: 0.0, t_max: f32::INFINITY };
    std::vec![
        Ray { direction: Vec3::ZERO, ..ray },
        Ray { direction: Vec3::new(0.0, f32::NAN, 1.0), ..ray },
        Ray { direction: Vec3::INFINITY, ..ray },
        Ray { origin: Vec3::NAN, ..ray },
        Ray { origin: Vec3::NEG_INFINITY, ..ray },
        Ray { t_min: f32::NAN, ..ray },
        Ray { t_max: f32::NAN, ..ray },
        Ray { t_min: 1.0, t_max: 0.5, ..ray },
    ]
}
