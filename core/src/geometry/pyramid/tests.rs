use super::*;
use crate::geometry::{Hit, PreparedRay, Primitive, Target};
use crate::path::PathKey;
use crate::scene::LightKind;
use bytemuck::Zeroable;
use glam::DVec3;
use std::vec::Vec;

struct Numbers(u64);

impl Numbers {
    /// In [0, 1).
    fn unit(&mut self) -> f32 {
        self.0 = self.0.wrapping_add(1);
        (PathKey::camera(self.0, 7, 0).scramble(3) >> 8) as f32 / (1 << 24) as f32
    }
    fn signed(&mut self) -> f32 {
        2.0 * self.unit() - 1.0
    }
    fn point(&mut self) -> Vec3 {
        Vec3::new(self.signed(), self.signed(), self.signed())
    }
    fn direction(&mut self) -> Vec3 {
        self.point().normalize_or(Vec3::X)
    }
    fn pick(&mut self, n: usize) -> usize {
        (self.unit() * n as f32) as usize
    }
    fn decade(&mut self, lo: f32, hi: f32) -> f32 {
        10_f32.powf(lo + (hi - lo) * self.unit())
    }
}

/// The size of everything in a case, and how far it lies from the origin: the scales of the promise.
fn scale_and_offset(n: &mut Numbers) -> (f32, Vec3) {
    let size = n.decade(-6.0, 6.0);
    (size, n.point() * size * [0.0, 1.0, 1e4][n.pick(3)])
}

/// Weights of four corners, often on an edge or at a corner.
fn weights(n: &mut Numbers) -> [f32; 4] {
    let [mut x, mut y] = [n.unit(), n.unit()];
    match n.pick(4) {
        0 => x = 0.0,
        1 => y = 1.0,
        2 if n.pick(2) == 0 => (x, y) = (1.0, 0.0),
        _ => {}
    }
    [(1.0 - x) * (1.0 - y), x * (1.0 - y), x * y, (1.0 - x) * y]
}

/// A triangle that the ray hits at or near `t`, but which lies to one side of it: its box does no more than touch the bundle,
/// if that side is the outer one.
fn beside(n: &mut Numbers, ray: &Ray, t: f32, size: f32) -> [Vec3; 3] {
    let at = ray.origin + ray.direction * t;
    let out = n.direction();
    let mut side = || (out + n.direction() * 0.5) * size * n.decade(-3.0, 1.0);
    let (a, b) = (side(), side());
    // The corner is moved to the other side of the ray by about what f32 can tell.
    let over = out * (at.abs().max_element() + t) * 1e-7 * n.signed();
    [at - over, at + a, at + b]
}

fn hit(ray: &Ray, vertices: [Vec3; 3]) -> Option<Hit> {
    let hit = PreparedRay::new(ray).triangle(vertices)?;
    let primitive = Primitive::Triangle { vertices, normals: None };
    Some(Hit { t: hit.t, b1: hit.b1, b2: hit.b2, material: 0, primitive, block: 0 })
}

/// No box that holds a triangle which a ray of the bundle hits may be outside; nor may its parts be lost when the
/// planes of a box around it are handed down.
fn check(n: &mut Numbers, pyramid: &Pyramid, vertices: [Vec3; 3], context: &str) {
    let own = Aabb::of_triangle(vertices);
    assert_ne!(pyramid.classify(&own), Side::Outside, "{context}\n{own:?}\n{pyramid:?}");
    let mut planes = Planes::ALL;
    for i in (0..6).rev() {
        let grow = (own.max - own.min) * 2_f32.powi(i) * n.unit();
        let around = Aabb { min: own.min - grow, max: own.max + grow };
        planes = pyramid.clip(&around.union(own), planes).expect(context);
    }
    assert!(pyramid.clip(&own, planes).is_some(), "{context}\n{own:?}\n{pyramid:?}");
    let primitive = Primitive::Triangle { vertices, normals: None };
    assert!(pyramid.touches(&primitive, planes), "{context}\n{vertices:?}\n{pyramid:?}");
}

