use super::{Hit, Primitive};
use core::cmp::Ordering;
use glam::Vec3;

impl Hit {
    /// Step 5: whether this hit comes before another of the same ray. It is an order of the hits
    /// themselves, so the closest does not depend on the order in which they were found.
    ///
    /// The lesser `t`; then the lesser material; then triangles before spheres; then the lesser
    /// coordinates, in the order vertex 0, 1, 2 and x, y, z, by [`f32::total_cmp`]; a sphere's are its centre and radius. Then flat before
    /// smooth, the lesser normals, outward before inward. What still ties is the same.
    #[must_use]
    pub fn is_closer_than(&self, other: &Self) -> bool {
        if self.t != other.t {
            return self.t < other.t;
        }
        self.material.cmp(&other.material).then_with(|| self.primitive.total_cmp(&other.primitive))
            == Ordering::Less
    }
}

impl Primitive {
    /// An order of all primitives by their own data, with nothing left to the place where they are stored: see
    /// [`Hit::is_closer_than`].
    #[must_use]
    pub fn total_cmp(&self, other: &Self) -> Ordering {
        match (self, other) {
            (
                Self::Triangle { vertices: a, normals: a_normals },
                Self::Triangle { vertices: b, normals: b_normals },
            ) => a
                .iter()
                .zip(b)
                .fold(Ordering::Equal, |order, (a, b)| order.then_with(|| cmp_point(*a, *b)))
                .then_with(|| a_normals.cmp(b_normals)),
            (
                Self::Sphere { center: a, radius: a_radius, inward: a_inward },
                Self::Sphere { center: b, radius: b_radius, inward: b_inward },
            ) => cmp_point(*a, *b)
                .then_with(|| a_radius.total_cmp(b_radius))
                .then_with(|| a_inward.cmp(b_inward)),
            (Self::Triangle { .. }, Self::Sphere { .. }) => Ordering::Less,
            (Self::Sphere { .. }, Self::Triangle { .. }) => Ordering::Greater,
        }
    }
}

fn cmp_point(a: Vec3, b: Vec3) -> Ordering {
    a.x.total_cmp(&b.x).then_with(|| a.y.total_cmp(&b.y)).then_with(|| a.z.total_cmp(&b.z))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn triangle(t: f32, material: u16, x: f32) -> Hit {
        let vertices = [Vec3::ZERO, Vec3::X, Vec3::new(x, 1.0, 0.0)];
        let primitive = Primitive::Triangle { vertices, normals: None };
        Hit { t, b1: 0.0, b2: 0.0, material, primitive, block: 0 }
    }

    fn sphere(t: f32, material: u16, radius: f32, inward: bool) -> Hit {
        let primitive = Primitive::Sphere { center: Vec3::ZERO, radius, inward };
        Hit { t, b1: 0.0, b2: 0.0, material, primitive, block: 0 }
    }

    #[test]
    fn each_rank_decides_only_among_equals_of_the_one_before() {
        let smooth = |codes| {
            let mut hit = triangle(1.0, 0, 0.5);
            if let Primitive::Triangle { normals, .. } = &mut hit.primitive {
                *normals = Some(codes);
            }
            hit
        };
        let sorted = [
            triangle(0.5, 9, 9.0),
            triangle(1.0, 0, -0.0),
            triangle(1.0, 0, 0.0),
            triangle(1.0, 0, 0.5),
            smooth([0, 1, 2]),
            smooth([0, 1, 3]),
            sphere(1.0, 0, 0.5, false),
            sphere(1.0, 0, 0.5, true),
            sphere(1.0, 0, 0.75, false),
            triangle(1.0, 1, -5.0),
            sphere(2.0, 0, 0.1, false),
        ];
        for (i, a) in sorted.iter().enumerate() {
            for (j, b) in sorted.iter().enumerate() {
                assert_eq!(a.is_closer_than(b), i < j, "{a:?} {b:?}");
            }
        }
    }
}
