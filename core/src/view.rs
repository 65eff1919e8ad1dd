//! From pixels to rays.

use crate::geometry::Ray;
use crate::path::PathKey;
use crate::random::{Purpose, Sequence};
use crate::scene::{View, ViewKind};
use bytemuck::{Pod, Zeroable};
use glam::Vec3;

/// A view and the size of its picture, prepared for making rays: plain data, so that one machine prepares it for all.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Camera {
    /// A [`ViewKind`].
    kind: u16,
    /// A pixel has two to this many columns and rows for its samples.
    fine: u16,
    position: [f32; 3],
    direction: [f32; 3],
    /// The width of the picture, at distance 1 where it is a perspective.
    right: [f32; 3],
    /// Its height.
    up: [f32; 3],
    /// Shift and lift, in widths and heights.
    offset: [f32; 2],
    clip: [f32; 2],
    /// One over width and height.
    step: [f32; 2],
}

impl Camera {
    /// Prepares a view for a picture of `width × height` pixels of so many samples; `None` if it shows nothing: a size of zero or of
    /// 180° and more, an up vector along the direction, a NaN.
    #[must_use]
    pub fn new(view: &View, width: u32, height: u32, samples: u32) -> Option<Self> {
        let parallel = view.kind == ViewKind::Parallel as u32;
        let direction = unit(Vec3::from(view.direction))?;
        let right = unit(direction.cross(unit(Vec3::from(view.up))?))?;
        let up = right.cross(direction);
        let [h, v] = view.size.map(|size| if parallel { size } else { 2.0 * tan_half(size) });
        let (right, up) = (right * h, up * v);
        let camera = Self {
            kind: view.kind as u16,
            fine: Sequence::fine(samples) as u16,
            position: view.position,
            direction: direction.to_array(),
            right: right.to_array(),
            up: up.to_array(),
            offset: view.offset,
            clip: view.clip,
            step: [1.0 / width as f32, 1.0 / height as f32],
        };
        let valid = width > 0
            && height > 0
            && (parallel || view.size.iter().all(|&size| size < 180.0))
            && h > 0.0
            && v > 0.0
            && view.position.iter().all(|x| x.is_finite())
            && right.is_finite()
            && up.is_finite()
            && view.offset.iter().chain(&view.clip).all(|x| x.is_finite());
        valid.then_some(camera)
    }

    /// The ray of a path's camera sample through pixel `(x, y)`, row 0 at the top; `key` is
    /// [`PathKey::camera`]. Its direction has unit length.
    ///
    /// The samples of a pixel are spread over it evenly (a box filter), by one [`Sequence`]. If they are a power of two, each has one of as many
    /// columns and rows of the pixel for itself, and lies in the middle of both: so what changes evenly from one side to the other is no error.
    #[must_use]
    #[cfg_attr(feature = "bundles", inline(always))]
    pub fn ray(&self, x: u32, y: u32, key: PathKey) -> Ray {
        let [sx, sy] = match u32::from(self.fine) {
            // Numbers that decide nothing are not drawn.
            0 => [0.5; 2],
            fine => Sequence::new(key, Purpose::Pixel).middles(key.sample, fine),
        };
        self.ray_at((x as f32 + sx) * self.step[0], (y as f32 + sy) * self.step[1])
    }

    /// The ray through a place of the picture: `(0, 0)` is its upper left corner, `(1, 1)` the lower right.
    #[must_use]
    #[cfg_attr(feature = "bundles", inline(always))]
    pub fn ray_at(&self, x: f32, y: f32) -> Ray {
        let [position, forward, right, up] =
            [self.position, self.direction, self.right, self.up].map(Vec3::from);
        let aside = right * (x - 0.5 + self.offset[0]) + up * (0.5 - y + self.offset[1]);
        // Clipping planes are at right angles to the view: in units of an oblique ray they are farther.
        let (origin, direction, scale) = if u32::from(self.kind) == ViewKind::Parallel as u32 {
            (position + aside, forward, 1.0)
        } else {
            let direction = forward + aside;
            let len = libm::sqrtf(direction.dot(direction));
            (position, direction / len, len)
        };
        let [fore, aft] = self.clip;
        Ray {
            origin,
            direction,
            t_min: if fore > 0.0 { fore * scale } else { 0.0 },
            t_max: if aft > 0.0 { aft * scale } else { f32::INFINITY },
        }
    }
}

/// The tangent of half of an angle in degrees.
fn tan_half(degrees: f32) -> f32 {
    libm::tan(f64::from(degrees) * (core::f64::consts::PI / 360.0)) as f32
}

fn unit(v: Vec3) -> Option<Vec3> {
    let len = libm::sqrtf(v.dot(v));
    (len > 0.0 && len.is_finite()).then(|| v / len)
}

#[cfg(test)]
mod tests {
    use super::*;
    use bytemuck::Zeroable;