fn tile(n: &mut Numbers, size: f32, offset: Vec3) -> [Ray; 4] {
    let axis = n.direction();
    let (u, v) = axis.any_orthonormal_pair();
    let width = n.decade(-5.0, 1.0);
    let height = width * n.decade(-2.0, 0.5);
    let (shift, t_max) = (n.point() * 3.0, [f32::INFINITY, 4.0 * size][n.pick(2)]);
    let parallel = n.pick(3) == 0;
    [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(x, y)| {
        let aside = (u * (x + shift.x) * width) + (v * (y + shift.y) * height);
        let (origin, direction) =
            if parallel { (offset + aside * size, axis) } else { (offset, axis + aside) };
        Ray { origin, direction, t_min: 0.0, t_max }
    })
}

#[test]
fn no_hit_of_a_tile_is_lost() {
    let mut hits = 0;
    for seed in 0..60_000_u64 {
        let n = &mut Numbers(seed << 16);
        let (size, offset) = scale_and_offset(n);
        let corners = tile(n, size, offset);
        let pyramid = Pyramid::of_tile(&corners);
        for _ in 0..6 {
            let w = weights(n);
            let mean = |f: fn(&Ray) -> Vec3| {
                corners.iter().zip(w).map(|(ray, w)| f(ray) * w).sum::<Vec3>()
            };
            let direction = mean(|ray| ray.direction);
            let same = corners[0].origin == corners[1].origin;
            let origin = if same { corners[0].origin } else { mean(|ray| ray.origin) };
            // A camera gives unit directions.
            let length = direction.length();
            let direction = direction / length;
            let t_max = corners[0].t_max * length;
            let ray = Ray { origin, direction, t_min: 0.0, t_max };
            let t = n.unit() * if t_max.is_finite() { t_max } else { size * n.decade(-2.0, 4.0) };
            let triangle_size = t * n.decade(-5.0, 0.5);
            let vertices = beside(n, &ray, t, triangle_size);
            if hit(&ray, vertices).is_some() {
                hits += 1;
                check(n, &pyramid, vertices, &std::format!("seed {seed} {corners:?} {ray:?}"));
            }
        }
    }
    assert!(hits > 40_000, "{hits}");
}

fn light(n: &mut Numbers, kind: LightKind, size: f32, offset: Vec3) -> Light {
    let (a, b) = (n.direction(), n.direction());
    let radius = size * n.decade(-3.0, 1.0);
    let position = offset + n.direction() * size * n.decade(-1.0, 1.0);
    let (mut u, mut v) = (a * radius, b * radius * n.decade(-2.0, 0.0));
    match kind {
        LightKind::Disc => v = a.cross(b).normalize_or(Vec3::X).cross(a).normalize() * radius,
        LightKind::Sphere => (u, v) = (Vec3::X * radius, Vec3::ZERO),
        LightKind::Spot => (u, v) = (a, Vec3::X * 0.5),
        LightKind::Distant => {
            (u, v) = (a, Vec3::X * [1.0, 0.99999, 0.9, 0.5, 0.1, -1.0][n.pick(6)])
        }
        _ => {}
    }
    if kind == LightKind::Disc {
        u = a.cross(b).normalize_or(Vec3::X) * radius;
        let w = a * radius;
        v = u.cross(w).normalize_or(Vec3::Y) * radius;
    }
    Light {
        kind: kind as u32,
        position: position.into(),
        u: u.into(),
        v: v.into(),
        ..Light::zeroed()
    }
}

