//! What rays visit: the traversal itself, over a source that counts.

use std::collections::BTreeSet;

use glam::{DVec3, Vec3};
use kiloray_core::block::{BlockSource, BlockView, KiloView, NoBlock};
use kiloray_core::geometry::{Hit, Primitive, Ray};
use kiloray_core::trace::{Cursor, Scalar, Tracer, Visited};

use crate::mesh::Camera;

const SIZE: u32 = 384;

/// A file, and which of its blocks a ray has seen.
struct Seen<'a> {
    file: KiloView<'a>,
    blocks: BTreeSet<u32>,
}

impl BlockSource for Seen<'_> {
    type Error = NoBlock;

    fn block(&mut self, block: u32) -> Result<BlockView<'_>, NoBlock> {
        self.blocks.insert(block);
        self.file.block(block)
    }
}

/// Visits of many rays.
#[derive(Default)]
struct Visits {
    rays: u64,
    hits: u64,
    /// Blocks that a ray saw at least once.
    blocks: u64,
    cursor: Cursor,
}

impl Visits {
    fn trace(&mut self, source: &mut Seen<'_>, ray: &Ray, any: bool) -> Option<Hit> {
        source.blocks.clear();
        let hit = if any {
            let hit = Scalar.any(&mut self.cursor, source, ray).expect("checked");
            self.hits += u64::from(hit);
            None
        } else {
            let hit = Scalar.closest(&mut self.cursor, source, ray).expect("checked");
            self.hits += u64::from(hit.is_some());
            hit
        };
        self.rays += 1;
        self.blocks += source.blocks.len() as u64;
        hit
    }
}

/// Traces primary, diffuse and shadow rays, and prints a line for each.
pub(crate) fn count(view: &KiloView<'_>, camera: &Camera) {
    let frame = view.header().frame;
    let scale = 2f64.powi(-frame.exponent);
    let place = |p: DVec3| ((p - DVec3::from_array(frame.center)) * scale).as_vec3();
    let (eye, light) = (place(camera.eye), place(camera.light));
    let forward = (place(camera.target) - eye).normalize();
    let right = forward.cross(camera.up.as_vec3()).normalize();
    let up = right.cross(forward);
    let half = (camera.angle.to_radians() * 0.5).tan() as f32;
    let mut source = Seen { file: *view, blocks: BTreeSet::new() };
    let [mut primary, mut bounce, mut shadow] = [(); 3].map(|()| Visits::default());
    for i in 0..SIZE * SIZE {
        let pixel = |v: u32| (2.0 * (v as f32 + 0.5) / SIZE as f32 - 1.0) * half;
        let direction = (forward + right * pixel(i % SIZE) - up * pixel(i / SIZE)).normalize();
        let ray = |origin, direction, t_max| Ray { origin, direction, t_min: 0.0, t_max };
        let first = ray(eye, direction, f32::INFINITY);
        let Some(hit) = primary.trace(&mut source, &first, false) else { continue };
        let Primitive::Triangle { vertices: [a, b, c], .. } = hit.primitive else { continue };
        let normal = (b - a).cross(c - a).normalize_or_zero();
        let normal = if normal.dot(direction) > 0.0 { -normal } else { normal };
        let origin = eye + direction * hit.t + normal * (1e-3 * scale as f32);
        let (u1, u2) = (hash(2 * i), hash(2 * i + 1));
        let z = 1.0 - 2.0 * u1;
        let (r, a) = ((1.0 - z * z).max(0.0).sqrt(), std::f64::consts::TAU * u2);
        let s = DVec3::new(r * a.cos(), r * a.sin(), z).as_vec3();
        let to: Vec3 = (normal + s).normalize();
        bounce.trace(&mut source, &ray(origin, to, f32::INFINITY), false);
        shadow.trace(&mut source, &ray(origin, light - origin, 0.999), true);
    }
    for (name, visits) in [("primary", primary), ("diffuse", bounce), ("shadow", shadow)] {
        let per = |n: u64| n as f64 / visits.rays.max(1) as f64;
        let Visited { nodes, leaves, blocks } = visits.cursor.visited();
        println!(
            "{name:8} {:.2} nodes {:.2} leaves {:.2} entries {:.2} blocks per ray, {:.3} hit",
            per(nodes),
            per(leaves),
            per(blocks),
            per(visits.blocks),
            per(visits.hits)
        );
    }
}

fn hash(x: u32) -> f64 {
    let x = x.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
    let x = ((x >> ((x >> 28) + 4)) ^ x).wrapping_mul(277_803_737);
    f64::from((x >> 22) ^ x) / 4_294_967_296.0
}
