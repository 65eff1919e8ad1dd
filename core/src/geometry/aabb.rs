use glam::Vec3;

/// An axis-aligned box. A flat one (`min == max` on an axis) is a box like any other.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Aabb {
    /// Lower corner.
    pub min: Vec3,
    /// Upper corner.
    pub max: Vec3,
}

impl Aabb {
    /// The box of nothing: the union with it changes nothing.
    pub const EMPTY: Self = Self { min: Vec3::INFINITY, max: Vec3::NEG_INFINITY };

    /// The *own box* of a triangle: that of its three vertices, without any padding.
    #[must_use]
    pub fn of_triangle(vertices: [Vec3; 3]) -> Self {
        let [a, b, c] = vertices;
        Self { min: a.min(b).min(c), max: a.max(b).max(c) }
    }

    /// The *own box* of a sphere: `center - radius` and `center + radius`, rounded outward by one
    /// step of f32, so that it holds every point of the exact sphere.
    #[must_use]
    pub fn of_sphere(center: Vec3, radius: f32) -> Self {
        let lo = center - Vec3::splat(radius);
        let hi = center + Vec3::splat(radius);
        Self {
            min: Vec3::new(lo.x.next_down(), lo.y.next_down(), lo.z.next_down()),
            max: Vec3::new(hi.x.next_up(), hi.y.next_up(), hi.z.next_up()),
        }
    }

    /// The least box that holds both.
    #[must_use]
    pub fn union(self, other: Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// The least box that holds this one and a point.
    #[must_use]
    pub fn with(self, point: Vec3) -> Self {
        Self { min: self.min.min(point), max: self.max.max(point) }
    }

    /// No point lies in it (also if a bound is NaN).
    #[must_use]
    pub fn is_empty(&self) -> bool {
        !self.min.cmple(self.max).all()
    }

    /// Whether all of `other` lies in it.
    #[must_use]
    pub fn contains(&self, other: &Self) -> bool {
        self.min.cmple(other.min).all() && self.max.cmpge(other.max).all()
    }

    /// Its middle.
    #[must_use]
    pub fn center(&self) -> Vec3 {
        self.min * 0.5 + self.max * 0.5
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sphere_lies_in_its_own_box_whatever_rounds() {
        // 1 + 1e-9 rounds to 1 and 1 - 2^-25 to 1 or below: the exact extent is outside both.
        for (c, r) in [(1.0, 1e-9), (-1.0, 3e-8), (0.1, 0.7), (1e20, 1.0), (1e-20, 1e20)] {
            let own = Aabb::of_sphere(Vec3::splat(c), r);
            assert!(f64::from(own.min.x) <= f64::from(c) - f64::from(r));
            assert!(f64::from(own.max.z) >= f64::from(c) + f64::from(r));
        }
    }

    #[test]
    fn a_flat_box_is_not_empty() {
        let own = Aabb::of_triangle([Vec3::ZERO, Vec3::X, Vec3::Y]);
        assert!(!own.is_empty());
        assert!(Aabb::EMPTY.is_empty());
        assert_eq!(Aabb::EMPTY.union(own), own);
        assert!(own.contains(&Aabb::EMPTY.with(Vec3::new(0.5, 0.5, 0.0))));
    }
}
