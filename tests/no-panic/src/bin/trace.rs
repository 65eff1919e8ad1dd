//! Closest hit, any hit and every hit over blocks of any bytes, of rays one by one, in batches and in bundles, with the lanes of a small processor.
#![no_std]
#![no_main]

use core::hint::black_box;
use kiloray_core::block::KiloView;
use kiloray_core::geometry::Ray;
use kiloray_core::trace::{Batch, Bundle, Cursor, Scalar, Tracer};
use kiloray_no_panic::{any, any_bytes, any_room, entry};

entry!({
    if let Ok(mut file) = KiloView::parse(any_bytes()) {
        let ray = Ray { origin: any(), direction: any(), t_min: any(), t_max: any() };
        let cursor = &mut Cursor::new();
        let trail = any();
        let best = Scalar.closest(cursor, &mut file, &ray).ok().flatten();
        let _ = black_box(Scalar.continue_closest(cursor, &mut file, &ray, best, &trail));
        let _ = black_box(Scalar.any(cursor, &mut file, &ray));
        let _ = black_box(Scalar.continue_any(cursor, &mut file, &ray, &trail));
        let _ = black_box(Scalar.continue_every(cursor, &mut file, &ray, &trail, |hit| {
            black_box(hit);
            any::<u8>() == 0
        }));
        black_box((cursor.trail(), cursor.best(), cursor.take_visited()));
        let (mut rays, mut closest, mut found) = ([ray; 80], [None; 80], [false; 80]);
        let rays = &*any_room(&mut rays);
        let (closest, found) = (any_room(&mut closest), any_room(&mut found));
        let batch = &mut Batch::new();
        let _ = black_box(Scalar.closest_batch(batch, &mut file, rays, closest));
        let _ = black_box(Scalar.any_batch(batch, &mut file, rays, found));
        let bundle = &mut Bundle::new();
        let _ = black_box(Scalar.closest_bundle(bundle, &mut file, rays, closest));
        let _ = black_box(Scalar.any_bundle(bundle, &mut file, rays, found));
        black_box((closest, found));
    }
});
