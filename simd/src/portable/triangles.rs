//! Rays against triangles: one against the four of a record, or the eight of a group against one.

use kiloray_core::block::Vertices;
use kiloray_core::block::format::Record;
use kiloray_core::geometry::rounding::{max, min};
use kiloray_core::geometry::{DET_MAX, DET_MIN, DET_PART, PreparedRay};
use kiloray_core::trace::{Crossings, Group, Kind, Quad, Verdict};

use super::boxes::{greater, lesser, mask};

/// `Lanes::quad`.
pub(super) fn decode(vertices: Vertices<'_>, record: &Record, to: &mut Quad) -> bool {
    let words = vertices.words();
    to.used = 0;
    for (place, index) in record.index.iter().enumerate() {
        for (corner, &i) in index.iter().enumerate() {
            let vertex = usize::from(record.base) + usize::from(i);
            let of = words.get(3 * vertex..).and_then(|words| words.first_chunk::<3>());
            let Some(of) = of.filter(|_| vertex < vertices.count()) else { return false };
            for (axis, &x) in of.iter().enumerate() {
                match corner {
                    0 => to.v01[axis][place] = x,
                    1 => to.v01[axis][4 + place] = x,
                    _ => to.v2[axis][place] = x,
                }
            }
        }
        let [a, b, c] = index;
        to.used |= u32::from(a != b || b != c) << place;
    }
    true
}

/// A ray and a triangle in each lane, along the axes `kx, ky, kz`.
struct Pairs<const N: usize> {
    /// From the ray's origin to the triangle's corners.
    from: [[[f32; N]; 3]; 3],
    shear: [[f32; N]; 3],
    inv: [[f32; N]; 3],
    t_min: [f32; N],
    t_max: [f32; N],
}

/// The axes `kx, ky, kz` of a ray.
#[inline(always)]
fn axes(axis: u8) -> [usize; 3] {
    match axis {
        0 => [1, 2, 0],
        1 => [2, 0, 1],
        _ => [0, 1, 2],
    }
}

/// `Lanes::record`, and `Lanes::quad_of`.
pub(super) fn of_ray(quad: &Quad, ray: &PreparedRay, to: &mut Crossings) -> Verdict {
    let axes = axes(ray.axis);
    let (origin, inv) = (ray.origin.to_array(), ray.inv.to_array());
    let from = |corner: usize| {
        axes.map(|axis| {
            let row = match corner {
                0 => quad.v01[axis].first_chunk::<4>(),
                1 => quad.v01[axis].last_chunk::<4>(),
                _ => Some(&quad.v2[axis]),
            };
            row.map_or([0.0; 4], |row| row.map(|x| x - origin[axis]))
        })
    };
    let pairs = Pairs {
        from: [from(0), from(1), from(2)],
        shear: ray.shear.map(|x| [x; 4]),
        inv: axes.map(|axis| [inv[axis]; 4]),
        t_min: [ray.t_min; 4],
        t_max: [ray.t_max; 4],
    };
    pairs.test(quad.used, to)
}

/// `Lanes::triangle`.
pub(super) fn of_group(
    quad: &Quad,
    place: usize,
    group: &Group,
    kind: Kind,
    to: &mut Crossings,
) -> Verdict {
    let axes = axes(kind.axis());
    let from = |corner: usize| {
        axes.map(|axis| {
            let at = match corner {
                0 => quad.v01[axis][place],
                1 => quad.v01[axis][4 + place],
                _ => quad.v2[axis][place],
            };
            group.origin[axis].map(|o| at - o)
        })
    };
    let pairs = Pairs {
        from: [from(0), from(1), from(2)],
        shear: group.shear,
        inv: axes.map(|axis| group.inv[axis]),
        t_min: group.t_min,
        t_max: group.t_max,
    };
    pairs.test(0xff, to)
}

