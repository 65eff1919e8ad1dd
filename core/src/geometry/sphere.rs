use super::{Aabb, PreparedRay};
use glam::Vec3;

/// Where a line crosses a sphere: both roots, before the own box and the ray's bounds are asked.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SphereRoots {
    /// The lesser `t`: the line enters.
    pub near: f32,
    /// The greater `t`: the line leaves.
    pub far: f32,
}

impl PreparedRay {
    /// The test of a ray and a sphere: the least accepted `t`. Both roots are asked, so that a ray that begins inside
    /// hits the far side.
    ///
    /// Each root is treated like a triangle's `t`: clamped to the interval of the
    /// [own box](Self::own_box), then held against the ray's bounds.
    #[must_use]
    pub fn sphere(&self, center: Vec3, radius: f32) -> Option<f32> {
        let roots = sphere_roots(self.origin, self.direction, center, radius)?;
        let own = self.own_box(&Aabb::of_sphere(center, radius))?;
        self.accept(roots.near, own).or_else(|| self.accept(roots.far, own))
    }
}

/// Both roots, in f64: exact enough that the f32 input is what limits them. On a machine without f64 it is slow, but the
/// same to the bit.
///
/// The form is that of Haines, Günther, Akenine-Möller (Ray Tracing Gems, ch. 7): the discriminant from the distance between the
/// centre and the line, the lesser root from the product of both. With `f = o - c` and
/// `a = d·d`, `b = -f·d`, `l = f + (b/a) d`:
/// `D = r² - l·l`, `q = b ± sqrt(a D)` with the sign of `b`, the roots are `q / a` and `(f·f - r²) / q`.
///
/// The distance of line and centre, `|l|`, errs by less than `2⁻⁴⁹ |f|`: hit and miss may differ from the exact
/// answer only where the line comes that close to touching the sphere.
#[must_use]
pub fn sphere_roots(
    origin: Vec3,
    direction: Vec3,
    center: Vec3,
    radius: f32,
) -> Option<SphereRoots> {
    let (near, far) = roots(origin, direction, center, radius)?;
    Some(SphereRoots { near: near as f32, far: far as f32 })
}

/// The same, not rounded.
pub(super) fn roots(
    origin: Vec3,
    direction: Vec3,
    center: Vec3,
    radius: f32,
) -> Option<(f64, f64)> {
    let d = direction.as_dvec3();
    let f = origin.as_dvec3() - center.as_dvec3();
    let r = f64::from(radius);
    let a = d.dot(d);
    let b = -f.dot(d);
    let l = f + (b / a) * d;
    let discriminant = r * r - l.dot(l);
    // Written so that a NaN fails.
    if !(discriminant >= 0.0 && r > 0.0) {
        return None;
    }
    let root = libm::sqrt(a * discriminant);
    let q = if b < 0.0 { b - root } else { b + root };
    if q == 0.0 {
        // The line touches the sphere at the origin of the ray.
        return Some((0.0, 0.0));
    }
    // f·f - r² without the cancellation of a difference of squares.
    let f_len = libm::sqrt(f.dot(f));
    let (t0, t1) = (q / a, (f_len - r) * (f_len + r) / q);
    Some(if t0 < t1 { (t0, t1) } else { (t1, t0) })
}