/// A point of the light, often on its border, with its normal; or a direction.
fn sample(n: &mut Numbers, light: &Light, from: Vec3) -> (Vec3, Vec3) {
    let [p, u, v] = [light.position, light.u, light.v].map(Vec3::from);
    let normal = u.cross(v).normalize_or_zero();
    let border = n.pick(2) == 0;
    match LightKind::from_u32(light.kind).unwrap() {
        LightKind::Parallelogram => {
            let [_, b, c, d] = weights(n);
            (p + u * (b + c) + v * (c + d), normal)
        }
        LightKind::Triangle => {
            let [a, b, c, d] = weights(n);
            let _ = a;
            (p + u * b + v * if border { 1.0 - b } else { (c + d) * (1.0 - b) }, normal)
        }
        LightKind::Disc => {
            let (s, c) = (n.unit() * core::f32::consts::TAU).sin_cos();
            let r = if border { 1.0 } else { n.unit() };
            (p + u * (c * r) + v * (s * r), normal)
        }
        LightKind::Sphere => {
            // The side that can be seen, to where the tangents touch.
            let away = from - p;
            let least = u.x / away.length().max(u.x);
            let towards = away.normalize_or(Vec3::X);
            let cos = if border { least } else { least + (1.0 - least) * n.unit() };
            let (a, b) = towards.any_orthonormal_pair();
            let (s, c) = (n.unit() * core::f32::consts::TAU).sin_cos();
            let sin = (1.0 - cos * cos).max(0.0).sqrt();
            let d = (towards * cos + a * (sin * c) + b * (sin * s)).normalize();
            (p + d * u.x, d)
        }
        LightKind::Distant => {
            let (a, b) = u.any_orthonormal_pair();
            let cos = if border { v.x } else { 1.0 - (1.0 - v.x) * n.unit() };
            let (s, c) = (n.unit() * core::f32::consts::TAU).sin_cos();
            let sin = (1.0 - cos * cos).max(0.0).sqrt();
            ((u * cos + a * (sin * c) + b * (sin * s)).normalize(), Vec3::ZERO)
        }
        LightKind::Point | LightKind::Spot => (p, Vec3::ZERO),
    }
}

#[test]
fn no_hit_of_a_shadow_ray_is_lost() {
    let mut hits = [0; 7];
    for seed in 0..80_000_u64 {
        let n = &mut Numbers(seed << 16 | 1 << 50);
        let (size, offset) = scale_and_offset(n);
        let kind = n.pick(7);
        let light = light(n, LightKind::from_u32(kind as u32).unwrap(), size, offset);
        // One point, or a small box of points.
        let spread = size * [0.0, 0.0, 1e-3, 0.1, 1.0][n.pick(5)];
        let starts: Vec<Vec3> = (0..3).map(|_| offset + n.point() * spread).collect();
        let mut from = starts.iter().fold(Aabb::EMPTY, |b, s| b.with(*s));
        let points = starts.map_to_surface(n, size);
        for point in &points {
            from = from.union(point.origins());
        }
        let pyramid = Pyramid::to_light(&from, &light);
        for point in &points {
            let (end, normal) = sample(n, &light, point.position);
            let ray = if kind == LightKind::Distant as usize {
                point.spawn(end)
            } else {
                let [u, v] = [light.u, light.v].map(|v| Vec3::from(v).abs().max_element());
                let error =
                    16.0 * UNIT_ROUNDOFF * (Vec3::from(light.position).abs().max_element() + u + v);
                point.spawn_to(&Target { point: end, normal, extent: u + v, error })
            };
            // The tighter one, of the rays that leave the surface on their side.
            let single = point.pyramid_to(&light, ray.direction);
            let side = (ray.origin - point.position).as_dvec3().dot(point.normal.as_dvec3());
            let cos = ray.direction.as_dvec3().dot(point.normal.as_dvec3()) * side.signum();
            let leaves =
                ray.origin == single.origin() && cos > 1e-6 * f64::from(ray.direction.length());
            for _ in 0..3 {
                let t = if ray.t_max == 1.0 { n.unit() } else { n.decade(-3.0, 3.0) * size };
                let reach = t * ray.direction.length();
                let triangle_size = reach * n.decade(-5.0, 0.5);
                let vertices = beside(n, &ray, t, triangle_size);
                if hit(&ray, vertices).is_some() {
                    hits[kind] += 1;
                    let context = std::format!("seed {seed} {light:?} {ray:?}");
                    check(n, &pyramid, vertices, &context);
                    if leaves {
                        check(n, &single, vertices, &context);
                    }
                }
            }
        }
    }
    assert!(hits.iter().all(|&h| h > 5_000), "{hits:?}");
}

