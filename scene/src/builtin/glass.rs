use core::f64::consts::PI;

use glam::{DAffine3, DVec3};

use super::shape::{Shaper, light, matt, metal, mirror, pane, plastic, solid_glass};

/// Squares of the floor along an edge.
const SQUARES: u32 = 24;

pub(super) const SURFACES: u64 =
    2 * (SQUARES * SQUARES) as u64 + 2 + 9 + TORUS + 3 * (2 + 12) + 2 * 2;
const TORUS: u64 = 2 * 24 * 64;

/// Every kind of specular surface, on a chequered floor before a pale wall.
pub(super) fn build(s: &mut Shaper) {
    floor(s);
    balls(s);
    panes(s);

    let warm = s.material(light("lamp", [30.0, 27.0, 22.0]));
    let cool = s.material(light("window", [7.0, 8.5, 11.0]));
    s.lamp(DVec3::new(-2.6, -2.2, 6.0), DVec3::Y * 2.0, DVec3::X * 2.0, warm);
    s.lamp(DVec3::new(5.8, -2.0, 1.2), DVec3::new(0.0, 3.6, 0.0), DVec3::new(0.0, 0.0, 2.6), cool);
    s.distant(DVec3::Z, PI, DVec3::new(0.16, 0.19, 0.24));
    s.view(DVec3::new(0.3, -7.4, 2.7), DVec3::new(0.05, 0.3, 0.78), 33.0, 1.5);
}

fn floor(s: &mut Shaper) {
    let dark = s.material(plastic("dark-tile", [0.06, 0.065, 0.075], 0.05, 0.0));
    let pale = s.material(plastic("pale-tile", [0.62, 0.60, 0.56], 0.05, 0.0));
    let wall = s.material(matt("wall", [0.52, 0.50, 0.46]));
    let edge = 0.5;
    for j in 0..SQUARES {
        for i in 0..SQUARES {
            let corner =
                DVec3::new(edge * (f64::from(i) - 12.0), edge * (f64::from(j) - 15.0), 0.0);
            let material = if (i + j) % 2 == 0 { dark } else { pale };
            s.quad(corner, DVec3::X * edge, DVec3::Y * edge, material);
        }
    }
    s.quad(DVec3::new(-6.0, 4.5, 0.0), DVec3::X * 12.0, DVec3::Z * 6.0, wall);
}

fn balls(s: &mut Shaper) {
    let clear = s.material(solid_glass("clear-glass", 1.52, [0.02, 0.01, 0.015]));
    let green = s.material(solid_glass("green-glass", 1.52, [2.6, 0.35, 1.5]));
    let amber = s.material(solid_glass("amber-glass", 1.52, [0.3, 1.6, 5.0]));
    let silver = s.material(mirror("mirror", [0.92, 0.92, 0.90]));
    let gold = s.material(metal("gold", [1.0, 0.76, 0.33], 0.06));
    let copper = s.material(metal("copper", [0.95, 0.60, 0.45], 0.14));
    let red = s.material(plastic("red-plastic", [0.55, 0.04, 0.03], 0.05, 0.03));
    let blue = s.material(plastic("blue-plastic", [0.04, 0.10, 0.48], 0.05, 0.08));

    s.sphere(DVec3::new(-1.75, 0.9, 1.0), 1.0, silver);
    s.sphere(DVec3::new(0.15, -0.55, 0.75), 0.75, clear);
    s.sphere(DVec3::new(1.85, 0.85, 0.9), 0.9, gold);
    s.sphere(DVec3::new(-1.35, -1.2, 0.4), 0.4, green);
    s.sphere(DVec3::new(1.55, -1.35, 0.42), 0.42, amber);
    s.sphere(DVec3::new(-0.55, -2.0, 0.26), 0.26, red);
    s.sphere(DVec3::new(0.75, -2.15, 0.22), 0.22, blue);
    s.sphere(DVec3::new(0.2, 2.1, 0.6), 0.6, red);
    s.at(DAffine3::from_translation(DVec3::new(2.75, -1.2, 0.16)), |s| {
        s.torus(0.38, 0.16, [24, 64], copper);
    });
    s.sphere(DVec3::new(-2.6, -1.4, 0.3), 0.3, copper);
}

fn panes(s: &mut Shaper) {
    let clear = s.material(pane("pane", [0.92, 0.94, 0.92]));
    let rose = s.material(pane("rose-pane", [0.9, 0.45, 0.5]));
    let teal = s.material(pane("teal-pane", [0.35, 0.8, 0.8]));
    let frame = s.material(metal("frame", [0.5, 0.5, 0.52], 0.1));
    for (x, turn, material) in [(-3.4, 0.5, teal), (0.0, 0.0, clear), (3.3, -0.55, rose)] {
        let place =
            DAffine3::from_translation(DVec3::new(x, 2.9, 0.0)) * DAffine3::from_rotation_z(turn);
        s.at(place, |s| {
            s.quad(DVec3::new(-0.9, 0.0, 0.08), DVec3::X * 1.8, DVec3::Z * 2.2, material);
            s.cuboid(DVec3::new(-0.95, -0.06, 0.0), DVec3::new(0.95, 0.06, 0.08), frame);
        });
    }
}
