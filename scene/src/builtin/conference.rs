use core::f64::consts::TAU;

use glam::{DAffine3, DVec3};

use super::{
    random::Random,
    shape::{Shaper, light, matt, metal, plastic},
};

/// From table to table, across and along the room \[m\].
const PITCH: [f64; 2] = [4.4, 3.7];
/// Height of the room \[m\].
const HEIGHT: f64 = 3.1;
/// Height of a table \[m\].
const TABLE: f64 = 0.74;
/// Lamps across and along, at most: every node keeps them all.
const LAMPS_MAX: [u32; 2] = [16, 12];

pub(super) fn surfaces(n: u64) -> u64 {
    let [columns, rows] = lamps(grid(n as u32));
    let table = Shaper::count(|s| table(s, &Materials::default(), &mut Random(0)));
    n * table + u64::from(columns * rows) * 2 + 4 * 2
}

/// Columns and rows of tables, somewhat wider than long.
fn grid(n: u32) -> [u32; 2] {
    let columns = (1..n).find(|c| 2 * c * c >= 3 * n).unwrap_or(n);
    [columns, n.div_ceil(columns)]
}

/// Columns and rows of lamps: four for a table.
fn lamps([columns, rows]: [u32; 2]) -> [u32; 2] {
    [(2 * columns).min(LAMPS_MAX[0]), (2 * rows).min(LAMPS_MAX[1])]
}

#[derive(Default)]
struct Materials {
    wood: u16,
    steel: u16,
    seats: [u16; 2],
    paper: u16,
    china: u16,
    dark: u16,
    screen: u16,
}

/// `n` tables with eight chairs each, under a grid of lamps.
pub(super) fn build(s: &mut Shaper, n: u32) {
    let floor = s.material(matt("carpet", [0.17, 0.19, 0.23]));
    let wall = s.material(matt("wall", [0.62, 0.59, 0.54]));
    let accent = s.material(matt("accent-wall", [0.16, 0.30, 0.33]));
    let lamp = s.material(light("lamp", [11.0, 10.2, 9.0]));
    let materials = Materials {
        wood: s.material(plastic("wood", [0.44, 0.25, 0.12], 0.04, 0.03)),
        steel: s.material(metal("steel", [0.72, 0.73, 0.75], 0.12)),
        seats: [
            s.material(matt("seat-red", [0.52, 0.09, 0.06])),
            s.material(matt("seat-ochre", [0.62, 0.36, 0.07])),
        ],
        paper: s.material(matt("paper", [0.80, 0.80, 0.78])),
        china: s.material(plastic("china", [0.74, 0.74, 0.72], 0.05, 0.0)),
        dark: s.material(plastic("dark", [0.03, 0.03, 0.035], 0.05, 0.04)),
        screen: s.material(matt("screen", [0.10, 0.22, 0.42])),
    };

    let [columns, rows] = grid(n);
    let (width, length) = (PITCH[0] * f64::from(columns) + 1.0, PITCH[1] * f64::from(rows) + 2.0);
    let corner = DVec3::new(-width / 2.0, 0.0, 0.0);
    let (x, y, z) = (DVec3::X * width, DVec3::Y * length, DVec3::Z * HEIGHT);
    s.quad(corner, x, y, floor);
    s.quad(corner + y, x, z, accent);
    s.quad(corner, y, z, wall);
    s.quad(corner + x + y, -y, z, wall);

    let mut random = Random(0x636f_6e66);
    for index in 0..n {
        let (column, row) = (f64::from(index % columns), f64::from(index / columns));
        let place = DVec3::new(
            (column + 0.5 - f64::from(columns) / 2.0) * PITCH[0],
            (row + 0.5) * PITCH[1] + 1.2,
            0.0,
        );
        s.at(DAffine3::from_translation(place), |s| table(s, &materials, &mut random));
    }
    let [across, along] = lamps([columns, rows]);
    for j in 0..along {
        for i in 0..across {
            let share = |k: u32, of: u32| (f64::from(k) + 0.5) / f64::from(of);
            let place = corner + x * share(i, across) + y * share(j, along) + z * 0.99;
            // Broader where there are fewer for the room.
            let size = 0.42 * libm::sqrt(width * length / f64::from(across * along) / 4.7);
            s.lamp(
                place - DVec3::new(size, size / 2.0, 0.0),
                DVec3::Y * size,
                DVec3::X * 2.0 * size,
                lamp,
            );
        }
    }
    let back = (width / 2.0 - 0.5).min(9.0);
    s.view(
        DVec3::new(-back * 0.75, 0.25, 2.25),
        DVec3::new(back * 0.12, (length * 0.55).min(8.0), 0.55),
        46.0,
        1.6,
    );
}

