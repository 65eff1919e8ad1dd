use core::f64::consts::PI;

use glam::DVec3;

use super::shape::{Shaper, light, matt, pane};

/// Shades along an axis: their cube is the number of materials, which every node keeps.
const SHADES: u32 = 6;

pub(super) fn surfaces(n: u64) -> u64 {
    12 * n * n * n + 4
}

/// n³ cubes in a grid of 10 m, each half as wide as its cell, red, green and blue by place.
pub(super) fn build(s: &mut Shaper, n: u32, transparent: bool) {
    let shades = n.min(SHADES);
    let first = s.next_material();
    let shade = |i: u32, of: u32| f64::from(i) / f64::from(of.max(2) - 1);
    for index in 0..shades.pow(3) {
        let place = [index % shades, index / shades % shades, index / shades / shades];
        let name = format!("colour-{}-{}-{}", place[0], place[1], place[2]);
        s.material(if transparent {
            pane(&name, place.map(|i| 0.45 + 0.5 * shade(i, shades)))
        } else {
            // Even steps to the eye.
            matt(&name, place.map(|i| 0.03 + 0.82 * libm::pow(shade(i, shades), 1.8)))
        });
    }
    let ground = s.material(matt("ground", [0.42, 0.42, 0.42]));
    let lamp = s.material(light("lamp", [30.0, 28.0, 25.0]));

    let cell = 10.0 / f64::from(n);
    let level =
        |i: u32| (f64::from(i) * f64::from(shades - 1) / f64::from(n.max(2) - 1) + 0.5) as u32;
    for k in 0..n {
        for j in 0..n {
            for i in 0..n {
                let lo = DVec3::new(f64::from(i), f64::from(j), f64::from(k)) + 0.25;
                let colour = level(i) + shades * (level(j) + shades * level(k));
                s.cuboid(lo * cell, (lo + 0.5) * cell, first + colour as u16);
            }
        }
    }
    s.quad(DVec3::new(-60.0, -60.0, -0.8), DVec3::X * 130.0, DVec3::Y * 130.0, ground);
    s.lamp(
        DVec3::new(14.0, -12.0, 20.0),
        DVec3::new(0.0, 7.0, 0.0),
        DVec3::new(-5.0, 0.0, 4.0),
        lamp,
    );
    s.distant(DVec3::Z, PI, DVec3::new(0.32, 0.36, 0.42));
    s.view(DVec3::new(22.0, -15.5, 15.0), DVec3::new(4.9, 5.1, 4.25), 32.0, 1.25);
}
