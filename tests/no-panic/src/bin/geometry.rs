//! The reference tests of a hit, for any numbers.
#![no_std]
#![no_main]

use core::hint::black_box;
use kiloray_core::block::octahedral;
use kiloray_core::geometry::{Aabb, Hit, PreparedRay, Primitive, Ray};
use kiloray_no_panic::{any, entry};

fn hit() -> Hit {
    let primitive = if any::<u8>() == 0 {
        let normals = (any::<u8>() == 0).then(any);
        Primitive::Triangle { vertices: [any(), any(), any()], normals }
    } else {
        Primitive::Sphere { center: any(), radius: any(), inward: any::<u8>() == 0 }
    };
    Hit { t: any(), b1: any(), b2: any(), material: any(), primitive, block: any() }
}

entry!({
    let ray =
        PreparedRay::new(&Ray { origin: any(), direction: any(), t_min: any(), t_max: any() });
    let triangle = [any(), any(), any()];
    black_box((ray.triangle(triangle), ray.sphere(any(), any()), ray.is_none()));
    for own in [Aabb::of_triangle(triangle), Aabb::of_sphere(any(), any())] {
        if let Some(interval) = ray.own_box(&own) {
            black_box(ray.accept(any(), interval));
        }
    }
    let (a, b) = (hit(), hit());
    black_box((a.is_closer_than(&b), a.primitive.total_cmp(&b.primitive)));
    black_box((octahedral::encode(any()), octahedral::decode(any())));
});