fn table(s: &mut Shaper, m: &Materials, random: &mut Random) {
    s.plate([1.3, 0.58], 0.28, [TABLE - 0.035, TABLE], m.wood);
    for x in [-0.75, 0.75] {
        s.at(DAffine3::from_translation(DVec3::X * x), |s| {
            s.post(0.05, [0.03, TABLE - 0.035], 16, m.steel);
            s.plate([0.07, 0.42], 0.06, [0.0, 0.03], m.steel);
        });
    }
    for side in [-1.0, 1.0] {
        for seat in 0..3 {
            let x = (f64::from(seat) - 1.0) * 0.78;
            let facing = if side < 0.0 { 0.0 } else { TAU / 2.0 };
            chair(s, m, DVec3::new(x, side * 0.86, 0.0), facing, random);
        }
        chair(s, m, DVec3::new(side * 1.62, 0.0, 0.0), side * TAU / 4.0, random);
        for x in [-0.72, 0.06, 0.78] {
            on_table(s, m, DVec3::new(x, side * 0.33, TABLE), side, random);
        }
    }
}

/// A sheet of paper, and a cup or a computer.
fn on_table(s: &mut Shaper, m: &Materials, place: DVec3, side: f64, random: &mut Random) {
    let turn = random.range(-0.3, 0.3) + if side < 0.0 { 0.0 } else { TAU / 2.0 };
    let computer = random.below(3) == 0;
    s.at(DAffine3::from_translation(place) * DAffine3::from_rotation_z(turn), |s| {
        let (a, b) = (DVec3::new(-0.105, -0.15, 0.002), DVec3::new(0.21, 0.0, 0.0));
        s.quad(a, b, DVec3::Y * 0.297, m.paper);
        let lid = if computer { [0.16, 0.11] } else { [0.06, 0.045] };
        s.at(DAffine3::from_translation(DVec3::new(0.24, 0.02, 0.0)), |s| {
            s.plate(lid, 0.02, [0.001, 0.012], if computer { m.steel } else { m.china });
            if computer {
                let lean = DAffine3::from_translation(DVec3::new(0.0, 0.11, 0.012))
                    * DAffine3::from_rotation_x(TAU * 0.2);
                s.at(lean, |s| {
                    s.cuboid(DVec3::new(-0.16, 0.0, -0.004), DVec3::new(0.16, 0.21, 0.0), m.dark);
                    let corner = DVec3::new(-0.15, 0.01, 0.0005);
                    s.quad(corner, DVec3::X * 0.3, DVec3::Y * 0.19, m.screen);
                });
            } else {
                s.cuboid(DVec3::new(-0.03, -0.03, 0.012), DVec3::new(-0.02, -0.02, 0.02), m.dark);
                s.quad(DVec3::new(0.0, 0.0, 0.0125), DVec3::X * 0.03, DVec3::Y * 0.03, m.paper);
            }
        });
    });
    s.at(DAffine3::from_translation(place + DVec3::new(-0.2, 0.1 * side, 0.0)), |s| {
        s.lathe(&CUP, 20, m.china);
    });
}

/// Outside and inside of a cup: radius, height.
const CUP: [[f64; 2]; 7] = [
    [0.0, 0.0],
    [0.026, 0.0],
    [0.037, 0.03],
    [0.041, 0.085],
    [0.038, 0.085],
    [0.033, 0.03],
    [0.0, 0.012],
];

/// A swivel chair that faces +y, somewhat turned.
fn chair(s: &mut Shaper, m: &Materials, place: DVec3, facing: f64, random: &mut Random) {
    let cloth = m.seats[random.below(2)];
    let turn = facing + random.range(-0.35, 0.35);
    let moved = DVec3::new(random.range(-0.06, 0.06), random.range(-0.06, 0.06), 0.0);
    s.at(DAffine3::from_translation(place + moved) * DAffine3::from_rotation_z(turn), |s| {
        s.plate([0.24, 0.23], 0.09, [0.43, 0.49], cloth);
        let back = DAffine3::from_translation(DVec3::new(0.0, -0.24, 0.78))
            * DAffine3::from_rotation_x(TAU * 0.27);
        s.at(back, |s| s.plate([0.22, 0.21], 0.09, [-0.025, 0.025], cloth));
        s.rod(DVec3::new(0.0, -0.1, 0.44), DVec3::new(0.0, -0.24, 0.7), 0.018, 8, m.steel);
        s.post(0.03, [0.08, 0.43], 12, m.steel);
        for leg in 0..5 {
            s.at(DAffine3::from_rotation_z(TAU * f64::from(leg) / 5.0), |s| {
                s.rod(DVec3::Z * 0.1, DVec3::new(0.29, 0.0, 0.06), 0.016, 8, m.steel);
                s.at(DAffine3::from_translation(DVec3::new(0.29, 0.0, 0.03)), |s| {
                    s.ball(0.03, 6, m.dark);
                });
            });
        }
    });
}
