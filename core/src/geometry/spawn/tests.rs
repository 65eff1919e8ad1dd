use super::base::round_towards;
use super::*;
use crate::geometry::Hit;

/// Numbers from a counter: the seed of a failure is in its message.
struct Numbers(u64);

impl Numbers {
    fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(1);
        let hash = |k| u64::from(crate::path::PathKey::camera(self.0, k, 0).scramble(k));
        hash(0) << 32 | hash(1)
    }
    /// In [-1, 1).
    fn signed(&mut self) -> f32 {
        ((self.bits() >> 11) as f64 / (1_u64 << 52) as f64 - 1.0) as f32
    }
    fn point(&mut self) -> Vec3 {
        Vec3::new(self.signed(), self.signed(), self.signed())
    }
    fn direction(&mut self) -> Vec3 {
        let v = self.point();
        if v.length() < 0.1 { Vec3::new(0.6, -0.0, 0.8) } else { v.normalize() }
    }
    fn pick(&mut self, n: u64) -> u64 {
        self.bits() % n
    }
    /// Powers of ten from 10^lo to 10^hi.
    fn decade(&mut self, lo: i32, hi: i32) -> f32 {
        let e = lo as f64 + (hi - lo) as f64 * (f64::from(self.signed()) + 1.0) / 2.0;
        10_f64.powf(e) as f32
    }
}

/// A triangle of any size, shape and place: slivers, needles, offsets of 10⁴ sizes and more.
fn triangle(n: &mut Numbers) -> [Vec3; 3] {
    let size = n.decade(-19, 19);
    let offset = match n.pick(3) {
        0 => Vec3::ZERO,
        1 => n.point() * size * 1e4,
        _ => n.point() * size * n.decade(0, 6).min(1e19 / size),
    };
    let a = n.direction();
    let b = n.direction();
    let width = match n.pick(4) {
        0 => 1.0,
        1 => 1e-6,
        2 => n.decade(-12, 0),
        _ => n.decade(-3, 0),
    };
    let c = a * n.signed() + b * width;
    let mut vertices = [offset, offset + a * size, offset + c * size];
    vertices.rotate_left(n.pick(3) as usize);
    if n.pick(4) == 0 {
        // In a plane of two axes.
        let (axis, at) = (n.pick(3) as usize, vertices[0]);
        for v in &mut vertices {
            v[axis] = at[axis];
        }
    }
    vertices
}

fn hit_of(ray: &Ray, vertices: [Vec3; 3]) -> Option<Hit> {
    let hit = PreparedRay::new(ray).triangle(vertices)?;
    let primitive = Primitive::Triangle { vertices, normals: None };
    Some(Hit { t: hit.t, b1: hit.b1, b2: hit.b2, material: 0, primitive, block: 0 })
}

/// A ray to some point of the triangle, from near or far.
fn ray_to(n: &mut Numbers, vertices: [Vec3; 3]) -> Ray {
    let [v0, v1, v2] = vertices;
    let (mut s, mut t) = ((n.signed() + 1.0) / 2.0, (n.signed() + 1.0) / 2.0);
    match n.pick(8) {
        0 => (s, t) = (0.0, 0.0),
        1 => s = 0.0,
        _ => {}
    }
    if s + t > 1.0 {
        (s, t) = (1.0 - s, 1.0 - t);
    }
    let target = v0 + (v1 - v0) * s + (v2 - v0) * t;
    let size = (v1 - v0).abs().max((v2 - v0).abs()).max_element();
    let mut direction = n.direction();
    if n.pick(6) == 0 {
        direction = [Vec3::X, Vec3::Y, Vec3::Z, -Vec3::Y][n.pick(4) as usize];
    }
    let distance = size * n.decade(-2, 4).min(1e19 / size);
    Ray { origin: target - direction * distance, direction, t_min: 0.0, t_max: f32::INFINITY }
}

/// Directions from a surface: any, along it, and as good as along it.
fn leaving(n: &mut Numbers, vertices: [Vec3; 3], normal: Vec3) -> Vec3 {
    let [v0, v1, v2] = vertices;
    let along = match n.pick(4) {
        0 => (v1 - v0).normalize_or(Vec3::X),
        1 => (v2 - v1).normalize_or(Vec3::X),
        2 => (v0 - v2).normalize_or(Vec3::X),
        _ => normal.cross(n.direction()).normalize_or(Vec3::X),
    };
    match n.pick(4) {
        0 => n.direction(),
        1 => along,
        2 => along + normal * n.signed() * n.decade(-12, 0),
        _ => normal * if n.pick(2) == 0 { -1.0 } else { 1.0 },
    }
}

