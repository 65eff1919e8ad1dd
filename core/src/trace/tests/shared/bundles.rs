//! Bundles find what single rays find.

use std::vec::Vec;

use glam::Vec3;

use super::scenes::{Random, clutter, rays};
use super::writer::{Blocks, write};
use super::{OneFrame, Resident, erased, shown};
use crate::block::format::Child;
use crate::block::{BlockSource, BlockView, NoBlock, SPHERES};
use crate::geometry::{Hit, PreparedRay, Primitive, Ray};
use crate::trace::{BUNDLE, Batch, BoxRay, Bundle, Cursor, Query, Tracer, Whole};

/// Neighbours of a ray: the closer, the more coherent.
fn neighbours(ray: &Ray, random: &mut Random) -> Vec<Ray> {
    let count = 1 + random.below(BUNDLE as u32 + 9);
    let (apart, turn) = (random.scale(24), random.scale(24));
    let kind = random.below(6);
    let size = ray.direction.abs().max_element();
    let pattern = (0..count).map(|_| {
        let mut ray = *ray;
        if kind != 0 {
            ray.origin += Vec3::from_array(random.point()) * 0.05 * apart;
        }
        // Of one direction, as the sun's; or with an axis kept, which it may be parallel to.
        let bend = Vec3::from_array(random.point()) * size * 0.2 * turn;
        match kind {
            1 => {}
            2 => ray.direction.x += bend.x,
            3 => ray.direction += Vec3::new(0.0, bend.y, bend.z),
            _ => ray.direction += bend,
        }
        match random.below(12) {
            0 => ray.t_max = ray.t_max.min(random.signed().abs() / size),
            1 => ray.t_min = random.signed() / size,
            2 if kind == 5 => ray.direction = Vec3::from_array(random.point()),
            3 if kind == 5 => ray.origin.x = f32::NAN,
            _ => {}
        }
        ray
    });
    pattern.collect()
}

pub(crate) fn agree(tracer: impl Tracer) {
    let mut together = 0;
    for (seed, count, offset, leads) in
        [(31, 7, 0.0, 120), (32, 300, 0.0, 120), (33, 2000, 0.0, 40), (34, 100, 0.75, 120)]
    {
        let mut random = Random(seed);
        let mut items = clutter(count, SPHERES, &mut random);
        if offset != 0.0 {
            items.retain(|item| matches!(item.0, Primitive::Triangle { .. }));
        }
        for item in &mut items {
            if let Primitive::Triangle { vertices, .. } = &mut item.0 {
                *vertices = vertices.map(|v| v + Vec3::splat(offset));
            }
        }
        let leads = rays(&items, leads, &mut random);
        let bundles: Vec<Vec<Ray>> = leads.iter().map(|r| neighbours(r, &mut random)).collect();
        for (bytes, leaf, nodes) in [(1 << 10, 1, 1), (1 << 12, 4, 99), (1 << 14, 3, 999)] {
            let blocks = write(&items, bytes, leaf, nodes);
            let (mut all, mut expected) = (std::vec![], std::vec![]);
            for rays in &bundles {
                let found = compare(tracer, &blocks, rays);
                together += found.iter().filter(|hit| hit.is_some()).count();
                expected.extend(found);
                all.extend_from_slice(rays);
            }
            // Bundle behind bundle, they are a batch: of some rays that go the same way, and others.
            let mut hits = std::vec![None; all.len()];
            let mut resident = Resident(&blocks);
            let (room, source) = (&mut Batch::new(), &mut erased(&mut resident));
            tracer.closest_batch(room, source, &all, &mut hits).unwrap();
            assert_eq!(hits, expected);
        }
    }
    assert!(together > 1000, "too few rays hit anything: {together}");
}

