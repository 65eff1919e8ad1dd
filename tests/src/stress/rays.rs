//! Random rays that are hard for a tracer, in scene coordinates.

use fastrand::Rng;
use glam::{DVec3, Vec3};
use kiloray_core::geometry::{Primitive, Ray};

use super::{direction, in_cube, unit, weights};

/// A ray, for a scene of these primitives.
pub(super) fn ray(rng: &mut Rng, primitives: &[(Primitive, u16)]) -> Ray {
    let target = &primitives[rng.usize(0..primitives.len())].0;
    let origin = match rng.u8(0..8) {
        0 => on(rng, target),
        1 => direction(rng) * 1e4,
        2 => corner(rng, target),
        _ => in_cube(rng) * 1.5,
    };
    let origin = origin.as_vec3();
    let towards = match rng.u8(0..5) {
        0 => on(rng, target),
        1 => corner(rng, target),
        2 => {
            let s = unit(rng);
            corner(rng, target) * s + corner(rng, target) * (1.0 - s)
        }
        3 => origin.as_dvec3() + direction(rng),
        _ => origin.as_dvec3() + axis(rng),
    };
    let mut d = towards.as_vec3() - origin;
    if d == Vec3::ZERO {
        d = direction(rng).as_vec3();
    }
    // Unit length as a rule; `t` is in units of the direction, whatever its length.
    d = match rng.u8(0..4) {
        0 => d,
        1 => d * 10_f32.powf(rng.f32() * 16.0 - 8.0),
        _ => d / d.length(),
    };
    for axis in 0..3 {
        if d[axis] == 0.0 && rng.bool() {
            d[axis] = -0.0;
        }
    }
    let t_max = if rng.u8(0..4) == 0 { rng.f32() * 2.0 } else { f32::INFINITY };
    let t_min = if rng.u8(0..8) == 0 { rng.f32() * 0.5 } else { 0.0 };
    Ray { origin, direction: d, t_min, t_max }
}

fn axis(rng: &mut Rng) -> DVec3 {
    let sign = if rng.bool() { 1.0 } else { -1.0 };
    [DVec3::X, DVec3::Y, DVec3::Z][rng.usize(0..3)] * sign
}

fn corner(rng: &mut Rng, primitive: &Primitive) -> DVec3 {
    match primitive {
        Primitive::Triangle { vertices, .. } => vertices[rng.usize(0..3)].as_dvec3(),
        Primitive::Sphere { center, radius, .. } => {
            center.as_dvec3() + axis(rng) * f64::from(*radius)
        }
    }
}

fn on(rng: &mut Rng, primitive: &Primitive) -> DVec3 {
    match primitive {
        Primitive::Triangle { vertices: [a, b, c], .. } => {
            let [u, v, w] = weights(rng);
            a.as_dvec3() * u + b.as_dvec3() * v + c.as_dvec3() * w
        }
        Primitive::Sphere { center, radius, .. } => {
            center.as_dvec3() + direction(rng) * f64::from(*radius)
        }
    }
}
