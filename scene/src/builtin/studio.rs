use core::f64::consts::TAU;

use glam::{DAffine3, DVec2, DVec3};

use super::{
    clutter,
    random::Random,
    shape::{Shaper, light, matt, metal, mirror, plastic},
};

/// Four heaps on four stands in a room of 14 m × 11 m × 4.5 m.
const SPOTS: [[f64; 2]; 4] = [[-2.2, 1.1], [0.35, -1.1], [2.5, 1.5], [-0.15, 3.6]];
/// Radius of a stand and its height \[m\].
const STAND: [f64; 2] = [0.95, 0.55];
const STAND_SEGMENTS: u32 = 64;

pub(super) fn surfaces(n: u64) -> u64 {
    let object = |i: u64| Shaper::count(|s| clutter::add(s, i as usize, 0));
    let shapes = clutter::SHAPES as u64;
    let whole: u64 = (0..shapes).map(object).sum();
    let rest: u64 = (0..n % shapes).map(object).sum();
    let stand = Shaper::count(|s| s.post(STAND[0], [0.0, STAND[1]], STAND_SEGMENTS, 0));
    n / shapes * whole + rest + 4 * stand + 4 * 2 + 3 * 2
}

/// Much detail in little space, and much space without any.
pub(super) fn build(s: &mut Shaper, n: u32) {
    let floor = s.material(plastic("floor", [0.34, 0.33, 0.32], 0.03, 0.02));
    let wall = s.material(matt("wall", [0.60, 0.58, 0.55]));
    let stand = s.material(matt("stand", [0.72, 0.71, 0.69]));
    let warm = s.material(light("softbox", [14.0, 12.6, 10.6]));
    let cool = s.material(light("strip", [5.0, 6.0, 7.4]));
    let objects = palette(s);

    s.quad(DVec3::new(-7.0, -5.5, 0.0), DVec3::X * 14.0, DVec3::Y * 11.0, floor);
    s.quad(DVec3::new(-7.0, 5.5, 0.0), DVec3::X * 14.0, DVec3::Z * 4.5, wall);
    s.quad(DVec3::new(-7.0, -5.5, 0.0), DVec3::Y * 11.0, DVec3::Z * 4.5, wall);
    s.quad(DVec3::new(7.0, 5.5, 0.0), DVec3::Y * -11.0, DVec3::Z * 4.5, wall);
    s.lamp(DVec3::new(-3.6, -4.2, 4.4), DVec3::Y * 2.2, DVec3::new(2.2, 0.0, 0.0), warm);
    s.lamp(DVec3::new(2.6, 0.2, 4.4), DVec3::Y * 1.6, DVec3::X * 1.6, warm);
    s.lamp(DVec3::new(6.9, -3.0, 0.7), DVec3::Y * 3.0, DVec3::Z * 2.6, cool);

    for [x, y] in SPOTS {
        s.at(DAffine3::from_translation(DVec3::new(x, y, 0.0)), |s| {
            s.post(STAND[0], [0.0, STAND[1]], STAND_SEGMENTS, stand);
        });
    }
    let mut random = Random(0x7374_7564_696f);
    for (spot, [x, y]) in SPOTS.into_iter().enumerate() {
        let place = DAffine3::from_translation(DVec3::new(x, y, STAND[1]));
        let mine = (0..n as usize).filter(|i| i % 4 == spot);
        s.at(place, |s| heap(s, mine, n, &objects, &mut random));
    }
    s.view(DVec3::new(-0.4, -5.3, 2.35), DVec3::new(0.05, 0.9, 0.85), 40.0, 1.6);
}

fn palette(s: &mut Shaper) -> Vec<u16> {
    let mut all = Vec::new();
    let colours = [
        ("coral", [0.72, 0.16, 0.10]),
        ("ochre", [0.72, 0.42, 0.06]),
        ("sage", [0.22, 0.42, 0.18]),
        ("teal", [0.03, 0.34, 0.36]),
        ("navy", [0.04, 0.09, 0.30]),
        ("plum", [0.28, 0.05, 0.22]),
        ("cream", [0.76, 0.70, 0.56]),
        ("slate", [0.16, 0.19, 0.22]),
    ];
    for (i, (name, colour)) in colours.into_iter().enumerate() {
        all.push(s.material(if i % 2 == 0 {
            plastic(name, colour, 0.05, 0.04)
        } else {
            matt(name, colour)
        }));
    }
    all.push(s.material(metal("brass", [0.92, 0.72, 0.36], 0.08)));
    all.push(s.material(mirror("chrome", [0.82, 0.83, 0.85])));
    all
}

/// Drops objects on the stand: each comes to rest on the highest one below it.
fn heap(
    s: &mut Shaper,
    objects: impl Iterator<Item = usize>,
    of: u32,
    materials: &[u16],
    random: &mut Random,
) {
    // What a heap holds does not depend on how finely it is cut.
    let size = 0.92 * libm::cbrt(1.0 / f64::from(of.max(4)));
    const CELLS: usize = 48;
    let mut height = vec![0.0f64; CELLS * CELLS];
    for object in objects {
        let scale = size * random.range(0.65, 1.35);
        // Of a few places the lowest, as what rolls finds it.
        let places: [_; 5] = std::array::from_fn(|_| {
            let far = (STAND[0] - scale).max(0.0) * libm::sqrt(random.unit()) * 0.97;
            let round = DVec2::from_angle(TAU * random.unit()) * far;
            let near = |cell: &usize| {
                let [i, j] = [cell % CELLS, cell / CELLS]
                    .map(|c| STAND[0] * (2.0 * (c as f64 + 0.5) / CELLS as f64 - 1.0));
                (DVec2::new(i, j) - round).length() < 0.7 * scale
            };
            let cells: Vec<_> = (0..CELLS * CELLS).filter(near).collect();
            let rest = cells.iter().map(|&cell| height[cell]).fold(0.0, f64::max);
            (rest, round, cells)
        });
        let Some((rest, round, cells)) = places.into_iter().min_by(|a, b| a.0.total_cmp(&b.0))
        else {
            continue;
        };
        let place = DAffine3::from_translation(round.extend(rest))
            * DAffine3::from_rotation_z(TAU * random.unit())
            * DAffine3::from_scale(DVec3::splat(scale));
        let material = materials[random.below(materials.len())];
        s.at(place, |s| clutter::add(s, object % clutter::SHAPES, material));
        for cell in cells {
            height[cell] = rest + 1.3 * scale;
        }
    }
}
