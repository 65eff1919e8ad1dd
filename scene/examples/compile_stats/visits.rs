//! What rays visit: a plain walk in f32 that counts. It judges trees, not hits: no padding, no ties.

use glam::{DVec3, Vec3};
use kiloray_core::block::format::{Child, RECORD_SPHERES};
use kiloray_core::block::{BlockView, KiloView};

use crate::mesh::Camera;

const SIZE: u32 = 384;

/// Visits of many rays.
#[derive(Default, Clone, Copy)]
struct Visits {
    rays: u64,
    hits: u64,
    nodes: u64,
    records: u64,
    /// Changes of the block, and blocks seen at least once.
    entries: u64,
    blocks: u64,
}

struct Ray {
    origin: Vec3,
    direction: Vec3,
    t_max: f32,
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
    let (mut primary, mut bounce, mut shadow) =
        (Visits::default(), Visits::default(), Visits::default());
    for i in 0..SIZE * SIZE {
        let pixel = |v: u32| (2.0 * (v as f32 + 0.5) / SIZE as f32 - 1.0) * half;
        let direction = (forward + right * pixel(i % SIZE) - up * pixel(i / SIZE)).normalize();
        let ray = Ray { origin: eye, direction, t_max: f32::INFINITY };
        let Some((t, normal)) = trace(view, &ray, false, &mut primary) else { continue };
        let normal = if normal.dot(direction) > 0.0 { -normal } else { normal };
        let origin = eye + direction * t + normal * (1e-3 * scale as f32);
        let (u1, u2) = (hash(2 * i), hash(2 * i + 1));
        let z = 1.0 - 2.0 * u1;
        let (r, a) = ((1.0 - z * z).max(0.0).sqrt(), std::f64::consts::TAU * u2);
        let s = DVec3::new(r * a.cos(), r * a.sin(), z).as_vec3();
        let ray = Ray { origin, direction: (normal + s).normalize(), t_max: f32::INFINITY };
        trace(view, &ray, false, &mut bounce);
        trace(view, &Ray { origin, direction: light - origin, t_max: 0.999 }, true, &mut shadow);
    }
    for (name, v) in [("primary", primary), ("diffuse", bounce), ("shadow", shadow)] {
        let per = |n: u64| n as f64 / v.rays.max(1) as f64;
        println!(
            "{name:8} {:.2} nodes {:.2} records {:.2} entries {:.2} blocks per ray, {:.3} hit",
            per(v.nodes),
            per(v.records),
            per(v.entries),
            per(v.blocks),
            per(v.hits)
        );
    }
}

fn hash(x: u32) -> f64 {
    let x = x.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
    let x = ((x >> ((x >> 28) + 4)) ^ x).wrapping_mul(277_803_737);
    f64::from((x >> 22) ^ x) / 4_294_967_296.0
}

fn trace(view: &KiloView<'_>, ray: &Ray, any: bool, visits: &mut Visits) -> Option<(f32, Vec3)> {
    let inv = ray.direction.map(|d| 1.0 / if d.abs() < 1e-18 { 1e-18f32.copysign(d) } else { d });
    let mut best = None;
    let mut t_max = ray.t_max;
    let mut stack = vec![(0, 0, 0.0)];
    let mut seen = Vec::new();
    let mut last = u32::MAX;
    visits.rays += 1;
    while let Some((block, node, entry)) = stack.pop() {
        if entry > t_max {
            continue;
        }
        let content = view.trusted_block(block).expect("checked");
        if block != last {
            visits.entries += 1;
            last = block;
            if !seen.contains(&block) {
                seen.push(block);
            }
        }
        visits.nodes += 1;
        let stored = content.node(node).expect("checked");
        let (origin, scale) =
            (Vec3::from(content.header().origin), Vec3::from(content.header().scale));
        let axes = stored.axes().map(usize::from);
        let flip = (0..3).fold(0, |flip, level| {
            flip | usize::from(ray.direction[axes[level]] < 0.0) << (2 - level)
        });
        let mut inner = Vec::new();
        for k in 0..8 {
            let slot = k ^ flip;
            let corner = |q: &[[u16; 8]; 3]| {
                let q = Vec3::new(q[0][slot].into(), q[1][slot].into(), q[2][slot].into());
                (origin + scale * q - ray.origin) * inv
            };
            let (a, b) = (corner(&stored.lo), corner(&stored.hi));
            let enter = a.min(b).max_element().max(0.0);
            let leave = a.max(b).min_element().min(t_max);
            let child = Child::decode(stored.child[slot]);
            if child == Child::Empty || enter > leave {
                continue;
            }
            match child {
                Child::Leaf { first, count } => {
                    for record in first..first + count {
                        visits.records += 1;
                        if let Some((t, normal)) = nearest(&content, record, ray, t_max) {
                            t_max = t;
                            best = Some((t, normal));
                            if any {
                                stack.clear();
                                inner.clear();
                            }
                        }
                    }
                    if any && best.is_some() {
                        break;
                    }
                }
                Child::Node(kid) => inner.push((block, kid, enter)),
                Child::Ref(r) => {
                    let r = content.reference(r).expect("checked");
                    inner.push((r.block, r.node, enter));
                }
                Child::Empty => {}
            }
        }
        stack.extend(inner.into_iter().rev());
    }
    visits.blocks += seen.len() as u64;
    visits.hits += u64::from(best.is_some());
    best
}

/// The nearest triangle of a record (Möller & Trumbore 1997).
fn nearest(content: &BlockView<'_>, record: u16, ray: &Ray, mut t_max: f32) -> Option<(f32, Vec3)> {
    let record = content.record(record)?;
    if record.base & RECORD_SPHERES != 0 {
        return None;
    }
    let mut best = None;
    for index in record.index {
        let [a, b, c] = index.map(|i| content.vertex(usize::from(record.base) + usize::from(i)));
        let (a, b, c) = (a?, b?, c?);
        let (e1, e2) = (b - a, c - a);
        let p = ray.direction.cross(e2);
        let det = e1.dot(p);
        let s = ray.origin - a;
        let u = s.dot(p) / det;
        let q = s.cross(e1);
        let v = ray.direction.dot(q) / det;
        let t = e2.dot(q) / det;
        if u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t >= 0.0 && t <= t_max {
            t_max = t;
            best = Some((t, e1.cross(e2).normalize_or_zero()));
        }
    }
    best
}
