//! Which primitives of a scene a ray may hit, by a test of all of them in f64.
//!
//! It leaves out only what the ray surely misses, so that the oracle is asked of a few primitives and not of all:
//! a triangle is left out if, seen along the ray, the ray lies on the left of one edge and on the right of another,
//! by more than [`EDGE_BOUND`] each: then it is outside the one that is wrong, and farther than the bound from the triangle.

use kiloray_core::geometry::{Primitive, Ray};

use crate::oracle::EDGE_BOUND;

/// The corners of all triangles, by corner and axis; spheres always pass.
#[derive(Debug)]
pub(super) struct Sieve {
    corners: [[Vec<f64>; 3]; 3],
    /// Index of each triangle in the list of primitives.
    index: Vec<u32>,
    spheres: Vec<u32>,
}

/// Triangles in a step.
const STEP: usize = 64;

impl Sieve {
    pub(super) fn new(primitives: &[(Primitive, u16)]) -> Self {
        let mut sieve =
            Self { corners: Default::default(), index: Vec::new(), spheres: Vec::new() };
        for (i, (primitive, _)) in (0..).zip(primitives) {
            match primitive {
                Primitive::Triangle { vertices, .. } => {
                    sieve.index.push(i);
                    for (lists, v) in sieve.corners.iter_mut().zip(vertices) {
                        for (list, x) in lists.iter_mut().zip(v.to_array()) {
                            list.push(f64::from(x));
                        }
                    }
                }
                Primitive::Sphere { .. } => sieve.spheres.push(i),
            }
        }
        sieve
    }

    /// Appends the indices of the primitives that the ray may hit.
    pub(super) fn pass(&self, ray: &Ray, found: &mut Vec<u32>) {
        found.extend(&self.spheres);
        let (o, d) = (ray.origin.as_dvec3(), ray.direction.as_dvec3());
        let a = d.abs();
        let z = if a.x >= a.y && a.x >= a.z { 0 } else { 1 + usize::from(a.y < a.z) };
        let (x, y) = ((z + 1) % 3, (z + 2) % 3);
        let (sx, sy) = (d[x] / d[z], d[y] / d[z]);
        // All coordinates of a compiled scene are at most 1.
        let bound = EDGE_BOUND * (1.0 + o.abs().max_element()) * 1.000_001;
        let mut at = 0;
        while at < self.index.len() {
            let end = (at + STEP).min(self.index.len());
            let mut out = [false; STEP];
            let flat = |corner: usize, i: usize| {
                let lists = &self.corners[corner];
                let depth = lists[z][i] - o[z];
                (lists[x][i] - o[x] - sx * depth, lists[y][i] - o[y] - sy * depth)
            };
            for (out, i) in out.iter_mut().zip(at..end) {
                let p = [flat(0, i), flat(1, i), flat(2, i)];
                let (mut left, mut right) = (false, false);
                for (p, q) in [(p[0], p[1]), (p[1], p[2]), (p[2], p[0])] {
                    let side = p.0 * q.1 - p.1 * q.0;
                    let slack = bound * ((q.0 - p.0).abs() + (q.1 - p.1).abs());
                    left |= side > slack;
                    right |= side < -slack;
                }
                *out = left & right;
            }
            let rest = self.index[at..end].iter().zip(out);
            found.extend(rest.filter(|(_, out)| !out).map(|(i, _)| i));
            at = end;
        }
    }
}
