use core::f64::consts::{PI, TAU};

use glam::{DVec2, DVec3};

use super::shape::{Shaper, light, matt, metal};

pub(super) fn surfaces(n: u64) -> u64 {
    // 1 + 9 + 81 + .. up to 9ⁿ
    (9u64.pow(n as u32 + 1) - 1) / 8 + 4
}

/// Haines' sphereflake (Standard Procedural Databases, 1987): nine balls of a third of the radius
/// on every ball, six round its equator and three above.
pub(super) fn build(s: &mut Shaper, n: u32) {
    let colours = [
        [0.90, 0.72, 0.38],
        [0.86, 0.48, 0.30],
        [0.75, 0.78, 0.82],
        [0.40, 0.62, 0.80],
        [0.55, 0.78, 0.45],
        [0.85, 0.80, 0.50],
        [0.80, 0.40, 0.45],
        [0.65, 0.60, 0.85],
    ];
    let first = s.next_material();
    for (i, colour) in colours.iter().enumerate() {
        let mut material = metal(&format!("generation-{i}"), *colour, 0.0);
        material.diffuse = DVec3::from(*colour) * 0.45;
        material.specular = DVec3::from(*colour) * 0.5;
        s.material(material);
    }
    let ground = s.material(matt("ground", [0.30, 0.29, 0.28]));
    let lamp = s.material(light("lamp", [46.0, 41.0, 34.0]));

    s.sphere(DVec3::ZERO, 1.0, first);
    children(s, n, 1, DVec3::ZERO, 1.0, DVec3::Z, first);
    s.quad(DVec3::new(-30.0, -30.0, -1.01), DVec3::X * 60.0, DVec3::Y * 60.0, ground);
    s.lamp(
        DVec3::new(-5.5, -5.0, 6.0),
        DVec3::new(2.2, -2.2, 0.0),
        DVec3::new(1.6, 1.6, 1.5),
        lamp,
    );
    s.distant(DVec3::Z, PI, DVec3::new(0.26, 0.31, 0.40));
    s.view(DVec3::new(4.3, -6.6, 3.1), DVec3::new(0.0, 0.0, 0.3), 27.0, 1.25);
}

fn children(
    s: &mut Shaper,
    n: u32,
    depth: u32,
    center: DVec3,
    radius: f64,
    axis: DVec3,
    first: u16,
) {
    if depth > n {
        return;
    }
    let x = axis.any_orthonormal_vector();
    let y = axis.cross(x);
    let small = radius / 3.0;
    for i in 0..9 {
        let (turn, lift) = if i < 6 {
            (f64::from(i) / 6.0, 0.0)
        } else {
            ((f64::from(i) - 6.0) / 3.0 + 1.0 / 12.0, PI / 3.0)
        };
        let (round, up) = (DVec2::from_angle(TAU * turn), DVec2::from_angle(lift));
        let out = (x * round.x + y * round.y) * up.x + axis * up.y;
        let place = center + out * (radius + small);
        s.sphere(place, small, first + (depth as u16).min(7));
        children(s, n, depth + 1, place, small, out, first);
    }
}
