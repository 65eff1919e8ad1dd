use crate::block::octahedral;
use crate::geometry::{Base, Hit, Primitive, Ray};
use crate::real::{Real, Vector};
use glam::Vec3;

/// The place that a ray hit: all that shading needs of the geometry.
///
/// It is a function of the ray and the hit alone, so anyone can make it again.
///
/// # Shading normals
///
/// The geometric normal decides what is in front: light that comes from behind the surface never counts, so nothing leaks.
/// The shading normal is turned to the side that the ray came from, and bent towards the eye
/// where it would face away from it, just far enough to be seen; so silhouettes have no black rims.
/// Where the light is above the shaded horizon and below the real one, [`Bsdf`](super::Bsdf) fades it out smoothly.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Surface {
    /// On the primitive: what shading uses. Rays begin at [`origin`](Self::origin).
    pub position: Vec3,
    /// Where rays begin that leave on the side of `normal`: they cannot hit the primitive again
    /// ([`SurfacePoint::spawn`](crate::geometry::SurfacePoint::spawn)).
    pub above: Vec3,
    /// Where rays begin that go on behind it; `above` if none will.
    pub below: Vec3,
    /// Unit geometric normal, on the side that the ray came from.
    pub normal: Vec3,
    /// Unit shading normal: `shading · normal > 0`; the same as `normal` where the primitive is flat.
    pub shading: Vec3,
    /// Unit direction to where the ray came from.
    pub outgoing: Vec3,
    /// The length of the ray.
    pub distance: f32,
    /// The ray came from the primitive's front.
    pub front: bool,
    /// Index into the scene's material table.
    pub material: u16,
}

/// The least cosine between the shading normal and the direction to the eye.
const FACING_MIN: f32 = 1.0 / 64.0;

/// Where the surface comes from that a ray hit.
pub(crate) trait Surfacing {
    /// It; `through` if rays may go on behind it.
    fn surface(&self, ray: &Ray, hit: &Hit, through: bool) -> Surface;
}

/// It is made when it is asked for.
pub(crate) struct Anew;

impl Surfacing for Anew {
    #[inline(always)]
    fn surface(&self, ray: &Ray, hit: &Hit, through: bool) -> Surface {
        Surface::new(ray, hit, through)
    }
}

impl Surface {
    /// The surface that a ray hit; `through` if rays may go on behind it.
    #[must_use]
    #[cfg_attr(feature = "bundles", inline(always))]
    pub fn new(ray: &Ray, hit: &Hit, through: bool) -> Self {
        Self::of(Facing::of(ray, hit, through), hit)
    }

    /// Of what rays hit in lanes, one.
    #[cfg_attr(feature = "bundles", inline(always))]
    pub(super) fn of(facing: Facing<f32>, hit: &Hit) -> Self {
        let Facing { position, above, below, normal, outgoing, distance, side } = facing;
        let [normal, outgoing] = [normal, outgoing].map(Vec3::from);
        Self {
            position: position.into(),
            above: above.into(),
            below: below.into(),
            normal,
            shading: interpolated(hit).map_or(normal, |n| bent(n, normal, outgoing)),
            outgoing,
            distance,
            front: side > 0.0,
            material: hit.material,
        }
    }

    /// The origin of a ray that leaves to the side of `direction`.
    #[inline]
    #[must_use]
    pub fn origin(&self, direction: Vec3) -> Vec3 {
        if direction.dot(self.normal) < 0.0 { self.below } else { self.above }
    }
}

/// What of surfaces is made alike of any primitive, one in each lane.
pub(super) struct Facing<R: Real> {
    pub(super) position: Vector<R>,
    pub(super) above: Vector<R>,
    pub(super) below: Vector<R>,
    pub(super) normal: Vector<R>,
    pub(super) outgoing: Vector<R>,
    pub(super) distance: R,
    /// Below zero where the ray came from behind.
    pub(super) side: R,
}

impl Facing<f32> {
    /// Of a ray and its hit.
    #[cfg_attr(feature = "bundles", inline(always))]
    pub(super) fn of(ray: &Ray, hit: &Hit, through: bool) -> Self {
        Self::new(&hit.base(ray), ray.direction.into(), hit.t, through)
    }

    /// The same, where it is seldom asked for.
    #[cfg(feature = "bundles")]
    #[inline(never)]
    pub(super) fn alone(ray: &Ray, hit: &Hit, through: bool) -> Self {
        Self::of(ray, hit, through)
    }
}

