use glam::DVec3;

use super::shape::{Shaper, light, matt};

pub(super) const SURFACES: u64 = 2 + 8 + 8 + 20;

/// Corners of one face as the data sheet gives them: millimetres, y up, x to the left.
type Face = [[f64; 3]; 4];

const FLOOR: Face = [[552.8, 0., 0.], [0., 0., 0.], [0., 0., 559.2], [549.6, 0., 559.2]];
const BACK: Face = [[549.6, 0., 559.2], [0., 0., 559.2], [0., 548.8, 559.2], [556., 548.8, 559.2]];
const RIGHT: Face = [[0., 0., 559.2], [0., 0., 0.], [0., 548.8, 0.], [0., 548.8, 559.2]];
const LEFT: Face = [[552.8, 0., 0.], [549.6, 0., 559.2], [556., 548.8, 559.2], [556., 548.8, 0.]];
const CEILING: Face =
    [[556., 548.8, 0.], [556., 548.8, 559.2], [0., 548.8, 559.2], [0., 548.8, 0.]];
const LAMP: Face =
    [[343., 548.8, 227.], [343., 548.8, 332.], [213., 548.8, 332.], [213., 548.8, 227.]];
/// Tops of the blocks.
const BLOCKS: [Face; 2] = [
    [[130., 165., 65.], [82., 165., 225.], [240., 165., 272.], [290., 165., 114.]],
    [[423., 330., 247.], [265., 330., 296.], [314., 330., 456.], [472., 330., 406.]],
];

/// The Cornell box by its measured data (Cornell University Program of Computer Graphics), one
/// unit to 100 mm and z up. The lamp fills its hole in the ceiling.
pub(super) fn build(s: &mut Shaper) {
    // The spectra of the data sheet as linear RGB.
    let white = s.material(matt("white", [0.725, 0.71, 0.68]));
    let red = s.material(matt("red", [0.63, 0.065, 0.05]));
    let green = s.material(matt("green", [0.14, 0.45, 0.091]));
    let lamp = s.material(light("lamp", [17.0, 12.0, 4.0]));

    for (face, material) in [(FLOOR, white), (BACK, white), (RIGHT, green), (LEFT, red)] {
        add(s, face, material);
    }
    for i in 0..4 {
        let j = (i + 1) % 4;
        add(s, [CEILING[i], CEILING[j], LAMP[j], LAMP[i]], white);
    }
    for top in BLOCKS {
        add(s, top, white);
        for i in 0..4 {
            let (here, next) = (top[i], top[(i + 1) % 4]);
            add(s, [foot(here), foot(next), next, here], white);
        }
    }
    let [a, b, _, d] = LAMP.map(place);
    s.lamp(a, b - a, d - a, lamp);
    s.view(place([278.0, 273.0, -800.0]), place([278.0, 273.0, 0.0]), 39.3, 1.0);
}

fn foot([x, _, z]: [f64; 3]) -> [f64; 3] {
    [x, 0.0, z]
}

/// A turn, so that fronts stay fronts.
fn place([x, y, z]: [f64; 3]) -> DVec3 {
    DVec3::new(-x, z, y) / 100.0
}

fn add(s: &mut Shaper, face: Face, material: u16) {
    s.facets(&face.map(place), &[[0, 1, 2], [0, 2, 3]], material);
}