#[test]
fn a_ray_from_a_triangle_does_not_hit_it_again() {
    let (mut hits, mut spawned) = (0, 0);
    for seed in 0..40_000_u64 {
        let n = &mut Numbers(seed << 20);
        let vertices = triangle(n);
        let ray = ray_to(n, vertices);
        let Some(hit) = hit_of(&ray, vertices) else { continue };
        hits += 1;
        let point = hit.surface(&ray);
        assert!((point.normal.length() - 1.0).abs() < 1e-6, "seed {seed}");
        for _ in 0..24 {
            let out = point.spawn(leaving(n, vertices, point.normal));
            let again = hit_of(&out, vertices);
            assert_eq!(again, None, "seed {seed}: {vertices:?} {ray:?} {out:?}");
            spawned += usize::from(!PreparedRay::new(&out).is_none());
        }
    }
    assert!(hits > 10_000 && spawned > 200_000, "{hits} {spawned}");
}

#[test]
fn a_shadow_ray_hits_neither_its_surface_nor_the_light() {
    let mut asked = 0;
    for seed in 0..40_000_u64 {
        let n = &mut Numbers(seed << 20 | 1 << 60);
        let vertices = triangle(n);
        let ray = ray_to(n, vertices);
        let Some(hit) = hit_of(&ray, vertices) else { continue };
        let point = hit.surface(&ray);
        // A light of any size at any distance, seen at an angle of its plane that is not all rounding.
        let [v0, v1, v2] = vertices;
        let size = (v1 - v0).abs().max((v2 - v0).abs()).max_element();
        let away = size * n.decade(-1, 4);
        let light_size = away * n.decade(-3, 1);
        let corner = point.position + n.direction() * away;
        let (u, v) = (n.direction() * light_size, n.direction() * light_size);
        let light = [corner, corner + u, corner + v];
        let normal = u.as_dvec3().cross(v.as_dvec3()).normalize_or_zero();
        let (a, b) = ((n.signed() + 1.0) / 4.0, (n.signed() + 1.0) / 4.0);
        let end = corner + u * a + v * b;
        let way = (end - point.position).as_dvec3();
        // The light's own plane, after its corners were rounded, decides at which side the point is.
        let [l0, l1, l2] = light.map(Vec3::as_dvec3);
        let plane = (l1 - l0).cross(l2 - l0).normalize_or_zero();
        let off = (l0 - point.position.as_dvec3()).dot(plane);
        let distance = off.abs().min(way.dot(point.base.unit.into()).abs());
        let magnitude = corner.abs().max_element() + light_size + away;
        // A direction, here the way to the light, has a range: `PreparedRay::DIRECTION_MIN`.
        if away < 1e-18
            || normal.length() < 0.5
            || distance < f64::from(magnitude) * 2e-5
            || off.signum() != way.dot(normal).signum()
            || magnitude > 1e19
        {
            continue;
        }
        asked += 1;
        let error = 8.0 * UNIT_ROUNDOFF * (corner.abs().max_element() + 2.0 * light_size);
        let extent = 2.0 * light_size;
        let target = Target { point: end, normal: normal.as_vec3(), extent, error };
        let out = point.spawn_to(&target);
        assert_eq!(hit_of(&out, vertices), None, "seed {seed}: {vertices:?} {out:?}");
        assert_eq!(hit_of(&out, light), None, "seed {seed}: {light:?} {out:?}");
        // Prolonged by little, it does hit a light that is no sliver: it ends just before it.
        let wide = (l1 - l0).cross(l2 - l0).length() > 0.3 * f64::from(light_size * light_size);
        if wide
            && light_size > away * 0.05
            && a > 0.05
            && b > 0.05
            && distance > f64::from(magnitude) * 1e-2
        {
            let on = Ray { t_max: 1.02, ..out };
            assert!(hit_of(&on, light).is_some(), "seed {seed}: {light:?} {out:?}");
        }
    }
    assert!(asked > 10_000, "{asked}");
}

