#[cfg(feature = "bundles")]
use super::projected::Polygon;
#[cfg(feature = "bundles")]
use crate::real::{self, LANES, Mask, Row};
use crate::real::{Real, Vector};
#[cfg(feature = "bundles")]
use crate::scene::Light;
use crate::scene::LightKind;
use core::f32::consts::PI;
use glam::Vec3;

/// A parallelogram, triangle or disc: what of it does not depend on who looks at it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Plane {
    pub(super) kind: LightKind,
    pub(super) position: Vec3,
    pub(super) u: Vec3,
    pub(super) v: Vec3,
    pub(super) center: Vec3,
    /// Unit, on the side that shines.
    pub(super) normal: Vec3,
    pub(super) area: f32,
    /// Of the sphere round `center` that holds it.
    pub(super) radius: f32,
    /// The sum of all lengths that rounding depends on.
    pub(super) size: f32,
}

/// A [`Plane`] as points of surfaces see it, one in each lane.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Glance<R: Real> {
    /// Of the point above the plane; the light shines on it where it is above zero.
    pub(super) height: R,
    /// To the centre.
    pub(super) distance: R,
    /// No point of it is nearer.
    pub(super) nearest: R,
    /// Roughly, and never more than 2π.
    pub(super) solid_angle: R,
    /// Of its centre above the surface.
    pub(super) above: R,
    /// The square of the distance.
    pub(super) square: R,
}

impl Plane {
    /// `None` if it has no area.
    #[cfg_attr(feature = "bundles", inline(always))]
    pub(super) fn new(kind: LightKind, position: Vec3, u: Vec3, v: Vec3) -> Option<Self> {
        let (normal, area) = plane(kind, u, v)?;
        let (a, b) = (libm::sqrtf(u.dot(u)), libm::sqrtf(v.dot(v)));
        let radius = match kind {
            LightKind::Parallelogram => 0.5 * (a + b),
            LightKind::Triangle => a.max(b),
            _ => a,
        };
        let center = center(kind, position, u, v);
        let size = position.abs().max_element() + a + b;
        Some(Self { kind, position, u, v, center, normal, area, radius, size })
    }

    /// This light, if it is one and shines.
    #[cfg(feature = "bundles")]
    pub(crate) fn of(light: &Light) -> Option<Self> {
        let kind = LightKind::from_u32(light.kind)?;
        let is_flat =
            matches!(kind, LightKind::Parallelogram | LightKind::Triangle | LightKind::Disc);
        let [position, u, v, radiance] =
            [light.position, light.u, light.v, light.radiance].map(Vec3::from);
        let plane = is_flat.then(|| Self::new(kind, position, u, v)).flatten();
        plane.filter(|_| radiance.max_element() > 0.0)
    }

    /// From points of surfaces of these normals.
    #[inline(always)]
    pub(crate) fn glance<R: Real>(&self, from: Vector<R>, normal: Vector<R>) -> Glance<R> {
        let height = (from - self.position).on(self.normal);
        let to = Vector::same(height, self.center) - from;
        let square = to.dot(to);
        let distance = square.sqrt();
        // As from a disc of this area at the distance of the nearest edge, but no nearer than its height.
        let nearest = (distance - self.radius).greater(height);
        let cos = ((height + self.radius) / distance).at_most(1.0);
        let solid_angle =
            (cos * self.area / (nearest * nearest).greater(square * 0.25)).at_most(2.0 * PI);
        Glance { height, distance, nearest, solid_angle, above: to.dot(normal), square }
    }
}

/// The centre of such a shape; of another its position.
#[inline(always)]
pub(super) fn center(kind: LightKind, position: Vec3, u: Vec3, v: Vec3) -> Vec3 {
    match kind {
        LightKind::Parallelogram => position + (u + v) * 0.5,
        LightKind::Triangle => position + (u + v) * (1.0 / 3.0),
        _ => position,
    }
}

/// Unit normal and area.
pub(super) fn plane(kind: LightKind, u: Vec3, v: Vec3) -> Option<(Vec3, f32)> {
    let n = u.cross(v);
    let len = libm::sqrtf(n.dot(n));
    let area = match kind {
        LightKind::Triangle => 0.5 * len,
        LightKind::Disc => PI * len,
        _ => len,
    };
    (len > 0.0 && len.is_finite()).then(|| (n / len, area))
}

