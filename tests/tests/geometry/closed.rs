//! Closed surfaces do not leak, however their triangles are shaped.

use glam::Vec3;
use kiloray_core::geometry::{PreparedRay, Ray, TriangleHit};
use kiloray_tests::oracle::TriangleTruth;
use proptest::prelude::*;

use crate::cases::{decade, direction, point, runner, unit};

/// A subdivided octahedron whose vertices are moved along the rays from its middle: closed, and starlike from there.
fn closed(radii: &[f32], scale: Vec3) -> Vec<[Vec3; 3]> {
    let corners = [Vec3::X, Vec3::Y, -Vec3::X, -Vec3::Y];
    let mut faces: Vec<[Vec3; 3]> = Vec::new();
    for i in 0..4 {
        let (a, b) = (corners[i], corners[(i + 1) % 4]);
        faces.push([a, b, Vec3::Z]);
        faces.push([b, a, -Vec3::Z]);
    }
    for _ in 0..2 {
        faces = faces
            .iter()
            .flat_map(|&[a, b, c]| {
                let (ab, bc, ca) = (a + b, b + c, c + a);
                [[a * 2.0, ab, ca], [ab, b * 2.0, bc], [ca, bc, c * 2.0], [ab, bc, ca]]
            })
            .collect();
    }
    let moved = |v: Vec3| {
        let code = v
            .to_array()
            .map(|x| x.to_bits())
            .iter()
            .fold(7_u32, |h, b| (h ^ b).wrapping_mul(0x9e37_79b1).rotate_left(13));
        v.normalize() * scale * radii[code as usize % radii.len()]
    };
    faces.iter().map(|face| face.map(moved)).collect()
}

fn hits(mesh: &[[Vec3; 3]], ray: &Ray) -> Vec<TriangleHit> {
    let ray = PreparedRay::new(ray);
    mesh.iter().filter_map(|&v| ray.triangle(v)).collect()
}

#[test]
fn no_ray_leaves_a_closed_surface() {
    let radii = prop::collection::vec(0.3_f32..1.0, 5);
    // Flattened to 1e-5 of its width: its triangles are slivers from most sides.
    let flat = prop_oneof![2 => Just(1.0_f32), 1 => decade(-5, 0)];
    let aim = prop_oneof![2 => direction().prop_map(Err), 3 => (0..128_usize, unit(), 0..3_u32).prop_map(Ok)];
    let strategy = (
        radii,
        decade(-18, 18),
        flat,
        point(),
        prop_oneof![Just(0.0_f32), Just(100.0)],
        aim,
        point(),
    );
    let test =
        |(radii, size, flat, at, offset, aim, inside): (Vec<f32>, f32, f32, Vec3, f32, _, Vec3)| {
            let scale = Vec3::new(1.0, 1.0, flat) * size;
            let middle = at * scale * offset;
            let mesh: Vec<[Vec3; 3]> =
                closed(&radii, scale).iter().map(|f| f.map(|v| v + middle)).collect();
            // Every point this near to the middle is inside, whatever is rounded.
            let origin = middle + inside * scale * 0.1;
            let target: Result<(usize, f32, u32), Vec3> = aim;
            let direction = match target {
                Err(direction) => direction,
                // Through a shared vertex or edge, or the middle of a face.
                Ok((face, s, kind)) => {
                    let [a, b, c] = mesh[face % mesh.len()];
                    let target = [a, a + (b - a) * s, (a + b + c) / 3.0][kind as usize];
                    (target - origin) / size
                }
            };
            let ray = Ray { origin, direction, t_min: 0.0, t_max: f32::INFINITY };
            if PreparedRay::new(&ray).is_none() {
                return Ok(());
            }
            let found = hits(&mesh, &ray);
            prop_assert!(!found.is_empty(), "leak: {ray:?}");
            // Away from all borders, it is left once more often than it is entered.
            let near = mesh.iter().any(|&v| {
                let truth = TriangleTruth::new(&ray, v);
                !truth.surely_hit() && !truth.surely_missed()
            });
            prop_assert!(near || found.len() % 2 == 1, "{found:?} {ray:?}");
            Ok(())
        };
    runner(8_000).run(&strategy, test).unwrap();
}

#[test]
fn a_closed_fan_has_no_hole_and_its_closest_hit_does_not_depend_on_order() {
    let rim = prop::collection::vec((0.2_f32..1.0, -0.3_f32..0.3), 3..9);
    let strategy = (rim, decade(-18, 18), point(), 0..16_usize, unit());
    let test = |(rim, size, from, spoke, s): (Vec<(f32, f32)>, f32, Vec3, usize, f32)| {
        let n = rim.len();
        let rim: Vec<Vec3> = rim
            .iter()
            .enumerate()
            .map(|(i, &(r, z))| {
                let angle = i as f32 * core::f32::consts::TAU / n as f32;
                Vec3::new(angle.cos() * r, angle.sin() * r, z) * size
            })
            .collect();
        let fan: Vec<[Vec3; 3]> = (0..n).map(|i| [Vec3::ZERO, rim[i], rim[(i + 1) % n]]).collect();
        let origin = Vec3::new(from.x * 0.2, from.y * 0.2, 3.0 + from.z) * size;
        // To the middle, or to a point of a spoke well within the rim.
        let target = rim[spoke % n] * (s * 0.3);
        let ray = Ray { origin, direction: target - origin, t_min: 0.0, t_max: f32::INFINITY };
        if PreparedRay::new(&ray).is_none() {
            return Ok(());
        }
        prop_assert!(!hits(&fan, &ray).is_empty(), "leak: {ray:?} {fan:?}");
        Ok(())
    };
    runner(20_000).run(&strategy, test).unwrap();
}
