use super::{LIFT, ULP};
use crate::real::{Bits, Double, Number, Part, Real, Vector};
use glam::DVec3;

/// Points of surfaces, from which rays begin, one in each lane.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Base<R: Real> {
    /// The point.
    pub(super) exact: Vector<R::Double>,
    /// The unit normal.
    pub(super) unit: Vector<R::Double>,
    /// Distance from the surface, beyond which a ray that leaves it cannot hit it again.
    pub(super) clearance: R::Double,
}

impl<R: Real> Base<R> {
    /// A point of a triangle, whose normal is that of its edges if it has [one](Edges::has_normal).
    #[inline(always)]
    pub(crate) fn on_triangle(vertices: [Vector<R>; 3], [b1, b2]: [R; 2]) -> (Self, Edges<R>) {
        let [v0, v1, v2] = vertices;
        let [v0, v1, v2] = [v0.double(), v1.double(), v2.double()];
        let edges = Edges::new(v1 - v0, v2 - v0);
        let [e1, e2, _] = edges.along;
        let exact = v0 + e1 * b1.double() + e2 * b2.double();
        let [off0, off1, off2] = [(v0 - exact).abs(), (v1 - exact).abs(), (v2 - exact).abs()];
        let far = off2.greater(off1.greater(off0)).greatest();
        let clearance = far.same(LIFT) * (far + far.same(ULP) * exact.abs().greatest());
        (Self { exact, unit: edges.normal.unit, clearance }, edges)
    }

    /// The point, rounded to the nearest f32.
    #[inline(always)]
    pub(crate) fn position(&self) -> Vector<R> {
        self.exact.single()
    }

    /// The unit normal, rounded to the nearest f32.
    #[inline(always)]
    pub(crate) fn normal(&self) -> Vector<R> {
        self.unit.single()
    }

    /// Where rays begin that leave on the side of the normal; on the other, where `side` is below zero: see
    /// [`SurfacePoint::spawn`](super::SurfacePoint::spawn).
    #[cfg_attr(feature = "bundles", inline(always))]
    #[cfg_attr(not(feature = "bundles"), inline(never))]
    pub(crate) fn origin(&self, side: R) -> Vector<R> {
        let away = self.unit.turned(side);
        let p = self.exact + away * self.clearance;
        Vector {
            x: round_towards(p.x, away.x),
            y: round_towards(p.y, away.y),
            z: round_towards(p.z, away.z),
        }
    }
}

/// The edges of triangles, and their unit normals where these follow from them.
pub(crate) struct Edges<R: Real> {
    along: [Vector<R::Double>; 3],
    /// Of their lengths.
    squares: [R::Double; 3],
    normal: Unit<R>,
    is_sliver: R::Mask,
}

impl<R: Real> Edges<R> {
    #[inline(always)]
    fn new(e1: Vector<R::Double>, e2: Vector<R::Double>) -> Self {
        let e3 = e2 - e1;
        let [a, b, c] = [e1.dot(e1), e2.dot(e2), e3.dot(e3)];
        // Which edge it is nobody can foretell: the length alone takes no branch.
        let longest = c.greater(b.greater(a));
        let normal = Unit::of(e1.cross(e2));
        // The product is off by 2⁻⁵¹ of the square of the length at most: its direction by less than 10⁻¹².
        let is_sliver = (longest.same(SLIVER * SLIVER) * (longest * longest)).above(normal.square);
        Self { along: [e1, e2, e3], squares: [a, b, c], normal, is_sliver }
    }

    /// Whether the normal is exact enough.
    #[inline(always)]
    pub(crate) fn has_normal(&self) -> R::Mask {
        self.normal.is_sound & !self.is_sliver
    }
}

impl Edges<f32> {
    /// A unit normal of a sliver: it is made orthogonal to the longest edge once more. A triangle that is less
    /// than 2⁻²⁹ of its length wide is a line to the test, and any normal of the line will do.
    #[cfg_attr(not(feature = "bundles"), inline(always))]
    pub(super) fn sliver_normal(&self) -> DVec3 {
        let all = self.along.into_iter().zip(self.squares);
        let longest = all.reduce(|a, b| if b.1 > a.1 { b } else { a });
        let Some(along) = longest.and_then(|(e, _)| unit(e.into())) else { return DVec3::Z };
        let n = if self.normal.is_sound { self.normal.unit.into() } else { along };
        unit(n - along * n.dot(along))
            .filter(|n| n.dot(along).abs() < 1e-12)
            .unwrap_or_else(|| along.any_orthonormal_vector())
    }
}

/// The nearest f32 that is not on the wrong side of `x`: not below it if `sign` is above zero, not above if below.
///
/// Whether the nearest will do nobody can foretell: it is a number here, not a branch.
#[cfg_attr(feature = "bundles", inline(always))]
#[cfg_attr(not(feature = "bundles"), inline(never))]
pub(super) fn round_towards<D: Double>(x: D, sign: D) -> D::Real {
    let nearest = x.single();
    let back = nearest.double();
    let up = sign.is_positive() & x.above(back);
    let down = (-sign).is_positive() & back.above(x);
    // The bits of a number count its distance from zero, and a tiny number is rounded to the zero of its sign.
    let bits = nearest.bits();
    let sign = bits >> 31 << 1;
    let (inward, outward) = (sign.plus(u32::MAX), (sign ^ u32::MAX).plus(2));
    let step = Bits::select(up, outward, Bits::select(down, inward, bits.same(0)));
    Real::of_bits(bits.sum(step))
}

/// A triangle whose height is less than this part of its longest edge is a sliver.
const SLIVER: f64 = 1e-3;

/// Vectors at unit length, one in each lane.
struct Unit<R: Real> {
    unit: Vector<R::Double>,
    /// Of the length that it had.
    square: R::Double,
    /// Whether it had one, from 10⁻⁶⁰ to 10⁶⁰ at least.
    is_sound: R::Mask,
}

impl<R: Real> Unit<R> {
    #[inline(always)]
    fn of(v: Vector<R::Double>) -> Self {
        R::apart(ToUnit(v))
    }
}

/// [`Unit::of`].
struct ToUnit<D>(Vector<D>);

impl<D: Double> Part for ToUnit<D> {
    type Result = Unit<D::Real>;

    #[inline(always)]
    fn run(self) -> Self::Result {
        let square = self.0.dot(self.0);
        let length = square.sqrt();
        let is_sound = length.is_positive() & square.same(f64::INFINITY).above(length);
        Unit { unit: self.0 * (square.same(1.0) / length), square, is_sound }
    }
}

/// `v` at unit length.
pub(super) fn unit(v: DVec3) -> Option<DVec3> {
    let Unit { unit, is_sound, .. } = Unit::<f32>::of(v.into());
    is_sound.then(|| unit.into())
}
