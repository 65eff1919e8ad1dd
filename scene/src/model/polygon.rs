//! Polygons, cut into triangles.

use earcut::Earcut;
use glam::DVec3;

use super::mesh::{area_direction, direction, is_valid};
use super::rings::rings;
use super::{Model, ModelError, NO_NORMAL};

impl Model {
    /// Enters a flat simple polygon, counter-clockwise seen from its front. Holes are joined to
    /// the outline by seams, edges that run there and back (as in Radiance). Points that repeat
    /// are allowed. It shares its vertices among its triangles.
    ///
    /// One that is not flat or crosses itself is cut as its projection along its mean normal, and
    /// counted; one that is bad otherwise is dropped and counted.
    ///
    /// # Errors
    /// If there are too many vertices or triangles.
    pub fn add_polygon(&mut self, material: u16, points: &[DVec3]) -> Result<(), ModelError> {
        let first = self.vertices.len();
        let known = self.triangles.len();
        let mut indices = Vec::with_capacity(points.len());
        for &point in points {
            indices.push(self.add_vertex(point)?);
        }
        self.add_polygon_face(material, &indices, &[])?;
        if self.triangles.len() == known {
            self.vertices.truncate(first);
        }
        Ok(())
    }

    /// As [`add_polygon`](Self::add_polygon), by indices of vertices of a mesh, and of shading
    /// normals: none at all, or one for each vertex.
    ///
    /// # Errors
    /// If there are too many triangles.
    pub fn add_polygon_face(
        &mut self,
        material: u16,
        vertices: &[u32],
        normals: &[u32],
    ) -> Result<(), ModelError> {
        let normal = |i: u32| normals.get(i as usize).copied().unwrap_or(NO_NORMAL);
        if let &[a, b, c] = vertices {
            return self.add_face(material, [a, b, c], [0, 1, 2].map(normal));
        }
        if !self.has_material(material) {
            return Ok(());
        }
        if vertices.len() < 3 {
            self.note("a polygon with fewer than three corners: dropped");
            return Ok(());
        }
        let corner = |&i: &u32| self.vertices.get(i as usize).copied();
        let Some(points) = vertices.iter().map(corner).collect::<Option<Vec<_>>>() else {
            self.note("a face with a vertex index out of range: dropped");
            return Ok(());
        };
        if !points.iter().copied().all(is_valid) {
            self.note("a face with a coordinate that is no number or beyond 1e100: dropped");
            return Ok(());
        }
        let Some(cut) = Cut::of(&points) else {
            self.note("a face without area: dropped");
            return Ok(());
        };
        if cut.bent {
            self.note("a polygon that is not flat: cut along its mean plane");
        }
        if cut.crossed {
            self.note("a polygon that crosses itself: cut as well as it goes");
        }
        for t in &cut.triangles {
            // Of corners that lie in a row: nothing is lost with it.
            let corner = |i: u32| points.get(i as usize).copied().unwrap_or_default();
            if !cut.crossed && area_direction(t.map(corner)).is_none() {
                continue;
            }
            let corners = t.map(|i| vertices.get(i as usize).copied().unwrap_or(u32::MAX));
            let entered = self.push_face(material, corners, t.map(normal))?;
            if let (Some(points), None) = (entered, cut.parallelogram) {
                self.light_triangle(material, points);
            }
        }
        if let Some([corner, u, v]) = cut.parallelogram {
            self.light_parallelogram(material, corner, u, v);
        }
        Ok(())
    }
}

/// How far a corner may lie off a polygon's plane, and a parallelogram's last corner off its
/// place, in sizes of the polygon: decimal input often has six digits.
const FLAT: f64 = 1e-5;

/// A polygon's triangles, as indices of its corners.
struct Cut {
    triangles: Vec<[u32; 3]>,
    /// Corner and edges, if the polygon is a parallelogram.
    parallelogram: Option<[DVec3; 3]>,
    bent: bool,
    crossed: bool,
}

