//! Pyramids of any rays and lights, clipped against blocks of any bytes.
#![no_std]
#![no_main]

use core::hint::black_box;
use kiloray_core::block::KiloView;
use kiloray_core::geometry::{Aabb, Planes, Pyramid, Ray};
use kiloray_core::trace::{Clip, ClipEntry};
use kiloray_no_panic::{any, any_bytes, entry};

entry!({
    let pyramid = if any::<u8>() == 0 {
        let ray = || Ray { origin: any(), direction: any(), t_min: any(), t_max: any() };
        Pyramid::of_tile(&[ray(), ray(), ray(), ray()])
    } else {
        Pyramid::to_light(&Aabb { min: any(), max: any() }, &any())
    };
    let aabb = Aabb { min: any(), max: any() };
    black_box((pyramid.classify(&aabb), pyramid.clip(&aabb, Planes::from_bits(any()))));
    if let Ok(mut file) = KiloView::parse(any_bytes()) {
        let mut window = [ClipEntry::EMPTY; 24];
        if let Some(mut clip) = Clip::new(pyramid, any(), &mut window) {
            while clip.round(&mut file).is_ok() && !clip.is_done() {
                black_box((clip.waiting().count(), clip.is_complete(), clip.counts()));
                if black_box(clip.pop()).is_none() {
                    break;
                }
            }
        }
    }
});
