mod base;

pub(crate) use self::base::Base;
use self::base::unit;
use super::rounding::UNIT_ROUNDOFF;
use super::sphere::roots;
use super::{Aabb, Hit, PreparedRay, Primitive, Pyramid, Ray};
use crate::real::Vector;
use crate::scene::{Light, LightKind};
use glam::{DVec3, Vec3};

/// A point of a surface that a ray hit, from which other rays begin.
///
/// It is made from the primitive (the vertices by their weights, or the sphere), not from `origin + t * direction`, in
/// f64. So it lies on the surface to within 2⁻⁵⁰ of its coordinates, and only the last rounding to f32 is left to care about.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfacePoint {
    /// The point, rounded to the nearest f32: what shading uses. A ray must not begin here.
    pub position: Vec3,
    /// The unit geometric normal: of the side from which a triangle's vertices are counter-clockwise, of the
    /// sphere's outside (inside, if it faces inward).
    pub normal: Vec3,
    base: Base<f32>,
}

/// Where a shadow ray ends: a point on a light.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Target {
    /// The point.
    pub point: Vec3,
    /// A normal of the surface there, of unit length, to either side; zero if there is no surface.
    pub normal: Vec3,
    /// The greatest distance, along any axis, between the point and others of its surface.
    pub extent: f32,
    /// The greatest distance between the point, as rounded, and the surface that rays can hit.
    pub error: f32,
}

impl Target {
    /// A point on a light's surface, as computed in f32 from the light's table entry by a few operations, with a unit normal of the
    /// surface there. For points and spots, and with a normal of zero, it is [`free`](Self::free).
    #[must_use]
    pub fn on(light: &Light, point: Vec3, normal: Vec3) -> Self {
        let extent = match LightKind::from_u32(light.kind) {
            Some(LightKind::Sphere) => 2.0 * light.u[0],
            Some(LightKind::Parallelogram | LightKind::Triangle) => length(light),
            Some(LightKind::Disc) => 2.0 * length(light),
            _ => return Self::free(point),
        };
        let position = Vec3::from(light.position).abs().max_element();
        Self { point, normal, extent, error: TARGET_ERROR * (position + length(light)) }
    }

    /// A point where no surface is: a ray to it ends there.
    #[must_use]
    pub const fn free(point: Vec3) -> Self {
        Self { point, normal: Vec3::ZERO, extent: 0.0, error: 0.0 }
    }
}

/// Clearance of a shadow ray's end in parts of `R`, above [`PreparedRay::TRIANGLE_ERROR`]: see [`SurfacePoint::spawn_to`]. What is more than
/// 72 u leaves room for a pyramid to show that the light's surface lies beyond all rays that end before it.
pub(super) const CLEARANCE: f64 = 160.0 * UNIT_ROUNDOFF as f64;
/// The same where rays begin: a large surface must not lift them more than need be.
const LIFT: f64 = 72.0 * UNIT_ROUNDOFF as f64;
/// The distance between a light in the table and its surface in the blocks, and of a computed point on it from either, in parts of the
/// coordinates: three roundings of each corner, five of a sample.
pub(super) const TARGET_ERROR: f32 = 16.0 * UNIT_ROUNDOFF;
/// The distance between neighbouring f32, in parts of the number: at most.
const ULP: f64 = 2.0 * UNIT_ROUNDOFF as f64;

impl Hit {
    /// The point that a ray hit.
    #[must_use]
    #[cfg_attr(feature = "bundles", inline(always))]
    pub fn surface(&self, ray: &Ray) -> SurfacePoint {
        self.base(ray).into()
    }

    /// Where rays begin that leave the point that a ray hit.
    #[cfg_attr(feature = "bundles", inline(always))]
    pub(crate) fn base(&self, ray: &Ray) -> Base<f32> {
        match self.primitive {
            Primitive::Triangle { vertices, .. } => on_triangle(vertices, self.b1, self.b2),
            // Without spheres nothing has made such a hit: any point will do.
            Primitive::Sphere { center, .. } if !cfg!(feature = "sphere") => {
                on_triangle([center; 3], self.b1, self.b2)
            }
            Primitive::Sphere { center, radius, inward } => {
                on_sphere(ray, self.t, center, radius, inward)
            }
        }
    }
}

impl SurfacePoint {
    /// A ray from here, without end. It cannot hit this primitive again, whichever way it goes (but the far side of
    /// a sphere, from inside).
    ///
    /// It begins on the side of the surface that `direction` points to (the normal's, if it points to
    /// neither), off the surface by the clearance along the normal, and each axis is rounded
    /// away from the surface.
    ///
    /// # Why it cannot
    ///
    /// Let `R` be the greatest `|v - o|`, as in [`PreparedRay::triangle`], and the ray begin at a distance `h` from the
    /// plane, going away from it. If the test succeeds, the triangle has a point `Q` that the line of the ray
    /// passes within `6√2 u R`, so the line does so at a `t` with `h + t d·n <= 6√2 u R`, and the `t` that the test finds is larger by
    /// at most `32 u R / |d[kz]|`. As `d·n <= √3 |d[kz]|`, it is below zero if `h > (6√2 + 32√3) u R`, which is less than `64 u R`. Clamping to the own box does not
    /// raise it above zero: the box is entered no later than `Q`. The clearance is `72 u` times the greatest distance from the point to a
    /// vertex plus one step of f32 per axis, which pays for the displacement itself as well. No constant here has a unit of length.
    ///
    /// A sphere is tested in f64; there the clearance is what f32 rounding along the surface can lose to its curvature.
    #[must_use]
    #[cfg_attr(feature = "bundles", inline(always))]
    pub fn spawn(&self, direction: Vec3) -> Ray {
        let origin = self.origin_towards(direction.as_dvec3());
        Ray { origin, direction, t_min: 0.0, t_max: f32::INFINITY }
    }

