use super::rounding::{UNIT_ROUNDOFF, max};
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

/// The f32 path is taken only if `|det|` is at least this part of `M`: a quarter.
pub const DET_PART: f32 = 0.25;
/// The f32 path is taken only if `|det|` is at least this: 2⁻¹⁰⁰.
pub const DET_MIN: f32 = 1.0 / DET_MAX;
/// The f32 path is taken only if `|det|` is at most this: 2¹⁰⁰.
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
    /// `64 u`: the point at a triangle's `t` is within this part of `R` of the triangle, see [`triangle`](Self::triangle).
    pub const TRIANGLE_ERROR: f32 = 64.0 * UNIT_ROUNDOFF;

    /// The test of a ray and a triangle; both sides count. This is the reference: lanes reproduce it bit for bit.
    ///
    /// # Order of operations
    ///
    /// All f32, never fused; `(kx, ky, kz)` and `(sx, sy, sz)` are the ray's axis and
    /// [`shear`](Self::shear).
    ///
    /// 1. Per vertex: `a = v - o` on each axis; `x = a[kx] - sx * a[kz]`, `y = a[ky] - sy * a[kz]`, `z = sz * a[kz]`.
    /// 2. `U = x2*y1 - y2*x1`, `V = x0*y2 - y0*x2`, `W = x1*y0 - y1*x0`. It fails if one of them is below
    ///    zero and another above. `det = (U + V) + W`; `M` is the greatest `|x|` times the greatest `|y|`.
    /// 3. If none of `U, V, W` is 0, `|det| >= M / 4` and `2⁻¹⁰⁰ <= |det| <= 2¹⁰⁰`: `r = 1 / det`,
    ///    `b0 = U * r`, `b1 = V * r`, `b2 = W * r`, `t = (b0*z0 + b1*z1) + b2*z2`.
    /// 4. Otherwise (also if there is a NaN) `U, V, W, det` again in f64 from the f32 values of step 1, with the same
    ///    test of signs; it fails if `det` is 0. `r, b0, b1, b2, t` as in step 3 in f64; `t`, `b1`, `b2` are rounded to f32.
    /// 5. The [own box](Self::own_box), to which `t` is [clamped](Self::accept).
    ///
    /// # Why
    ///
    /// Rounding is monotone: `fl(a) - fl(b)` has the sign of `a - b` or is 0 (or, if both overflow, NaN). So the sign of
    /// each edge function, after step 4, is exact for the sheared vertices as rounded in step 1, which depend on
    /// the vertex and not on the triangle. Two triangles that share an edge see one and the same edge function,
    /// with opposite signs: a closed mesh does not leak (Woop, Benthin, Wald 2013).
    ///
    /// `t` is a mean of the vertices' `z`, not a quotient of sums: it neither overflows nor underflows before `z` does. Its
    /// weights are as good as `det` is against the products that it is a difference of: that is what `M` asks.
    /// Without it, a sliver 10⁻⁶ wide has weights with no digit right, and `t` lies anywhere on its length.
    ///
    /// # Errors
    ///
    /// With `R` the greatest `|v - o|` over the vertices and axes: the sheared `x` and `y` err by at most `6 u R` (step 1 has
    /// six roundings of numbers up to `R`, one of which, `x`, up to `2 R`), so a ray that hits passes within `6√2 u R`
    /// of the exact triangle, and one that misses does not pass through it farther than that from its edges. In step 3 the
    /// weights err by `2 u M / det` each, which moves `t |d[kz]|` by at most `24 u R`, and the rest by `8 u R`; so the
    /// point at `t` lies within [`64 u R`](Self::TRIANGLE_ERROR) of the exact triangle: `6√2 + 32√3 < 64`.
    #[inline(always)]
    #[must_use]
    pub fn triangle(&self, vertices: [Vec3; 3]) -> Option<TriangleHit> {
        let crossing = self.crossing(vertices)?;
        let own = self.own_box(&Aabb::of_triangle(vertices))?;
        let t = self.accept(crossing.t, own)?;
        Some(TriangleHit { t, b1: crossing.b1, b2: crossing.b2 })
    }

    #[inline(always)]
    fn crossing(&self, vertices: [Vec3; 3]) -> Option<Crossing> {
        let [v0, v1, v2] = vertices;
        let (v0, v1, v2) = (self.sheared(v0), self.sheared(v1), self.sheared(v2));
        let u = v2.x * v1.y - v2.y * v1.x;
        let v = v0.x * v2.y - v0.y * v2.x;
        let w = v1.x * v0.y - v1.y * v0.x;
        if opposite(u, v, w) {
            return None;
        }
        let det = (u + v) + w;
        let greatest_x = max(max(v0.x.abs(), v1.x.abs()), v2.x.abs());
        let greatest_y = max(max(v0.y.abs(), v1.y.abs()), v2.y.abs());
        // A NaN among u, v, w is one in det, and fails.
        let sound = u != 0.0
            && v != 0.0
            && w != 0.0
            && det.abs() >= greatest_x * greatest_y * DET_PART
            && (DET_MIN..=DET_MAX).contains(&det.abs());
        if !sound {
            return crossing_in_f64([v0, v1, v2]);
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

#[inline(always)]
fn opposite<T: PartialOrd + Default>(u: T, v: T, w: T) -> bool {
    let zero = T::default();
    (u < zero || v < zero || w < zero) && (u > zero || v > zero || w > zero)
}

/// Step 4. The products of two f32 are exact in f64, so each edge function has the sign of its exact value.
#[cold]
#[inline(never)]
fn crossing_in_f64([v0, v1, v2]: [Sheared; 3]) -> Option<Crossing> {
    let edge =
        |a: Sheared, b: Sheared| f64::from(a.x) * f64::from(b.y) - f64::from(a.y) * f64::from(b.x);
    let (u, v, w) = (edge(v2, v1), edge(v0, v2), edge(v1, v0));
    if opposite(u, v, w) {
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
