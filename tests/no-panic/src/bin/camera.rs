//! From any view, size and pixel to a ray, and the random numbers of that.
#![no_std]
#![no_main]

use core::hint::black_box;
use kiloray_core::path::PathKey;
use kiloray_core::random::{Purpose, Sequence};
use kiloray_core::scene::View;
use kiloray_core::view::Camera;
use kiloray_no_panic::{any, entry};

entry!({
    let key = PathKey::camera(any(), any(), any());
    if let Some(camera) = Camera::new(&any::<View>(), any(), any(), any()) {
        black_box((camera.ray(any(), any(), key), camera.ray_at(any(), any())));
    }
    black_box(Sequence::new(key, Purpose::Light(any())).point(any()));
});