#[cfg(feature = "sphere")]
#[test]
fn a_ray_from_a_sphere_hits_only_its_far_side() {
    let (mut outside, mut inside) = (0, 0);
    for seed in 0..20_000_u64 {
        let n = &mut Numbers(seed << 20 | 2 << 60);
        let radius = n.decade(-15, 15);
        let center = n.point() * radius * [0.0, 1.0, 1e4][n.pick(3) as usize];
        let on = center + n.direction() * radius * (n.signed() * 0.5 + 0.5);
        let direction = n.direction();
        let origin = on - direction * radius * n.decade(-2, 4);
        let ray = Ray { origin, direction, t_min: 0.0, t_max: f32::INFINITY };
        let Some(t) = PreparedRay::new(&ray).sphere(center, radius) else { continue };
        let primitive = Primitive::Sphere { center, radius, inward: n.pick(2) == 0 };
        let point = Hit { t, b1: 0.0, b2: 0.0, material: 0, primitive, block: 0 }.surface(&ray);
        let outward = (DVec3::from(point.base.exact) - center.as_dvec3()).normalize();
        for _ in 0..24 {
            let tangent = outward.as_vec3().cross(n.direction()).normalize_or(Vec3::X);
            let direction = match n.pick(3) {
                0 => n.direction(),
                1 => tangent,
                _ => tangent + outward.as_vec3() * n.signed() * n.decade(-10, 0),
            };
            let out = point.spawn(direction);
            let d = direction.as_dvec3();
            let again = PreparedRay::new(&out).sphere(center, radius);
            let cos = d.dot(outward) / d.length();
            let outwards =
                if cos == 0.0 { outward.dot(point.base.unit.into()) > 0.0 } else { cos > 0.0 };
            if outwards {
                outside += 1;
                assert_eq!(again, None, "seed {seed}: {center} {radius} {out:?}");
            } else {
                inside += 1;
                // The chord, give or take what f32 rounding along the surface changes.
                let chord = -2.0 * f64::from(radius) * cos / d.length();
                let slack =
                    f64::from(radius) * 2e-5 + 4.0 * ULP * point.base.exact.abs().greatest();
                let t = f64::from(again.unwrap_or_else(|| panic!("seed {seed}: {out:?}")));
                let root = (slack * f64::from(radius)).sqrt() + slack;
                assert!((t - chord).abs() <= root, "seed {seed}: {t} {chord} {root}");
            }
        }
    }
    assert!(outside > 50_000 && inside > 50_000, "{outside} {inside}");
}

#[test]
fn the_point_lies_on_the_triangle_and_the_ray_begins_off_it() {
    let vertices = [Vec3::ZERO, Vec3::X, Vec3::Y].map(|v| v + Vec3::new(0.1, 0.2, 0.3));
    let ray = Ray { origin: Vec3::ONE, direction: -Vec3::ONE, t_min: 0.0, t_max: f32::INFINITY };
    let point = hit_of(&ray, vertices).unwrap().surface(&ray);
    assert_eq!(point.normal, Vec3::Z);
    assert_eq!(point.position.z, 0.3);
    let (up, down) = (point.spawn(Vec3::Z), point.spawn(-Vec3::Z));
    assert!(up.origin.z > 0.3 && up.origin.z < 0.3 + 1e-5, "{}", up.origin.z);
    assert!(down.origin.z < 0.3 && down.origin.z > 0.3 - 1e-5, "{}", down.origin.z);
    assert_eq!((up.origin.x, up.origin.y), (point.position.x, point.position.y));
}

#[test]
fn nothing_strange_makes_it_panic() {
    let strange = [f32::NAN, f32::INFINITY, 0.0, 1e38, 1e-45];
    for s in strange {
        let ray = Ray { origin: Vec3::splat(s), direction: Vec3::ZERO, t_min: s, t_max: s };
        for primitive in [
            Primitive::Triangle { vertices: [Vec3::splat(s); 3], normals: None },
            Primitive::Triangle { vertices: [Vec3::X, Vec3::splat(s), Vec3::Z], normals: None },
            Primitive::Sphere { center: Vec3::splat(s), radius: s, inward: false },
        ] {
            let hit = Hit { t: s, b1: s, b2: s, material: 0, primitive, block: 0 };
            let point = hit.surface(&ray);
            let out = point.spawn(Vec3::splat(s));
            let to = point.spawn_to(&Target::free(Vec3::splat(s)));
            assert!(PreparedRay::new(&out).is_none() || s == 1e-45 || s == 1e38 || s == 0.0);
            let _ = PreparedRay::new(&to);
        }
    }
}

#[test]
fn rounding_to_a_side_is_the_nearest_number_or_its_neighbour() {
    let mut n = Numbers(11);
    let special = [0.0, -0.0, f64::MIN_POSITIVE, 1e-46, -1e-46, 3e-45, f64::from(f32::MAX), 1e39];
    let special = special.into_iter().chain([-1e39, f64::INFINITY, f64::NAN, 1.0, -1.0]);
    let any = (0..200_000).map(|_| match n.pick(2) {
        0 => f64::from_bits(n.bits()),
        _ => f64::from(n.signed()) * f64::from(n.decade(-46, 39)) * (1.0 + 1e-9),
    });
    for x in special.chain(any) {
        let nearest = x as f32;
        let next = |is_wrong: bool, next: f32| if is_wrong { next } else { nearest };
        let up = next(f64::from(nearest) < x, nearest.next_up());
        let down = next(f64::from(nearest) > x, nearest.next_down());
        for (sign, expected) in [(0.3, up), (-0.3, down), (0.0, nearest), (-0.0, nearest)] {
            let found = round_towards(x, sign);
            assert_eq!(found.to_bits(), expected.to_bits(), "{x:e} towards {sign}");
        }
    }
}
