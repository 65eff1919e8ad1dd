//! The expanded top of a tree: traced whatever it holds, by rays one by one, in batches and in bundles.
#![no_std]
#![no_main]

use core::hint::black_box;
use kiloray_core::block::{
    BlockView, Expanded, ExpandedChild, ExpandedNode, ExpandedTop, KiloView,
};
use kiloray_core::geometry::Ray;
use kiloray_core::trace::{Batch, Bundle, Cursor, Scalar, Tracer};
use kiloray_no_panic::{any, any_bytes, any_room, entry};

entry!({
    if let Ok(file) = KiloView::parse(any_bytes()) {
        let (mut nodes, mut refs) = ([any::<ExpandedNode>(); 8], [any(); 64]);
        let (nodes, refs) = (any_room(&mut nodes), any_room(&mut refs));
        let view = BlockView::trusted(any_bytes());
        let child = any::<[u32; 8]>().map(ExpandedChild::Ref);
        black_box(ExpandedNode::of(&view, &any(), child));
        let ray = Ray { origin: any(), direction: any(), t_min: any(), t_max: any() };
        let mut source = Expanded { file, top: ExpandedTop::new(nodes, refs) };
        let cursor = &mut Cursor::new();
        let _ = black_box(Scalar.closest(cursor, &mut source, &ray));
        let _ = black_box(Scalar.any(cursor, &mut source, &ray));
        black_box((cursor.trail(), cursor.best(), cursor.take_visited()));
        let (mut rays, mut closest, mut found) = ([ray; 80], [None; 80], [false; 80]);
        let rays = &*any_room(&mut rays);
        let (closest, found) = (any_room(&mut closest), any_room(&mut found));
        let batch = &mut Batch::new();
        let _ = black_box(Scalar.closest_batch(batch, &mut source, rays, closest));
        let _ = black_box(Scalar.any_batch(batch, &mut source, rays, found));
        let bundle = &mut Bundle::new();
        let _ = black_box(Scalar.closest_bundle(bundle, &mut source, rays, closest));
        let _ = black_box(Scalar.any_bundle(bundle, &mut source, rays, found));
        black_box((closest, found));
    }
});