impl<R: Real> Facing<R> {
    /// Of rays that end at these points.
    #[inline(always)]
    pub(super) fn new(base: &Base<R>, direction: Vector<R>, t: R, through: bool) -> Self {
        let length = direction.length();
        let outgoing = -direction / length;
        let normal = base.normal();
        let side = normal.dot(outgoing);
        let (one, none) = (side.same(1.0), side.same(0.0));
        let side = R::select(none.above(side), -one, one);
        let above = base.origin(side);
        Self {
            position: base.position(),
            above,
            below: if through { base.origin(-side) } else { above },
            normal: normal * side,
            outgoing,
            distance: t * length,
            side,
        }
    }
}

#[cfg_attr(not(feature = "bundles"), inline(never))]
fn interpolated(hit: &Hit) -> Option<Vec3> {
    let Primitive::Triangle { normals: Some([n0, n1, n2]), .. } = hit.primitive else {
        return None;
    };
    let [n0, n1, n2] = [octahedral::decode(n0)?, octahedral::decode(n1)?, octahedral::decode(n2)?];
    let n = n0 * (1.0 - hit.b1 - hit.b2) + n1 * hit.b1 + n2 * hit.b2;
    let len = libm::sqrtf(n.dot(n));
    // Normals that cancel say nothing.
    (len > 0.01).then(|| n / len)
}

/// Turns a shading normal to the side of the geometric one, and towards the eye where it faces away from it.
fn bent(shading: Vec3, normal: Vec3, outgoing: Vec3) -> Vec3 {
    let side = shading.dot(normal);
    if side == 0.0 {
        return normal;
    }
    let shading = if side < 0.0 { -shading } else { shading };
    let cos = shading.dot(outgoing);
    if cos >= FACING_MIN {
        return shading;
    }
    let bent = shading + outgoing * (FACING_MIN - cos);
    bent / libm::sqrtf(bent.dot(bent))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn hit(vertices: [Vec3; 3], normals: Option<[u32; 3]>, t: f32, b1: f32, b2: f32) -> Hit {
        let primitive = Primitive::Triangle { vertices, normals };
        Hit { t, b1, b2, material: 0, primitive, block: 0 }
    }

    fn ray(origin: Vec3, direction: Vec3) -> Ray {
        Ray { origin, direction, t_min: 0.0, t_max: f32::INFINITY }
    }

    #[test]
    fn normals_face_the_ray_and_the_front_is_counter_clockwise() {
        let vertices = [Vec3::ZERO, Vec3::X, Vec3::Y];
        let above = Surface::new(
            &ray(Vec3::new(0.25, 0.25, 2.0), Vec3::NEG_Z * 2.0),
            &hit(vertices, None, 1.0, 0.25, 0.25),
            true,
        );
        assert!(above.front);
        assert_eq!((above.normal, above.shading, above.outgoing), (Vec3::Z, Vec3::Z, Vec3::Z));
        assert_eq!((above.distance, above.position), (2.0, Vec3::new(0.25, 0.25, 0.0)));
        let below = Surface::new(
            &ray(Vec3::new(0.25, 0.25, -2.0), Vec3::Z),
            &hit(vertices, None, 2.0, 0.25, 0.25),
            true,
        );
        assert!(!below.front);
        assert_eq!(below.normal, Vec3::NEG_Z);
        assert!(below.origin(Vec3::NEG_Z).z < 0.0 && below.origin(Vec3::Z).z > 0.0);
    }

    #[test]
    fn slivers_have_their_normal() {
        let tiny = 1e-22;
        let vertices = [Vec3::ZERO, Vec3::X * tiny, Vec3::new(0.5 * tiny, tiny * 1e-6, 0.0)];
        let s = Surface::new(&ray(Vec3::Z, Vec3::NEG_Z), &hit(vertices, None, 1.0, 0.3, 0.3), true);
        assert_eq!(s.normal, Vec3::Z);
    }

    proptest! {
        #[test]
        fn shading_normals_are_seen_from_the_eye_and_from_the_front(
            n in prop::array::uniform3(prop::array::uniform3(-1.0f32..1.0)),
            d in prop::array::uniform3(-1.0f32..1.0),
        ) {
            let direction = Vec3::from(d);
            prop_assume!(direction.length() > 0.1 && direction.z.abs() > 1e-3);
            let codes = n.map(|n| octahedral::encode(Vec3::from(n)));
            let vertices = [Vec3::ZERO, Vec3::X, Vec3::Y];
            let s = Surface::new(&ray(Vec3::ZERO, direction), &hit(vertices, Some(codes), 0.0, 0.2, 0.3), true);
            prop_assert!((s.shading.length() - 1.0).abs() < 1e-5);
            prop_assert!(s.shading.dot(s.normal) > 0.0);
            prop_assert!(s.shading.dot(s.outgoing) > 0.0);
        }
    }
}