trait MapToSurface {
    fn map_to_surface(&self, n: &mut Numbers, size: f32) -> Vec<crate::geometry::SurfacePoint>;
}

impl MapToSurface for Vec<Vec3> {
    /// Points of triangles through these.
    fn map_to_surface(&self, n: &mut Numbers, size: f32) -> Vec<crate::geometry::SurfacePoint> {
        self.iter()
            .map(|&p| {
                let (a, b) = (n.direction() * size * 0.01, n.direction() * size * 0.01);
                let primitive = Primitive::Triangle { vertices: [p, p + a, p + b], normals: None };
                let ray = Ray { origin: p, direction: a, t_min: 0.0, t_max: 1.0 };
                Hit { t: 0.0, b1: 0.0, b2: 0.0, material: 0, primitive, block: 0 }.surface(&ray)
            })
            .collect()
    }
}

/// Whether a box and the infinite pyramid of an apex and directions touch, in f64, by clipping the box's faces: an independent
/// answer, with the box grown by `grow` times its size.
fn touches(aabb: &Aabb, apex: DVec3, directions: &[DVec3], grow: f64) -> bool {
    let pad = (aabb.max - aabb.min).as_dvec3() * grow;
    let (lo, hi) = (aabb.min.as_dvec3() - pad - apex, aabb.max.as_dvec3() + pad - apex);
    if lo.max_element() <= 0.0 && hi.min_element() >= 0.0 {
        return true;
    }
    let axis: DVec3 = directions.iter().sum();
    (0..6).any(|face| {
        let (k, i, j) = (face % 3, (face + 1) % 3, (face + 2) % 3);
        let mut polygon: Vec<DVec3> = [(0, 0), (1, 0), (1, 1), (0, 1)]
            .iter()
            .map(|&(a, b)| {
                let mut p = DVec3::ZERO;
                p[k] = if face < 3 { lo[k] } else { hi[k] };
                p[i] = if a == 0 { lo[i] } else { hi[i] };
                p[j] = if b == 0 { lo[j] } else { hi[j] };
                p
            })
            .collect();
        for e in 0..=directions.len() {
            let mut normal = if e == directions.len() {
                axis
            } else {
                directions[e].cross(directions[(e + 1) % directions.len()])
            };
            if normal.dot(axis) < 0.0 {
                normal = -normal;
            }
            let mut kept = Vec::new();
            for (a, &p) in polygon.iter().enumerate() {
                let q = polygon[(a + 1) % polygon.len()];
                let (dp, dq) = (normal.dot(p), normal.dot(q));
                if dp >= 0.0 {
                    kept.push(p);
                }
                if (dp >= 0.0) != (dq >= 0.0) {
                    kept.push(p + (q - p) * (dp / (dp - dq)));
                }
            }
            polygon = kept;
        }
        !polygon.is_empty()
    })
}