    /// A ray from here to a target, which is at `t = 1 = t_max`. What it hits lies between: neither this primitive nor
    /// the surface of the target, if `target.error` and `target.extent` are right and each of the two points lies off the other's
    /// plane by more than the clearance. (If not, they see each other edge-on, at a cosine of some 10⁻⁵, and may be taken for hidden.)
    ///
    /// It ends before the target's surface by its error and by a clearance as in [`spawn`](Self::spawn), with the
    /// distance to the target's farthest point as `R`.
    #[must_use]
    pub fn spawn_to(&self, target: &Target) -> Ray {
        let end = target.point.as_dvec3();
        let origin = self.origin_towards(end - DVec3::from(self.base.exact));
        let back = origin.as_dvec3() - end;
        let normal = target.normal.as_dvec3();
        let distance = back.abs().max_element();
        let reach = distance + f64::from(target.extent) + ULP * end.abs().max_element();
        let clearance = f64::from(target.error) + CLEARANCE * reach;
        let off = if back.dot(normal) < 0.0 { -clearance } else { clearance };
        let direction = (normal * off - back).as_vec3();
        Ray { origin, direction, t_min: 0.0, t_max: 1.0 }
    }

    /// The pyramid of the shadow rays from here to a light that leave the surface on the side that `towards` points to, for
    /// ends on that side: rays of [`spawn_to`](Self::spawn_to) whose direction does not point back through the surface. The
    /// surface that they leave may touch it.
    #[must_use]
    pub fn pyramid_to(&self, light: &Light, towards: Vec3) -> Pyramid {
        let towards = towards.as_dvec3();
        let unit = DVec3::from(self.base.unit);
        let normal = if towards.dot(unit) < 0.0 { -unit } else { unit };
        Pyramid::from_surface(self.origin_towards(towards), normal, light)
    }

    /// The box of the two places, one on each side, where rays from here begin.
    #[must_use]
    pub fn origins(&self) -> Aabb {
        let [above, below] = [1.0, -1.0].map(|side| self.base.origin(side).into());
        Aabb::EMPTY.with(above).with(below)
    }

    #[cfg_attr(feature = "bundles", inline(always))]
    fn origin_towards(&self, direction: DVec3) -> Vec3 {
        let side = if direction.dot(self.base.unit.into()) < 0.0 { -1.0 } else { 1.0 };
        self.base.origin(side).into()
    }
}

impl From<Base<f32>> for SurfacePoint {
    #[inline(always)]
    fn from(base: Base<f32>) -> Self {
        Self { position: base.position().into(), normal: base.normal().into(), base }
    }
}

/// The greatest difference along an axis between two corners of a parallelogram or a triangle, at most.
fn length(light: &Light) -> f32 {
    let [u, v] = [light.u, light.v].map(|v| Vec3::from(v).abs().max_element());
    u + v
}

#[cfg_attr(feature = "bundles", inline(always))]
fn on_triangle(vertices: [Vec3; 3], b1: f32, b2: f32) -> Base<f32> {
    let (base, edges) = Base::on_triangle(vertices.map(Vector::from), [b1, b2]);
    if edges.has_normal() { base } else { Base { unit: edges.sliver_normal().into(), ..base } }
}

fn on_sphere(ray: &Ray, t: f32, center: Vec3, radius: f32, inward: bool) -> Base<f32> {
    let t = f64::from(t);
    let t = match roots(ray.origin, ray.direction, center, radius) {
        Some((near, far)) => {
            if (near - t).abs() <= (far - t).abs() {
                near
            } else {
                far
            }
        }
        None => t,
    };
    let (c, r) = (center.as_dvec3(), f64::from(radius));
    let from_center = ray.origin.as_dvec3() + ray.direction.as_dvec3() * t - c;
    let outward = unit(from_center).unwrap_or(DVec3::Z);
    let exact = c + outward * r;
    // Rounding moves the origin along the surface by up to a step of f32 per axis: √3 ULP < 2 ULP.
    let aside = 2.0 * ULP * exact.abs().max_element();
    let clearance = (aside * aside / r + r / f64::from(1 << 30)).min(r * 0.5);
    let unit = if inward { -outward } else { outward };
    Base { exact: exact.into(), unit: unit.into(), clearance }
}

impl PreparedRay {
    /// The ray that was prepared, with its present bounds.
    #[must_use]
    pub fn ray(&self) -> Ray {
        Ray { origin: self.origin, direction: self.direction, t_min: self.t_min, t_max: self.t_max }
    }
}

#[cfg(test)]
mod tests;
