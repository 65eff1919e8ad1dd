//! Cones, cylinders and rings, tessellated.

use std::f64::consts::TAU;

use glam::DVec3;
use kiloray_core::scene::LightKind;

use super::mesh::{direction, is_valid};
use super::{Model, ModelError, NO_NORMAL};

/// Sides of a tessellated cone, cylinder or ring.
///
/// Vertices lie on the true surface, so chords cut at most `1 - cos(π / 64)` = 0.12 % of the
/// radius off it, and a ring has 0.16 % less area. Shading normals are the true surface's.
pub const SIDES: u32 = 64;

impl Model {
    /// Enters a flat ring that faces along `normal`, with a hole if `inner` is above zero.
    ///
    /// Its triangles deviate from the circle as [`SIDES`] says; as a light, a ring without a hole
    /// is sampled as an exact disc. A bad one is dropped and counted.
    ///
    /// # Errors
    /// If there are too many vertices or triangles.
    pub fn add_ring(
        &mut self,
        material: u16,
        center: DVec3,
        normal: DVec3,
        [inner, outer]: [f64; 2],
    ) -> Result<(), ModelError> {
        let (inner, outer) = (inner.min(outer), inner.max(outer));
        let axis = direction(normal);
        let valid = is_valid(center) && is_valid(DVec3::splat(outer)) && inner >= 0.0;
        let (Some(axis), true, true) = (axis, valid, outer > inner) else {
            self.note(if inner < 0.0 {
                "a ring with a radius below zero: dropped"
            } else {
                "a ring without area, or with a value that is no number: dropped"
            });
            return Ok(());
        };
        if !self.has_material(material) {
            return Ok(());
        }
        let (x, y) = axis.any_orthonormal_pair();
        let circle = |radius: f64, i: u32| center + spoke(x, y, i) * radius;
        if inner > 0.0 {
            let pairs = self.circles(|i| [circle(inner, i), circle(outer, i)])?;
            return self.strip(material, &pairs, &[], false);
        }
        let mut rim = Vec::with_capacity(SIDES as usize);
        for i in 0..SIDES {
            rim.push(self.add_vertex(circle(outer, i))?);
        }
        // Halving keeps the triangles fat, unlike a fan from one corner, and needs no centre.
        let mut pending: Vec<(u32, u32)> = vec![(0, SIDES)];
        while let Some((from, to)) = pending.pop() {
            let middle = from.midpoint(to);
            let corner = |i: u32| rim.get((i % SIDES) as usize).copied().unwrap_or(u32::MAX);
            if to - from < SIDES {
                let corners = [corner(from), corner(middle), corner(to)];
                self.push_face(material, corners, [NO_NORMAL; 3])?;
            }
            if middle - from > 1 {
                pending.push((from, middle));
            }
            if to - middle > 1 {
                pending.push((middle, to));
            }
        }
        self.light(material, LightKind::Disc, center, x * outer, y * outer);
        Ok(())
    }

    /// Enters an open cone, or a cylinder if the radii are equal, from the circle of `radius[0]`
    /// round `ends[0]` to that of `radius[1]` round `ends[1]`. Its front is outside, or inside if
    /// `inward`. It deviates from the true surface as [`SIDES`] says; a bad one is dropped and
    /// counted.
    ///
    /// # Errors
    /// If there are too many vertices or triangles.
    pub fn add_cone(
        &mut self,
        material: u16,
        ends: [DVec3; 2],
        radius: [f64; 2],
        inward: bool,
    ) -> Result<(), ModelError> {
        let [a, b] = ends;
        let [ra, rb] = radius;
        let valid = is_valid(a) && is_valid(b) && is_valid(DVec3::new(ra, rb, 0.0));
        let round = ra.min(rb) >= 0.0 && ra.max(rb) > 0.0;
        let (Some(axis), true, true) = (direction(b - a), valid, round) else {
            self.note(if ra.min(rb) < 0.0 {
                "a cone or cylinder with a radius below zero: dropped"
            } else {
                "a cone or cylinder without area, or with a value that is no number: dropped"
            });
            return Ok(());
        };
        if !self.has_material(material) {
            return Ok(());
        }
        let (x, y) = axis.any_orthonormal_pair();
        let points = self.circles(|i| {
            let spoke = spoke(x, y, i);
            [a + spoke * ra, b + spoke * rb]
        })?;
        // The normal leans towards the narrow end.
        let lean = axis * ((ra - rb) / (b - a).length());
        let sign = if inward { -1.0 } else { 1.0 };
        let mut normals = Vec::with_capacity(SIDES as usize);
        for i in 0..SIDES {
            normals.push(self.add_normal((spoke(x, y, i) + lean) * sign)?);
        }
        self.strip(material, &points, &normals, !inward)
    }

    /// The vertices of two circles, pair by pair.
    fn circles(&mut self, point: impl Fn(u32) -> [DVec3; 2]) -> Result<Vec<[u32; 2]>, ModelError> {
        let mut pairs = Vec::with_capacity(SIDES as usize);
        for [a, b] in (0..SIDES).map(point) {
            let first = self.add_vertex(a)?;
            pairs.push([first, self.add_vertex(b)?]);
        }
        Ok(pairs)
    }

    /// Joins two circles that run counter-clockwise round the axis from first to second; the
    /// front is outside if `outward`.
    fn strip(
        &mut self,
        material: u16,
        pairs: &[[u32; 2]],
        normals: &[u32],
        outward: bool,
    ) -> Result<(), ModelError> {
        let next = (1..pairs.len()).chain([0]);
        for (i, j) in (0..pairs.len()).zip(next) {
            let (Some(&[a, b]), Some(&[c, d])) = (pairs.get(i), pairs.get(j)) else { continue };
            let n = |k: usize| normals.get(k).copied().unwrap_or(NO_NORMAL);
            let quad = [(a, n(i)), (c, n(j)), (d, n(j)), (b, n(i))];
            self.quad(material, quad, outward)?;
        }
        Ok(())
    }

    /// Enters a side; where an end is a point, a triangle.
    fn quad(
        &mut self,
        material: u16,
        mut quad: [(u32, u32); 4],
        outward: bool,
    ) -> Result<(), ModelError> {
        if !outward {
            quad.reverse();
        }
        let point = |i: usize| self.vertices.get(quad[i].0 as usize).copied().unwrap_or_default();
        let corners: Vec<(u32, u32)> =
            (0..4).filter(|&i| point(i) != point((i + 1) % 4)).map(|i| quad[i]).collect();
        let (vertices, normals): (Vec<u32>, Vec<u32>) = corners.into_iter().unzip();
        self.add_polygon_face(material, &vertices, &normals)
    }
}

/// The unit vector to corner `i` of a regular polygon.
fn spoke(x: DVec3, y: DVec3, i: u32) -> DVec3 {
    let (sin, cos) = libm::sincos(TAU * f64::from(i) / f64::from(SIDES));
    x * cos + y * sin
}