#[test]
fn a_box_is_outside_exactly_if_it_does_not_touch_the_pyramid() {
    let (mut outside, mut touching, mut inside) = (0, 0, 0);
    for seed in 0..40_000_u64 {
        let n = &mut Numbers(seed << 16 | 2 << 50);
        let apex = n.point();
        let axis = n.direction();
        let (u, v) = axis.any_orthonormal_pair();
        let (w, h) = (n.decade(-2.0, 0.3), n.decade(-2.0, 0.3));
        let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(x, y)| Ray {
            origin: apex,
            direction: axis + u * x * w + v * y * h,
            t_min: 0.0,
            t_max: f32::INFINITY,
        });
        let pyramid = Pyramid::of_tile(&corners);
        let directions = corners.map(|ray| ray.direction.as_dvec3());
        // Near the pyramid, often across its apex.
        let half = n.point().abs() * n.decade(-2.0, 0.5) + 1e-3;
        let middle = apex + axis * n.signed() * 3.0 + (u * n.signed() + v * n.signed()) * (w + h);
        let aabb = Aabb { min: middle - half, max: middle + half };
        let side = pyramid.classify(&aabb);
        if !touches(&aabb, apex.as_dvec3(), &directions, 0.001) {
            outside += 1;
            assert_eq!(side, Side::Outside, "seed {seed}");
        } else if touches(&aabb, apex.as_dvec3(), &directions, -0.001) {
            touching += 1;
            assert_ne!(side, Side::Outside, "seed {seed}");
        }
        if side == Side::Inside {
            inside += 1;
            for corner in 0..8 {
                let pick = |bit: usize| if corner >> bit & 1 == 0 { aabb.min } else { aabb.max };
                let p = Vec3::new(pick(0).x, pick(1).y, pick(2).z).as_dvec3();
                let point = Aabb { min: p.as_vec3(), max: p.as_vec3() };
                assert!(touches(&point, apex.as_dvec3(), &directions, 0.0), "seed {seed}");
            }
        }
    }
    assert!(outside > 5_000 && touching > 5_000 && inside > 100, "{outside} {touching} {inside}");
}

#[test]
fn a_pyramid_to_a_light_is_tight_around_its_own_shape() {
    // Boxes beside the segments from a point to a light: what part of those that no segment touches is seen to be outside?
    let parts = [0, 1, 2, 3].map(|kind| {
        let (mut free, mut outside) = (0, 0);
        for seed in 0..3_000_u64 {
            let n = &mut Numbers(seed << 16 | 3 << 50);
            let light = light(n, LightKind::from_u32(kind).unwrap(), 1.0, Vec3::ZERO);
            let from = Aabb { min: Vec3::ZERO, max: Vec3::ZERO };
            let pyramid = Pyramid::to_light(&from, &light);
            let t = n.unit();
            let ends: Vec<Vec3> = (0..1000).map(|_| sample(n, &light, Vec3::ZERO).0).collect();
            let around = ends.iter().fold(Aabb::EMPTY, |b, &p| b.with(p));
            let width = (around.max - around.min).max_element() * t;
            let middle = ends[0] * t + n.point() * width;
            let half = Vec3::splat(width * (0.05 + 0.2 * n.unit()));
            let aabb = Aabb { min: middle - half, max: middle + half };
            let grown = Aabb { min: middle - half * 1.3, max: middle + half * 1.3 };
            let touched = ends.iter().any(|&direction| {
                let ray = Ray { origin: Vec3::ZERO, direction, t_min: 0.0, t_max: 1.0 };
                let inside = PreparedRay::new(&ray).own_box(&grown);
                inside.is_some_and(|i| i.enter <= 1.0 && i.leave >= 0.0)
            });
            if !touched {
                free += 1;
                outside += usize::from(pyramid.classify(&aabb) == Side::Outside);
            }
        }
        outside as f64 / free as f64
    });
    std::println!("outside, of those free: {parts:?}");
    assert!(parts.iter().all(|&p| p > 0.92), "{parts:?}");
}

