use core::f64::consts::TAU;

use glam::{DAffine3, DVec2, DVec3};

use super::shape::{Patch, Shaper};

/// Surfaces of revolution and tubes.
impl Shaper {
    /// Turns the profile, points (radius, height) from bottom to top, about the z axis. Where
    /// it bends by more than a right angle's half there is an edge, elsewhere it is smooth.
    pub(super) fn lathe(&mut self, profile: &[[f64; 2]], segments: u32, material: u16) {
        let points: Vec<_> = profile.iter().map(|&p| DVec2::from(p)).collect();
        let along: Vec<_> = points.windows(2).map(|w| (w[1] - w[0]).normalize_or_zero()).collect();
        let mut start = 0;
        for end in 1..points.len() {
            let bends = along.get(end).is_none_or(|next| next.dot(along[end - 1]) < 0.7);
            if bends {
                self.turn(&points[start..=end], &along[start..end], segments, material);
                start = end;
            }
        }
    }

    fn turn(&mut self, points: &[DVec2], along: &[DVec2], segments: u32, material: u16) {
        let rows = points.len() as u32 - 1;
        let patch = Patch { cells: [segments, rows], closed: [true, false] };
        self.patch(
            &patch,
            |_, _| material,
            |i, j| {
                let j = j as usize;
                let angle = DVec2::from_angle(TAU * f64::from(i) / f64::from(segments));
                let before = along[j.saturating_sub(1)];
                let after = along[j.min(along.len() - 1)];
                let tangent = before + after;
                let point = points[j];
                let place = DVec3::new(angle.x * point.x, angle.y * point.x, point.y);
                (place, DVec3::new(angle.x * tangent.y, angle.y * tangent.y, -tangent.x))
            },
        );
    }

    /// A closed cylinder about the z axis.
    pub(super) fn post(&mut self, radius: f64, z: [f64; 2], segments: u32, material: u16) {
        let profile = [[0.0, z[0]], [radius, z[0]], [radius, z[1]], [0.0, z[1]]];
        self.lathe(&profile, segments, material);
    }

    /// A plate with round corners, `half` as wide and long, lying between two heights.
    pub(super) fn plate(&mut self, half: [f64; 2], corner: f64, z: [f64; 2], material: u16) {
        const STEPS: u32 = 5;
        let outline = |k: u32| {
            let (quarter, step) = (k / (STEPS + 1) % 4, k % (STEPS + 1));
            let turn = f64::from(quarter) + f64::from(step) / f64::from(STEPS);
            let normal = DVec2::from_angle(TAU / 4.0 * turn);
            let sign = |negative: bool| if negative { -1.0 } else { 1.0 };
            let centre = DVec2::new(
                sign(quarter == 1 || quarter == 2) * (half[0] - corner),
                sign(quarter >= 2) * (half[1] - corner),
            );
            (centre + normal * corner, normal)
        };
        let count = 4 * (STEPS + 1);
        let side = Patch { cells: [count, 1], closed: [true, false] };
        self.patch(
            &side,
            |_, _| material,
            |i, j| {
                let (place, normal) = outline(i);
                (place.extend(z[j as usize]), normal.extend(0.0))
            },
        );
        for (height, up) in [(z[0], false), (z[1], true)] {
            let vertices: Vec<_> = (0..count).map(|k| outline(k).0.extend(height)).collect();
            let fan: Vec<_> =
                (1..count - 1).map(|k| if up { [0, k, k + 1] } else { [0, k + 1, k] }).collect();
            self.facets(&vertices, &fan, material);
        }
    }

    /// A closed cylinder from `a` to `b`.
    pub(super) fn rod(&mut self, a: DVec3, b: DVec3, radius: f64, segments: u32, material: u16) {
        let axis = (b - a).normalize_or(DVec3::Z);
        let x = axis.any_orthonormal_vector();
        let turn = DAffine3::from_cols(x, axis.cross(x), axis, a);
        self.at(turn, |s| s.post(radius, [0.0, a.distance(b)], segments, material));
    }

    /// A ball of triangles.
    pub(super) fn ball(&mut self, radius: f64, segments: u32, material: u16) {
        let patch = Patch { cells: [2 * segments, segments], closed: [true, false] };
        self.patch(
            &patch,
            |_, _| material,
            |i, j| {
                let east = DVec2::from_angle(TAU * f64::from(i) / f64::from(2 * segments));
                let up = if j == 0 {
                    -DVec2::Y
                } else if j == segments {
                    DVec2::Y
                } else {
                    DVec2::from_angle(TAU / 2.0 * (f64::from(j) / f64::from(segments) - 0.5))
                };
                let normal = DVec3::new(east.x * up.x, east.y * up.x, up.y);
                (normal * radius, normal)
            },
        );
    }

    /// A tube of this radius round the closed curve `curve`, a function of [0, 1).
    pub(super) fn ring(
        &mut self,
        radius: f64,
        cells: [u32; 2],
        material: u16,
        curve: impl Fn(f64) -> DVec3,
    ) {
        let [around, along] = cells;
        let patch = Patch { cells, closed: [true, true] };
        self.patch(
            &patch,
            |_, _| material,
            |i, j| {
                let t = f64::from(j) / f64::from(along);
                let step = 1e-4;
                let (before, here, after) = (curve(t - step), curve(t), curve(t + step));
                let tangent = (after - before).normalize_or(DVec3::X);
                // The frame follows the curve's own bend, so that it closes.
                let bend = before + after - 2.0 * here;
                let side = (bend - tangent * bend.dot(tangent)).normalize_or(DVec3::Z);
                let angle = DVec2::from_angle(TAU * f64::from(i) / f64::from(around));
                let normal = side * angle.x + tangent.cross(side) * angle.y;
                (here + normal * radius, normal)
            },
        );
    }

    /// A torus about the z axis.
    pub(super) fn torus(&mut self, large: f64, small: f64, cells: [u32; 2], material: u16) {
        self.ring(small, cells, material, |t| {
            let angle = DVec2::from_angle(TAU * t);
            DVec3::new(angle.x * large, angle.y * large, 0.0)
        });
    }

    /// A torus knot that goes `p` times round the axis and `q` times through the hole.
    pub(super) fn knot(&mut self, [p, q]: [f64; 2], scale: f64, cells: [u32; 2], material: u16) {
        self.ring(0.22 * scale, cells, material, |t| {
            let (round, through) = (DVec2::from_angle(p * TAU * t), DVec2::from_angle(q * TAU * t));
            let radius = 0.58 + 0.26 * through.x;
            DVec3::new(radius * round.x, radius * round.y, 0.36 * through.y) * scale
        });
    }
}
