use super::rounding::min;
use super::{Aabb, PreparedRay};
use glam::Vec3;

/// Where a ray hits a triangle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TriangleHit {
    /// Where on the ray; never NaN, infinite or -0.
    pub t: f32,
    /// Weight of vertex 1; vertex 0 has `1 - b1 - b2`.
    pub b1: f32,
    /// Weight of vertex 2.
    pub b2: f32,
}

/// Below this magnitude of an edge function the test is repeated in f64: 2⁻¹⁰⁰.
pub const EDGE_MIN: f32 = 1.0 / DET_MAX;
/// Above this magnitude of their sum the test is repeated in f64: 2¹⁰⁰.
pub const DET_MAX: f32 = (1_u128 << 100) as f32;

/// A triangle as the ray sees it: along `kx`, `ky` the distance from the ray, along the third `t`.
#[derive(Clone, Copy)]
struct Sheared {
    x: f32,
    y: f32,
    z: f32,
}

/// Edge functions agree in sign, and what follows from them, before the own box is asked.
struct Crossing {
    t: f32,
    b1: f32,
    b2: f32,
}

impl PreparedRay {
    /// The test of a ray and a triangle; both sides count. This is the reference: lanes reproduce it bit for bit.
    ///
    /// # Order of operations
    ///
    /// All f32, never fused; `(kx, ky, kz)` and `(sx, sy, sz)` are the ray's [`axis`](Self::axis) and
    /// [`shear`](Self::shear).
    ///
    /// 1. Per vertex: `a = v - o` on each axis; `x = a[kx] - sx * a[kz]`, `y = a[ky] - sy * a[kz]`, `z = sz * a[kz]`.
    /// 2. `U = x2*y1 - y2*x1`, `V = x0*y2 - y0*x2`, `W = x1*y0 - y1*x0`; `det = (U + V) + W`.
    /// 3. If `min(|U|, |V|, |W|) >= 2⁻¹⁰⁰` and `|det| <= 2¹⁰⁰`: it fails if one of `U, V, W` is below zero and one
    ///    above. `r = 1 / det`, `b0 = U * r`, `b1 = V * r`, `b2 = W * r`, `t = (b0*z0 + b1*z1) + b2*z2`.
    /// 4. Otherwise (a zero, a NaN, or numbers that f32 cannot hold) steps 2 and 3 again in f64 from the f32
    ///    values of step 1, without the condition; it fails if `det` is 0. `t`, `b1`, `b2` are rounded to f32.
    /// 5. The [own box](Self::own_box), to which `t` is [clamped](Self::accept).
    ///
    /// A lane may leave out step 4 where two of the f32 `U, V, W` have opposite signs: then it fails in any case, since
    /// the f32 sign, where it is not zero, is exact.
    ///
    /// # Why
    ///
    /// Rounding is monotone: `fl(a) - fl(b)` has the sign of `a - b` or is 0 (or, if both overflow, NaN). So the sign of each
    /// edge function, after step 4, is exact for the sheared vertices as rounded in step 1, which do not depend on the triangle
    /// but on its vertices alone. Two triangles that share an edge see one and the same edge function, with opposite signs; a closed
    /// mesh does not leak (Woop, Benthin, Wald 2013). `t` is a mean of the vertices' `z`, not a quotient of sums: it can neither
    /// overflow nor underflow before `z` does, nor lie far from the triangle, even where `det` is all rounding error.
    #[inline]
    #[must_use]
    pub fn triangle(&self, vertices: [Vec3; 3]) -> Option<TriangleHit> {
        let crossing = self.crossing(vertices)?;
        let own = self.own_box(&Aabb::of_triangle(vertices))?;
        let t = self.accept(crossing.t, own)?;
        Some(TriangleHit { t, b1: crossing.b1, b2: crossing.b2 })
    }

    #[inline(always)]
    fn crossing(&self, vertices: [Vec3; 3]) -> Option<Crossing> {
        let [v0, v1, v2] = vertices.map(|v| self.sheared(v));
        let u = v2.x * v1.y - v2.y * v1.x;
        let v = v0.x * v2.y - v0.y * v2.x;
        let w = v1.x * v0.y - v1.y * v0.x;
        let det = (u + v) + w;
        let least = min(min(u.abs(), v.abs()), w.abs());
        // A NaN among u, v, w is one in det: it is not lost in `min`.
        if !(least >= EDGE_MIN && det.abs() <= DET_MAX) {
            return crossing_in_f64([v0, v1, v2]);
        }
        if (u < 0.0 || v < 0.0 || w < 0.0) && (u > 0.0 || v > 0.0 || w > 0.0) {
            return None;
        }
        let r = 1.0 / det;
        let (b0, b1, b2) = (u * r, v * r, w * r);
        Some(Crossing { t: (b0 * v0.z + b1 * v1.z) + b2 * v2.z, b1, b2 })
    }

    #[inline(always)]
    fn sheared(&self, vertex: Vec3) -> Sheared {
        let (x, y, z) = self.permuted(vertex - self.origin);
        let [sx, sy, sz] = self.shear;
        Sheared { x: x - sx * z, y: y - sy * z, z: sz * z }
    }
}

/// Step 4. The products of two f32 are exact in f64, so each edge function has the sign of its exact value.
#[cold]
#[inline(never)]
fn crossing_in_f64([v0, v1, v2]: [Sheared; 3]) -> Option<Crossing> {
    let edge =
        |a: Sheared, b: Sheared| f64::from(a.x) * f64::from(b.y) - f64::from(a.y) * f64::from(b.x);
    let (u, v, w) = (edge(v2, v1), edge(v0, v2), edge(v1, v0));
    if (u < 0.0 || v < 0.0 || w < 0.0) && (u > 0.0 || v > 0.0 || w > 0.0) {
        return None;
    }
    let det = (u + v) + w;
    if det == 0.0 {
        return None;
    }
    let r = 1.0 / det;
    let (b0, b1, b2) = (u * r, v * r, w * r);
    let t = (b0 * f64::from(v0.z) + b1 * f64::from(v1.z)) + b2 * f64::from(v2.z);
    Some(Crossing { t: t as f32, b1: b1 as f32, b2: b2 as f32 })
}