#[test]
fn strange_pyramids_hold_everything() {
    let nan = Ray { origin: Vec3::NAN, direction: Vec3::X, t_min: 0.0, t_max: 1.0 };
    let flat = Ray { origin: Vec3::ZERO, direction: Vec3::ZERO, t_min: 0.0, t_max: f32::INFINITY };
    let unit = Aabb { min: -Vec3::ONE, max: Vec3::ONE };
    assert_eq!(Pyramid::of_tile(&[nan; 4]).classify(&unit), Side::Inside);
    assert_ne!(Pyramid::of_tile(&[flat; 4]).classify(&unit), Side::Outside);
    let mut light = Light::zeroed();
    for kind in 0..9 {
        for s in [f32::NAN, f32::INFINITY, 0.0, 1e38, 1e-45] {
            light.kind = kind;
            (light.position, light.u, light.v) = ([s; 3], [s; 3], [s; 3]);
            let pyramid = Pyramid::to_light(&unit, &light);
            assert_ne!(pyramid.classify(&unit), Side::Outside, "{kind} {s}");
            assert!(pyramid.direction().is_finite() || s == 1e38);
        }
    }
    let strange = Aabb { min: Vec3::NAN, max: Vec3::INFINITY };
    let corner = Ray { origin: Vec3::ZERO, direction: Vec3::X, ..flat };
    assert_ne!(Pyramid::of_tile(&[corner; 4]).classify(&strange), Side::Outside);
}

#[test]
fn the_light_itself_is_not_touched() {
    let mut asked = 0;
    for seed in 0..20_000_u64 {
        let n = &mut Numbers(seed << 16 | 4 << 50);
        let (size, offset) = scale_and_offset(n);
        let offset = offset * 1e-4;
        let kind = LightKind::from_u32(n.pick(4) as u32).unwrap();
        let light = light(n, kind, size, offset);
        let [p, u, v] = [light.position, light.u, light.v].map(Vec3::from);
        let from = Aabb { min: offset, max: offset };
        let pyramid = Pyramid::to_light(&from, &light);
        // Seen at more than a grazing angle.
        let (normal, way) = (u.cross(v).normalize_or_zero(), (p - offset).normalize());
        if kind != LightKind::Sphere && (normal.dot(way).abs() < 0.01 || normal == Vec3::ZERO) {
            continue;
        }
        asked += 1;
        let triangle = |vertices| Primitive::Triangle { vertices, normals: None };
        let surface = match kind {
            LightKind::Parallelogram => {
                [triangle([p, p + u, p + u + v]), triangle([p + v, p, p + u + v])]
            }
            LightKind::Triangle => [triangle([p, p + u, p + v]); 2],
            LightKind::Disc => [triangle([p, p + u, p + v]), triangle([p, p - v, p - u * 0.3])],
            _ => [Primitive::Sphere { center: p, radius: u.x, inward: false }; 2],
        };
        for primitive in surface {
            assert!(!pyramid.touches(&primitive, Planes::ALL), "seed {seed} {light:?} {pyramid:?}");
        }
        // What stands before it is touched.
        let at = offset + (p + u * 0.3 + v * 0.3 - offset) * 0.9;
        if kind != LightKind::Sphere {
            let before = triangle([at, at + u * 0.1, at + v * 0.1]);
            assert!(pyramid.touches(&before, Planes::ALL), "seed {seed} {light:?}");
        }
    }
    assert!(asked > 15_000, "{asked}");
}

#[test]
fn a_small_sun_is_as_wide_as_its_samples() {
    for degrees in [0.005_f64, 0.02, 0.1, 0.3, 0.533, 2.0] {
        let half = (degrees * 0.5).to_radians();
        let versine = 2.0 * (half * 0.5).sin().powi(2);
        let light = crate::scene::Light {
            kind: crate::scene::LightKind::Distant as u32,
            reach: f32::INFINITY,
            u: [0.0, 0.0, 1.0],
            v: [half.cos() as f32, versine as f32, 0.0],
            ..bytemuck::Zeroable::zeroed()
        };
        let origin = Vec3::ZERO;
        let pyramid = Pyramid::to_light(&Aabb { min: origin, max: origin }, &light);
        for turn in 0..32 {
            let (sin, cos) = (f64::from(turn) / 32.0 * core::f64::consts::TAU).sin_cos();
            let at = glam::DVec3::new(half.tan() * cos, half.tan() * sin, 1.0).as_vec3();
            let own = Aabb { min: at, max: at };
            assert_ne!(pyramid.classify(&own), Side::Outside, "{degrees} {turn}");
        }
    }
}