/// [`Glance`]s of a plane, a row for each of their numbers, and its [projected](super::Aim::projected) solid angles.
#[cfg(feature = "bundles")]
#[derive(Debug, Clone)]
pub(crate) struct GlanceRows {
    rows: [Row; 7],
    /// Those that have a projected solid angle, a bit each.
    projected: u32,
}

#[cfg(feature = "bundles")]
impl GlanceRows {
    /// None.
    pub(crate) const NONE: Self = Self { rows: [[0.0; LANES]; 7], projected: 0 };

    /// Takes those of points of surfaces from lane `first` on.
    #[inline(always)]
    pub(crate) fn put<R: Real>(
        &mut self,
        first: usize,
        plane: &Plane,
        from: Vector<R>,
        normal: Vector<R>,
    ) {
        let glance = plane.glance(from, normal);
        let Glance { height, distance, nearest, solid_angle, above, square } = glance;
        let [a, b, c, d, e, f, g] = &mut self.rows;
        real::put(a, first, height);
        real::put(b, first, distance);
        real::put(c, first, nearest);
        real::put(d, first, solid_angle);
        real::put(e, first, above);
        real::put(f, first, square);
        let lanes = (1_u32 << R::COUNT).wrapping_sub(1) << first;
        self.projected &= !lanes;
        if let Some(polygon) = Polygon::of(plane) {
            let (projected, has) = polygon.projected_from(from, normal, height);
            real::put(g, first, projected);
            self.projected |= has.lanes() << first;
        }
    }

    /// That of a lane, and its projected solid angle, if it has one.
    #[inline(always)]
    pub(crate) fn get(&self, lane: usize) -> (Glance<f32>, Option<f32>) {
        let [a, b, c, d, e, f, g] = &self.rows;
        let glance = Glance {
            height: real::at(a, lane),
            distance: real::at(b, lane),
            nearest: real::at(c, lane),
            solid_angle: real::at(d, lane),
            above: real::at(e, lane),
            square: real::at(f, lane),
        };
        (glance, (self.projected >> lane & 1 != 0).then_some(real::at(g, lane)))
    }
}

#[cfg(all(test, feature = "bundles"))]
mod tests {
    use super::*;
    use crate::light::Aim;
    use crate::material::Surface;
    use crate::trace::Scalar;
    use bytemuck::Zeroable;
    use proptest::prelude::*;

    fn point() -> impl Strategy<Value = Vec3> {
        prop::array::uniform3(-1.0f32..1.0).prop_map(Vec3::from)
    }

    proptest! {
        #[test]
        fn a_light_known_at_a_glance_is_the_one_that_is_looked_at(
            (kind, position, u, v) in (0_u32..3, point(), point(), point()),
            (size, reach) in (0.01f32..2.0, prop_oneof![Just(f32::INFINITY), 0.1f32..2.0]),
            (place, normal) in (point(), point()),
            lane in 0..LANES,
            numbers in prop::array::uniform2(0f32..1.0),
            answers: [bool; 2],
        ) {
            prop_assume!(normal.length() > 0.1);
            let normal = normal.normalize();
            let light = Light {
                kind,
                reach,
                position: position.to_array(),
                u: (u * size).to_array(),
                v: (v * size).to_array(),
                radiance: [1.0, 2.0, 3.0],
                cone_cos: -1.0,
                ..Light::zeroed()
            };
            let surface = Surface {
                position: place,
                above: place,
                below: place,
                normal,
                shading: normal,
                outgoing: normal,
                distance: 1.0,
                front: true,
                material: 0,
            };
            let plane = Plane::of(&light).unwrap();
            let mut rows = GlanceRows::NONE;
            rows.put::<f32>(lane, &plane, place.into(), normal.into());
            let known = Aim::known(&light, &plane, &rows.get(lane), place, answers);
            match (known, Aim::new(&light, &surface, answers)) {
                (Ok(mut known), Ok(mut seen)) => {
                    known.prepare();
                    seen.prepare();
                    prop_assert_eq!(known.estimate.to_bits(), seen.estimate.to_bits());
                    prop_assert_eq!(known.solid_angle.to_bits(), seen.solid_angle.to_bits());
                    prop_assert_eq!(known.sample(numbers), seen.sample(numbers));
                    let projected = |aim: &Aim| aim.projected(Scalar, normal).map(f32::to_bits);
                    prop_assert_eq!(projected(&known), projected(&seen));
                }
                (known, seen) => prop_assert_eq!(known.err(), seen.err()),
            }
        }
    }
}
