use core::f64::consts::TAU;

use glam::{DAffine3, DVec3};

use super::shape::Shaper;

/// Number of shapes.
pub(super) const SHAPES: usize = 7;

/// Puts shape number `shape`, about 1 in radius and standing on z = 0.
pub(super) fn add(s: &mut Shaper, shape: usize, material: u16) {
    let up = |z: f64| DAffine3::from_translation(DVec3::Z * z);
    match shape {
        0 => s.at(up(0.9) * DAffine3::from_rotation_x(TAU / 4.0), |s| {
            s.knot([2.0, 3.0], 1.05, [12, 96], material);
        }),
        1 => s.at(up(0.3), |s| s.torus(0.7, 0.3, [10, 24], material)),
        2 => s.at(up(0.85), |s| s.ball(0.85, 12, material)),
        3 => s.lathe(&VASE, 24, material),
        4 => s.cuboid(DVec3::new(-0.65, -0.65, 0.0), DVec3::new(0.65, 0.65, 1.3), material),
        5 => s.lathe(&[[0.0, 0.0], [0.8, 0.0], [0.0, 1.6]], 24, material),
        _ => s.at(up(0.75), |s| s.knot([3.0, 5.0], 1.0, [8, 160], material)),
    }
}

/// Outside and inside of a vase: radius, height.
const VASE: [[f64; 2]; 10] = [
    [0.0, 0.0],
    [0.42, 0.0],
    [0.62, 0.25],
    [0.7, 0.55],
    [0.6, 0.95],
    [0.36, 1.3],
    [0.32, 1.5],
    [0.46, 1.72],
    [0.40, 1.72],
    [0.26, 1.5],
];