impl Cut {
    /// `None` if the polygon has no area.
    fn of(points: &[DVec3]) -> Option<Self> {
        let &origin = points.first()?;
        let size = points.iter().map(|&p| (p - origin).abs().max_element()).fold(0.0, f64::max);
        if size <= 0.0 {
            return None;
        }
        let local: Vec<DVec3> = points.iter().map(|&p| (p - origin) / size).collect();
        let normal = direction(newell(&local))?;
        let bent = local.iter().any(|p| p.dot(normal).abs() > FLAT);
        if let [a, b, c, d] = *points {
            let quad = [[a, b, c], [a, c, d]];
            let front = |t| area_direction(t).is_some_and(|n| n.dot(normal) > 0.0);
            let other = [[a, b, d], [b, c, d]];
            if quad.into_iter().chain(other).all(front) {
                let edges = [a, b - a, d - a];
                let parallel = !bent && ((c - b) - (d - a)).abs().max_element() <= FLAT * size;
                return Some(Self {
                    triangles: vec![[0, 1, 2], [0, 2, 3]],
                    parallelogram: parallel.then_some(edges),
                    bent,
                    crossed: false,
                });
            }
        }
        let flat = project(&local, normal);
        let loops = [(0..flat.len() as u32).collect::<Vec<_>>()];
        let whole = signed_area(&loops[0], &flat);
        let is_whole = |triangles: &[[u32; 3]]| {
            let parts: f64 = triangles.iter().map(|t| signed_area(t, &flat)).sum();
            (whole - parts).abs() <= 1e-9 * (1.0 + whole.abs())
        };
        let mut triangles = ears(&loops, &flat);
        let mut crossed = !is_whole(&triangles);
        if crossed && let Some(rings) = outline_first(&flat) {
            let parts = ears(&rings, &flat);
            crossed = !is_whole(&parts);
            if !crossed {
                triangles = parts;
            }
        }
        Some(Self { triangles, parallelogram: None, bent, crossed })
    }
}

/// Newell's normal: twice the area, along the polygon's mean front.
fn newell(points: &[DVec3]) -> DVec3 {
    let next = points.iter().skip(1).chain(points.first());
    points.iter().zip(next).map(|(a, b)| a.cross(*b)).sum()
}

/// Onto the plane of the two axes that the normal is farthest from, so that a polygon's front
/// stays counter-clockwise.
fn project(points: &[DVec3], normal: DVec3) -> Vec<[f64; 2]> {
    let size = normal.abs();
    let (axis, u, v) = if size.x >= size.y && size.x >= size.z {
        (0, 1, 2)
    } else if size.y >= size.z {
        (1, 2, 0)
    } else {
        (2, 0, 1)
    };
    let (u, v) = if normal[axis] < 0.0 { (v, u) } else { (u, v) };
    points.iter().map(|p| [p[u], p[v]]).collect()
}

/// Outline and holes of a polygon with seams, if that is what it is.
fn outline_first(flat: &[[f64; 2]]) -> Option<Vec<Vec<u32>>> {
    let mut rings = rings(flat);
    let is_outline = |ring: &Vec<u32>| signed_area(ring, flat) > 0.0;
    let outline = rings.iter().position(is_outline)?;
    rings.swap(0, outline);
    let holes = rings.get(1..).unwrap_or_default();
    let is_joined = !holes.is_empty() && !holes.iter().any(is_outline);
    is_joined.then_some(rings)
}

/// Ear clipping of an outline and holes, triangles counter-clockwise.
fn ears(rings: &[Vec<u32>], flat: &[[f64; 2]]) -> Vec<[u32; 3]> {
    let corners = rings.concat();
    let point = |&i: &u32| flat.get(i as usize).copied().unwrap_or_default();
    let ends = rings.iter().scan(0, |end, ring| {
        *end += ring.len() as u32;
        Some(*end)
    });
    let holes: Vec<u32> = ends.take(rings.len().saturating_sub(1)).collect();
    let mut indices: Vec<u32> = Vec::new();
    Earcut::new().earcut(corners.iter().map(point), &holes, &mut indices);
    let turn = |t: [u32; 3]| if signed_area(&t, flat) < 0.0 { [t[0], t[2], t[1]] } else { t };
    let corner = |i: u32| corners.get(i as usize).copied().unwrap_or_default();
    indices.as_chunks::<3>().0.iter().map(|t| turn(t.map(corner))).collect()
}

/// Area of a polygon of points by index, above zero if counter-clockwise.
fn signed_area(polygon: &[u32], flat: &[[f64; 2]]) -> f64 {
    let point = |&i: &u32| flat.get(i as usize).copied().unwrap_or_default();
    let next = polygon.iter().skip(1).chain(polygon.first());
    let cross = polygon.iter().zip(next).map(|(a, b)| {
        let ([ax, ay], [bx, by]) = (point(a), point(b));
        ax * by - ay * bx
    });
    cross.sum::<f64>() / 2.0
}
