//! The origins of spawned rays, for any hit.
#![no_std]
#![no_main]

use core::hint::black_box;
use kiloray_core::geometry::{Hit, Primitive, Ray, Target};
use kiloray_no_panic::{any, entry};

entry!({
    let ray = Ray { origin: any(), direction: any(), t_min: any(), t_max: any() };
    let primitive = if any::<u8>() == 0 {
        let normals = (any::<u8>() == 0).then(any);
        Primitive::Triangle { vertices: [any(), any(), any()], normals }
    } else {
        Primitive::Sphere { center: any(), radius: any(), inward: any::<u8>() == 0 }
    };
    let hit = Hit { t: any(), b1: any(), b2: any(), material: any(), primitive, block: any() };
    let surface = hit.surface(&ray);
    let target = Target { point: any(), normal: any(), extent: any(), error: any() };
    black_box((surface.spawn(any()), surface.spawn_to(&target)));
    black_box(surface.spawn_to(&Target::free(any())));
});