    fn view(kind: ViewKind) -> View {
        View {
            kind: kind as u32,
            position: [0.1, -0.2, 0.3],
            direction: [0.0, 1.0, 0.0],
            up: [0.0, 0.5, 2.0],
            size: [60.0, 40.0],
            ..View::zeroed()
        }
    }

    #[test]
    fn the_edges_of_a_perspective_are_at_half_its_angles() {
        let camera = Camera::new(&view(ViewKind::Perspective), 300, 200, 1).unwrap();
        let slope = |d: Vec3| (d.x / d.y, d.z / d.y);
        let (right, top) = (30_f64.to_radians().tan() as f32, 20_f64.to_radians().tan() as f32);
        for (x, y, h, v) in
            [(0.0, 0.0, -right, top), (1.0, 0.0, right, top), (1.0, 1.0, right, -top)]
        {
            let (a, b) = slope(camera.ray_at(x, y).direction);
            assert!((a - h).abs() < 1e-6 && (b - v).abs() < 1e-6, "{a} {b} at {x} {y}");
        }
        let centre = camera.ray_at(0.5, 0.5);
        assert_eq!((centre.origin, centre.direction), (Vec3::new(0.1, -0.2, 0.3), Vec3::Y));
    }

    #[test]
    fn shift_and_lift_move_the_window_by_parts_of_the_picture() {
        for kind in [ViewKind::Perspective, ViewKind::Parallel] {
            let plain = Camera::new(&view(kind), 10, 10, 1).unwrap();
            let moved =
                Camera::new(&View { offset: [0.25, 0.5], ..view(kind) }, 10, 10, 1).unwrap();
            assert_eq!(moved.ray_at(0.5, 0.75), plain.ray_at(0.75, 0.25));
        }
    }

    #[test]
    fn a_parallel_view_has_its_size_in_lengths() {
        let camera = Camera::new(&view(ViewKind::Parallel), 10, 10, 1).unwrap();
        let (a, b) = (camera.ray_at(0.0, 0.0), camera.ray_at(1.0, 1.0));
        assert_eq!((a.direction, b.direction), (Vec3::Y, Vec3::Y));
        assert!((b.origin - a.origin - Vec3::new(60.0, 0.0, -40.0)).length() < 1e-4);
    }

    #[test]
    fn clipping_planes_are_planes() {
        let clipped = View { clip: [0.5, 2.0], ..view(ViewKind::Perspective) };
        let ray = Camera::new(&clipped, 10, 10, 1).unwrap().ray_at(0.0, 1.0);
        assert!((ray.direction.y * ray.t_min - 0.5).abs() < 1e-6);
        assert!((ray.direction.y * ray.t_max - 2.0).abs() < 1e-6);
    }

    #[test]
    fn samples_have_the_middles_of_columns_and_rows_for_themselves() {
        let (width, height) = (16, 8);
        for samples in [1, 2, 8, 32] {
            let camera = Camera::new(&view(ViewKind::Parallel), width, height, samples).unwrap();
            let corner = camera.ray_at(0.0, 0.0).origin;
            let across = camera.ray_at(1.0, 0.0).origin - corner;
            let down = camera.ray_at(0.0, 1.0).origin - corner;
            for (x, y) in [(0, 0), (3, 7), (15, 2)] {
                let [mut columns, mut rows] =
                    [vec![0; samples as usize], vec![0; samples as usize]];
                for sample in 0..samples {
                    let key = PathKey::camera(5, y * width + x, sample);
                    let origin = camera.ray(x, y, key).origin - corner;
                    let count = |axis: Vec3, pixels: u32, pixel: u32, cells: &mut [i32]| {
                        let at = origin.dot(axis) / axis.dot(axis) * pixels as f32;
                        let cell = (at - pixel as f32) * samples as f32 - 0.5;
                        assert!((cell - cell.round()).abs() < 0.01, "{at}");
                        cells[cell.round() as usize] += 1;
                    };
                    count(across, width, x, &mut columns);
                    count(down, height, y, &mut rows);
                }
                assert!(columns.iter().chain(&rows).all(|&count| count == 1));
            }
        }
    }

    #[test]
    fn a_view_that_shows_nothing_is_refused() {
        let good = view(ViewKind::Perspective);
        assert!(Camera::new(&good, 0, 10, 1).is_none());
        for bad in [
            View { up: [0.0, -3.0, 0.0], ..good },
            View { direction: [0.0; 3], ..good },
            View { size: [180.0, 40.0], ..good },
            View { size: [60.0, 0.0], ..good },
            View { size: [f32::NAN, 40.0], ..good },
            View { position: [f32::INFINITY, 0.0, 0.0], ..good },
            View { offset: [0.0, f32::NAN], ..good },
        ] {
            assert!(Camera::new(&bad, 10, 10, 1).is_none(), "{bad:?}");
        }
    }
}