fn compare(tracer: impl Tracer, blocks: &Blocks, rays: &[Ray]) -> Vec<Option<Hit>> {
    let (mut cursor, mut room) = (Cursor::new(), Bundle::new());
    let single =
        |ray| tracer.closest(&mut cursor, &mut erased(&mut Resident(blocks)), ray).unwrap();
    let expected: Vec<Option<Hit>> = rays.iter().map(single).collect();
    let any: Vec<bool> = expected.iter().map(Option::is_some).collect();
    // What was there before must not matter.
    let mut hits: Vec<Option<Hit>> = expected.iter().rev().copied().collect();
    let mut found = std::vec![true; rays.len()];
    tracer.closest_bundle(&mut room, &mut erased(&mut Resident(blocks)), rays, &mut hits).unwrap();
    for ((hit, expected), ray) in hits.iter().zip(&expected).zip(rays) {
        assert_eq!(hit, expected, "{ray:?}");
        let bits = |hit: &Option<Hit>| hit.map(|h| [h.t, h.b1, h.b2].map(f32::to_bits));
        assert_eq!(bits(hit), bits(expected));
    }
    tracer.any_bundle(&mut room, &mut erased(&mut Resident(blocks)), rays, &mut found).unwrap();
    assert_eq!(found, any);
    // All hits, each shown once.
    let mut all: Vec<All> = rays.iter().map(|_| All(std::vec![])).collect();
    tracer.query_bundle(&mut room, &mut erased(&mut Resident(blocks)), rays, &mut all).unwrap();
    for (All(mut found), ray) in all.into_iter().zip(rays) {
        let mut resident = Resident(blocks);
        let resident = &mut erased(&mut resident);
        let (all, mut expected) = shown(|visit| tracer.every(&mut cursor, resident, ray, visit));
        assert_eq!(all, Ok(()));
        for hits in [&mut found, &mut expected] {
            hits.sort_by_key(|hit| (hit.t.to_bits(), hit.material, place(hit)));
        }
        assert_eq!(found, expected, "{ray:?}");
    }
    let part = rays.len() / 2;
    hits.fill(None);
    tracer
        .closest_bundle(&mut room, &mut erased(&mut OneFrame::new(blocks)), rays, &mut hits[..part])
        .unwrap();
    assert_eq!(hits[..part], expected[..part]);
    assert_eq!(hits[part..], std::vec![None; rays.len() - part]);
    // Hits without a ray are left alone.
    found.fill(true);
    tracer
        .any_bundle(&mut room, &mut erased(&mut Resident(blocks)), &rays[..part], &mut found)
        .unwrap();
    assert_eq!(found[..part], any[..part]);
    assert!(found[part..].iter().all(|&found| found));
    // What is visited does not depend on the bundles before either.
    let mut visited = |room: &mut Bundle| {
        room.take_visited();
        hits.fill(None);
        tracer
            .closest_bundle(room, &mut erased(&mut Resident(blocks)), &rays[..part], &mut hits)
            .unwrap();
        room.take_visited()
    };
    assert_eq!(visited(&mut room), visited(&mut Bundle::new()));
    expected
}

/// Where a surface lies, as bits.
fn place(hit: &Hit) -> [[u32; 3]; 3] {
    let corners = match hit.primitive {
        Primitive::Triangle { vertices, .. } => vertices,
        Primitive::Sphere { center, radius, .. } => [center, Vec3::splat(radius), Vec3::ZERO],
    };
    corners.map(|v| v.to_array().map(f32::to_bits))
}

/// The hits that a ray was shown.
struct All(Vec<Hit>);

impl Query for All {
    fn hit(&mut self, _: &mut f32, _: f32, hit: &impl Whole) -> bool {
        self.0.push(hit.whole());
        false
    }
}

/// Has some of the blocks.
struct Part<'a> {
    blocks: &'a Blocks,
    seed: u64,
    of_256: u32,
}

impl BlockSource for Part<'_> {
    type Error = NoBlock;

    fn block(&mut self, block: u32) -> Result<BlockView<'_>, NoBlock> {
        let bytes = self.blocks.get(block).filter(|_| self.has(block));
        bytes.map(BlockView::trusted).ok_or(NoBlock(block))
    }
}