impl<const N: usize> Pairs<N> {
    /// The operations of [`PreparedRay::triangle`], one by one, for the lanes of a mask.
    #[inline(always)]
    fn test(&self, lanes: u32, to: &mut Crossings) -> Verdict {
        let Self { from: [v0, v1, v2], shear: [sx, sy, sz], .. } = self;
        let (mut x, mut y) = ([[0.0; N]; 3], [[0.0; N]; 3]);
        let (mut u, mut v, mut w) = ([0.0; N], [0.0; N], [0.0; N]);
        let mut opposite = [0; N];
        for i in 0..N {
            // Step 1; `z` is not yet multiplied.
            let sheared = |[x, y, z]: &[[f32; N]; 3]| (x[i] - sx[i] * z[i], y[i] - sy[i] * z[i]);
            let ((x0, y0), (x1, y1), (x2, y2)) = (sheared(v0), sheared(v1), sheared(v2));
            (x[0][i], x[1][i], x[2][i]) = (x0, x1, x2);
            (y[0][i], y[1][i], y[2][i]) = (y0, y1, y2);
            // Step 2.
            u[i] = x2 * y1 - y2 * x1;
            v[i] = x0 * y2 - y0 * x2;
            w[i] = x1 * y0 - y1 * x0;
            let least = lesser(lesser(u[i], v[i]), w[i]);
            let greatest = greater(greater(u[i], v[i]), w[i]);
            opposite[i] = u32::from((least < 0.0) & (greatest > 0.0));
        }
        let crossing = lanes & mask(N, |i| opposite[i] == 0);
        if crossing == 0 {
            return Verdict { accepted: 0, doubtful: 0 };
        }
        let (mut sound, mut within) = ([0; N], [0; N]);
        for i in 0..N {
            let (u, v, w) = (u[i], v[i], w[i]);
            let det = (u + v) + w;
            let size = det.abs();
            let widest = |[a, b, c]: &[[f32; N]; 3]| max(max(a[i].abs(), b[i].abs()), c[i].abs());
            let part = widest(&x) * widest(&y) * DET_PART;
            // Not true of a NaN.
            let is_none_zero = (u.abs() > 0.0) & (v.abs() > 0.0) & (w.abs() > 0.0);
            let in_range = (size >= part) & (DET_MIN..=DET_MAX).contains(&size);
            sound[i] = u32::from(is_none_zero & in_range);
            // Step 3.
            let r = 1.0 / det;
            let (b0, b1, b2) = (u * r, v * r, w * r);
            let z = |of: &[[f32; N]; 3]| sz[i] * of[2][i];
            let t = (b0 * z(v0) + b1 * z(v1)) + b2 * z(v2);
            // Step 5. Rounding is monotone: the least of the differences is the difference of the least.
            let (mut low, mut high) = ([0.0; 3], [0.0; 3]);
            for axis in 0..3 {
                low[axis] = min(min(v0[axis][i], v1[axis][i]), v2[axis][i]);
                high[axis] = max(max(v0[axis][i], v1[axis][i]), v2[axis][i]);
            }
            let far = |axis: usize| max(low[axis].abs(), high[axis].abs());
            let pad = max(max(far(0), far(1)), far(2)) * PreparedRay::PAD;
            let slab = |axis: usize| {
                let inv = self.inv[axis][i];
                let (t0, t1) = ((low[axis] - pad) * inv, (high[axis] + pad) * inv);
                if inv < 0.0 { (t1, t0) } else { (t0, t1) }
            };
            let ((x0, x1), (y0, y1), (z0, z1)) = (slab(0), slab(1), slab(2));
            let (enter, leave) = (max(max(x0, y0), z0), min(min(x1, y1), z1));
            // Step 4 of a hit.
            let t = min(leave, max(enter, t)) + 0.0;
            within[i] = u32::from((enter <= leave) & (self.t_min[i] <= t) & (t <= self.t_max[i]));
            (to.t[i], to.b1[i], to.b2[i]) = (t, b1, b2);
        }
        let sound = mask(N, |i| sound[i] != 0);
        let within = mask(N, |i| within[i] != 0);
        Verdict { accepted: crossing & sound & within, doubtful: crossing & !sound }
    }
}

/// The ray in a lane of a group.
#[inline(always)]
pub(super) fn in_lane(group: &Group, lane: usize, kind: Kind) -> PreparedRay {
    let of = |rows: &[[f32; 8]; 3]| rows.each_ref().map(|row| row[lane]);
    PreparedRay {
        origin: of(&group.origin).into(),
        shear: of(&group.shear),
        inv: of(&group.inv).into(),
        t_min: group.t_min[lane],
        t_max: group.t_max[lane],
        axis: kind.axis(),
        ..PreparedRay::NONE
    }
}
