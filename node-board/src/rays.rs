//! Camera rays and rays from what they hit, as one hash of all hits: the same on every machine.

use kiloray_core::block::{KiloView, checksum};
use kiloray_core::geometry::{Hit, Primitive, Ray};
use kiloray_core::path::PathKey;
use kiloray_core::random::{Purpose, Sequence};
use kiloray_core::trace::{Cursor, Scalar, Tracer};
use kiloray_core::view::Camera;

/// Rays along an edge of the picture.
const SIZE: u32 = 24;

/// Why there is no hash.
#[derive(Debug, Clone, Copy)]
pub(crate) enum RaysError {
    /// The file is refused, or has no view.
    File,
    /// The tree is corrupt.
    Trace,
}

/// What came of the rays.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Hits {
    /// Rays traced.
    pub(crate) rays: u32,
    /// Rays that hit.
    pub(crate) hits: u32,
    /// Hash of all hits, in order.
    pub(crate) hash: u32,
}

/// Traces a picture of camera rays, and from each hit one ray into the scene.
pub(crate) fn trace(file: &KiloView<'_>, cursor: &mut Cursor) -> Result<Hits, RaysError> {
    let view = file.views().first().ok_or(RaysError::File)?;
    let camera = Camera::new(view, SIZE, SIZE, 1).ok_or(RaysError::File)?;
    let mut all = Hits::default();
    for y in 0..SIZE {
        for x in 0..SIZE {
            let key = PathKey::camera(1, y * SIZE + x, 0);
            let ray = camera.ray(x, y, key);
            let Some(hit) = one(&ray, file, cursor, &mut all)? else { continue };
            let surface = hit.surface(&ray);
            let [a, b] = Sequence::new(key, Purpose::Reflect).point(0);
            let aside = surface.normal.any_orthonormal_vector();
            let other = surface.normal.cross(aside);
            let towards = surface.normal + aside * (a * 2.0 - 1.0) + other * (b * 2.0 - 1.0);
            let facing = if surface.normal.dot(ray.direction) > 0.0 { -towards } else { towards };
            one(&surface.spawn(facing), file, cursor, &mut all)?;
        }
    }
    Ok(all)
}

fn one(
    ray: &Ray,
    file: &KiloView<'_>,
    cursor: &mut Cursor,
    all: &mut Hits,
) -> Result<Option<Hit>, RaysError> {
    let hit = Scalar.closest(cursor, &mut { *file }, ray).map_err(|_| RaysError::Trace)?;
    all.rays += 1;
    if let Some(hit) = hit {
        all.hits += 1;
        let mut words = [all.hash, hit.t.to_bits(), hit.b1.to_bits(), hit.b2.to_bits(), 0, 0];
        words[4] = u32::from(hit.material);
        words[5] = match hit.primitive {
            Primitive::Triangle { vertices, .. } => {
                vertices.iter().fold(0, |h, v| v.to_array().iter().fold(h, |h, x| turn(h, *x)))
            }
            Primitive::Sphere { center, radius, .. } => {
                turn(center.to_array().iter().fold(1, |h, x| turn(h, *x)), radius)
            }
        };
        all.hash = checksum(words.map(u32::to_le_bytes).as_flattened());
    }
    Ok(hit)
}

fn turn(hash: u32, x: f32) -> u32 {
    hash.rotate_left(5).wrapping_mul(0x9e37_79b1) ^ x.to_bits()
}