impl Part<'_> {
    fn has(&self, block: u32) -> bool {
        Random(self.seed ^ u64::from(block)).below(256) < self.of_256
    }

    /// The tree as far as it can be come to: without the children that lie in blocks that are not here.
    fn pruned(&self) -> Blocks {
        let mut pruned = self.blocks.clone();
        for block in 0..pruned.count() {
            let view = BlockView::trusted(self.blocks.get(block).unwrap());
            let mut nodes: std::vec::Vec<_> = view.nodes().rev().copied().collect();
            for child in nodes.iter_mut().flat_map(|node| &mut node.child) {
                if let Child::Ref(index) = Child::decode(*child)
                    && !self.has(view.reference(index).unwrap().block)
                {
                    *child = Child::EMPTY;
                }
            }
            let nodes: &[u8] = bytemuck::cast_slice(&nodes);
            let bytes = pruned.get_mut(block);
            let at = bytes.len() - nodes.len();
            bytes[at..].copy_from_slice(nodes);
        }
        pruned
    }
}

/// The signs of a ray and the axis that it goes farthest along, if it may hit something, and boxes decide for it.
fn kind(ray: &Ray) -> Option<(u8, u8)> {
    let ray = PreparedRay::of(ray).filter(|ray| ray.t_min <= ray.t_max)?;
    BoxRay::pad(ray.origin.abs().max_element(), ray.inv.abs().min_element())?;
    Some((ray.signs, ray.axis))
}

/// Where blocks are missing, the rays that need one stop, and go on by their trails; the others have their hits. Those for which any hit will do have it wherever
/// it can be come to, as long as some go together.
pub(crate) fn stop_and_go_on(tracer: impl Tracer, seed: u64, of_256: u32) {
    let mut random = Random(seed);
    let items = clutter(1 + random.below(600) as usize, SPHERES, &mut random);
    let (bytes, leaf, nodes) =
        [(1 << 10, 1, 1), (1 << 10, 1, 99), (1 << 11, 2, 99)][seed as usize % 3];
    let blocks = write(&items, bytes, leaf, nodes);
    let mut source = Part { blocks: &blocks, seed, of_256 };
    let pruned = source.pruned();
    let (mut cursor, mut room) = (Cursor::new(), Bundle::new());
    for lead in rays(&items, 8, &mut random) {
        let mut rays = neighbours(&lead, &mut random);
        rays.truncate(BUNDLE);
        let mut hits = std::vec![None; rays.len()];
        let whole = tracer.closest_bundle(&mut room, &mut erased(&mut source), &rays, &mut hits);
        let mut stopped = 0;
        for ((i, ray), hit) in rays.iter().enumerate().zip(&hits) {
            let expected =
                tracer.closest(&mut cursor, &mut erased(&mut Resident(&blocks)), ray).unwrap();
            let found = match room.stopped(i) {
                None => *hit,
                Some(trail) => {
                    stopped += 1;
                    assert!(source.block(trail.block()).is_err());
                    let mut all = Resident(&blocks);
                    tracer
                        .continue_closest(&mut cursor, &mut erased(&mut all), ray, *hit, &trail)
                        .unwrap()
                }
            };
            assert_eq!(found, expected, "{ray:?}");
        }
        assert_eq!(whole.is_err(), stopped > 0);
        let mut found = std::vec![false; rays.len()];
        let whole = tracer.any_bundle(&mut room, &mut erased(&mut source), &rays, &mut found);
        assert!(whole.is_err() || room.all_stopped() == 0);
        for ((i, ray), found) in rays.iter().enumerate().zip(&found) {
            assert!(!*found || room.stopped(i).is_none(), "{ray:?}");
            let expected =
                tracer.any(&mut cursor, &mut erased(&mut Resident(&blocks)), ray).unwrap();
            let of_kind = kind(ray)
                .map_or(0, |kind_of| rays.iter().filter(|ray| kind(ray) == Some(kind_of)).count());
            if of_kind >= 4 {
                let mut rest = Resident(&pruned);
                let there = tracer.any(&mut cursor, &mut erased(&mut rest), ray).unwrap();
                let there = there && source.has(0);
                assert_eq!(*found, there, "{ray:?}");
            }
            let found = *found
                || room.stopped(i).is_some_and(|trail| {
                    let mut all = Resident(&blocks);
                    tracer.continue_any(&mut cursor, &mut erased(&mut all), ray, &trail).unwrap()
                });
            assert_eq!(found, expected, "{ray:?}");
        }
    }
}
