use std::vec::Vec;

use super::scenes::{Random, clutter, no_rays, rays};
use super::writer::{Blocks, Item, write};
use super::{Grown, OneFrame, Resident, Source, Topped, brute, check, erased, shown};
use crate::block::ExpandedTop;
use crate::block::SPHERES;
use crate::geometry::{Hit, Ray};
use crate::trace::{Batch, Cursor, Tracer};

fn layouts(items: &[Item]) -> Vec<Blocks> {
    [(1 << 10, 1, 1), (1 << 11, 2, 99), (1 << 12, 4, 99), (1 << 14, 3, 999), (1 << 16, 4, 999)]
        .map(|(bytes, leaf, nodes)| write(items, bytes, leaf, nodes))
        .into()
}

fn compare(tracer: impl Tracer, blocks: &Blocks, items: &[Item], rays: &[Ray]) {
    check(blocks);
    let mut cursor = Cursor::new();
    let mut cached = OneFrame::new(blocks);
    // The root alone, some levels, all nodes: a room that is too small ends in the middle of a level.
    let grown = [1, 5, 33, 4096].map(|room| Grown::new(blocks, room));
    let tops = grown.each_ref().map(Grown::top);
    for ray in rays {
        let expected = brute(items, ray);
        let closest = expected.first().copied();
        asks(tracer, &mut cursor, &mut Resident(blocks), ray, &expected);
        for top in tops {
            asks(tracer, &mut cursor, &mut Topped(Resident(blocks), top), ray, &expected);
        }
        assert_eq!(tracer.closest(&mut cursor, &mut erased(&mut cached), ray), Ok(closest));
    }
    assert!(cached.fetches > 0);
    batches(tracer, blocks, &tops, items, rays);
}

/// Every way of asking gives the hits that are expected.
fn asks(
    tracer: impl Tracer,
    cursor: &mut Cursor,
    mut source: Source<'_>,
    ray: &Ray,
    expected: &[Hit],
) {
    let source = &mut source;
    let closest = expected.first().copied();
    assert_eq!(tracer.closest(cursor, source, ray), Ok(closest), "{ray:?}");
    assert_eq!(tracer.any(cursor, source, ray), Ok(closest.is_some()));
    let all = shown(|visit| tracer.every(cursor, source, ray, visit));
    assert_eq!(all, (Ok(()), expected.to_vec()));
}

/// Batches give what single rays give: from a source that has all, from the top of its tree, and from a source that has one block.
fn batches(
    tracer: impl Tracer,
    blocks: &Blocks,
    tops: &[ExpandedTop<'_>],
    items: &[Item],
    rays: &[Ray],
) {
    let expected: Vec<Option<Hit>> =
        rays.iter().map(|ray| brute(items, ray).first().copied()).collect();
    let any: Vec<bool> = expected.iter().map(Option::is_some).collect();
    let mut room = Batch::new();
    for part in [rays.len(), 1, 5] {
        let (mut hits, mut found) = (std::vec![None; part], std::vec![true; part]);
        let rays = &rays[..part];
        tracer
            .closest_batch(&mut room, &mut erased(&mut Resident(blocks)), rays, &mut hits)
            .unwrap();
        assert_eq!(hits, expected[..part]);
        tracer.any_batch(&mut room, &mut erased(&mut Resident(blocks)), rays, &mut found).unwrap();
        assert_eq!(found, any[..part]);
        tracer
            .closest_batch(&mut room, &mut erased(&mut OneFrame::new(blocks)), rays, &mut hits)
            .unwrap();
        assert_eq!(hits, expected[..part]);
        tracer
            .any_batch(&mut room, &mut erased(&mut OneFrame::new(blocks)), rays, &mut found)
            .unwrap();
        assert_eq!(found, any[..part]);
    }
    let (mut hits, mut found) = (std::vec![None; rays.len()], std::vec![true; rays.len()]);
    for &top in tops {
        tracer
            .closest_batch(
                &mut room,
                &mut erased(&mut Topped(Resident(blocks), top)),
                rays,
                &mut hits,
            )
            .unwrap();
        assert_eq!(hits, expected);
        tracer
            .any_batch(&mut room, &mut erased(&mut Topped(Resident(blocks), top)), rays, &mut found)
            .unwrap();
        assert_eq!(found, any);
    }
}

pub(crate) fn layouts_agree(tracer: impl Tracer) {
    for (seed, count) in [(1, 1), (2, 7), (3, 60), (4, 300), (5, 300)] {
        let mut random = Random(seed);
        let items = clutter(count, SPHERES, &mut random);
        let rays = rays(&items, 600, &mut random);
        for blocks in layouts(&items) {
            compare(tracer, &blocks, &items, &rays);
        }
    }
}

pub(crate) fn scales_agree(tracer: impl Tracer) {
    for (seed, size, offset) in [(11, 1e-6, 0.0), (12, 1e-4, 0.75), (13, 1e-20, 0.0)] {
        let mut random = Random(seed);
        let mut items = clutter(100, false, &mut random);
        for item in &mut items {
            if let crate::geometry::Primitive::Triangle { vertices, .. } = &mut item.0 {
                *vertices = vertices.map(|v| v * size + glam::Vec3::splat(offset));
            }
        }
        let rays = rays(&items, 400, &mut random);
        for blocks in layouts(&items) {
            compare(tracer, &blocks, &items, &rays);
        }
    }
}

pub(crate) fn no_ray_hits(tracer: impl Tracer) {
    let mut random = Random(21);
    let items = clutter(50, false, &mut random);
    let blocks = write(&items, 1 << 12, 4, 99);
    let mut cursor = Cursor::new();
    for ray in no_rays() {
        assert_eq!(
            tracer.closest(&mut cursor, &mut erased(&mut Resident(&blocks)), &ray),
            Ok(None),
            "{ray:?}"
        );
        assert_eq!(tracer.any(&mut cursor, &mut erased(&mut Resident(&blocks)), &ray), Ok(false));
    }
    let mut room = crate::trace::Bundle::new();
    for lead in rays(&items, 60, &mut random) {
        for (t_min, t_max) in [(f32::NAN, f32::INFINITY), (0.0, f32::NAN)] {
            let none = [Ray { t_min, t_max, ..lead }; 16];
            let mut hits = [None; 16];
            let traced = tracer.closest_bundle(
                &mut room,
                &mut erased(&mut Resident(&blocks)),
                &none,
                &mut hits,
            );
            assert_eq!((traced, hits), (Ok(()), [None; 16]));
        }
    }
}
