use glam::DVec3;

use super::shape::{Patch, Shaper, light, plastic};

pub(super) fn surfaces(n: u64) -> u64 {
    2 * n * n + 2
}

/// Height of the ripple's middle, and half the side of the field \[m\].
const HEIGHT: f64 = 3.2;
const HALF: f64 = 10.0;
/// Radians per metre: five rings to the side.
const WAVES: f64 = 1.9;
/// Bands of colour, by height.
const BANDS: usize = 24;

/// The two-dimensional sinc function: height sin(r)/r over an n × n grid, smooth, coloured by height.
pub(super) fn build(s: &mut Shaper, n: u32) {
    let low = DVec3::new(0.02, 0.12, 0.35);
    let middle = DVec3::new(0.05, 0.42, 0.42);
    let high = DVec3::new(0.85, 0.48, 0.10);
    let first = s.next_material();
    for band in 0..BANDS {
        let t = (band as f64 + 0.5) / BANDS as f64;
        let colour = if t < 0.25 {
            low.lerp(middle, t / 0.25)
        } else {
            middle.lerp(high, (t - 0.25) / 0.75)
        };
        s.material(plastic(&format!("band-{band}"), colour.to_array(), 0.04, 0.08));
    }
    let lamp = s.material(light("lamp", [26.0, 24.0, 21.0]));

    let coordinate = |i: u32| HALF * (2.0 * f64::from(i) / f64::from(n) - 1.0);
    let patch = Patch { cells: [n, n], closed: [false, false] };
    s.patch(
        &patch,
        |i, j| {
            // By the middle of the cell.
            let middle = |i| (coordinate(i) + coordinate(i + 1)) / 2.0;
            let (z, _) = sinc(middle(i), middle(j));
            let t = (z / HEIGHT + 0.22) / 1.22;
            first + ((t * BANDS as f64) as usize).min(BANDS - 1) as u16
        },
        |i, j| {
            let (x, y) = (coordinate(i), coordinate(j));
            let (z, slope) = sinc(x, y);
            (DVec3::new(x, y, z), DVec3::new(-slope.0, -slope.1, 1.0))
        },
    );
    s.lamp(
        DVec3::new(-11.0, 2.0, 11.0),
        DVec3::new(0.0, 6.0, 0.0),
        DVec3::new(5.0, 0.0, 3.3),
        lamp,
    );
    s.distant(DVec3::Z, core::f64::consts::PI, DVec3::new(0.12, 0.15, 0.2));
    s.view(DVec3::new(11.0, -18.5, 10.5), DVec3::new(0.3, -0.9, 0.0), 36.0, 1.5);
}

/// Height and slope.
fn sinc(x: f64, y: f64) -> (f64, (f64, f64)) {
    let r = libm::sqrt(x * x + y * y);
    let a = WAVES * r;
    if a < 1e-4 {
        // The series: 1 - a²/6.
        return (
            HEIGHT * (1.0 - a * a / 6.0),
            (-HEIGHT * WAVES * WAVES * x / 3.0, -HEIGHT * WAVES * WAVES * y / 3.0),
        );
    }
    let by_r = HEIGHT * WAVES * (libm::cos(a) / a - libm::sin(a) / (a * a));
    (HEIGHT * libm::sin(a) / a, (by_r * x / r, by_r * y / r))
}
