use std::vec::Vec;

use glam::Vec3;

use crate::block::format::Child;
use crate::block::{BlockSource, BlockView, SPHERES};
use crate::geometry::{Aabb, Hit, PreparedRay, Primitive, Pyramid, Ray};
use crate::scene::{Light, LightKind};
use crate::trace::tests::shared::scenes::{Random, clutter};
use crate::trace::tests::shared::writer::{Blocks, Item, write};
use crate::trace::tests::shared::{Resident, brute, check, hit_of};
use crate::trace::{Clip, ClipEntry};
use bytemuck::Zeroable;

/// It has no block but one.
struct Missing<'a> {
    blocks: &'a Blocks,
    here: Option<u32>,
}

impl BlockSource for Missing<'_> {
    type Error = u32;
    fn block(&mut self, block: u32) -> Result<BlockView<'_>, u32> {
        if self.here != Some(block) {
            return Err(block);
        }
        self.blocks.get(block).map(BlockView::trusted).ok_or(block)
    }
}

/// A bundle of rays and its pyramid.
struct Bundle {
    pyramid: Pyramid,
    rays: Vec<Ray>,
}

fn tile(random: &mut Random) -> Bundle {
    let eye = Vec3::from_array(random.point()) * random.scale(3) * 4.0;
    let axis = (Vec3::from_array(random.point()) - eye).normalize_or(Vec3::X);
    let (u, v) = axis.any_orthonormal_pair();
    let (w, h) = (random.scale(7), random.scale(7));
    let parallel = random.below(4) == 0;
    let corner = |x: f32, y: f32| {
        let aside = u * x * w + v * y * h;
        let (origin, direction) = if parallel { (eye + aside, axis) } else { (eye, axis + aside) };
        Ray { origin, direction, t_min: 0.0, t_max: f32::INFINITY }
    };
    let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(x, y)| corner(x, y));
    let mut rays = corners.to_vec();
    rays.extend((0..60).map(|_| corner(random.signed(), random.signed())));
    Bundle { pyramid: Pyramid::of_tile(&corners), rays }
}

fn shadow(random: &mut Random) -> Bundle {
    let from = Vec3::from_array(random.point());
    let size = random.scale(6);
    let u = Vec3::from_array(random.point()) * size;
    let light = Light {
        kind: LightKind::Parallelogram as u32,
        position: random.point(),
        u: u.into(),
        v: (u.any_orthogonal_vector() * 0.5).into(),
        ..Light::zeroed()
    };
    let [p, u, v] = [light.position, light.u, light.v].map(Vec3::from);
    let spread = if random.below(2) == 0 { 0.0 } else { random.scale(8) };
    let mut origins = Aabb::EMPTY;
    let mut rays = Vec::new();
    for _ in 0..60 {
        let origin = from + Vec3::from_array(random.point()) * spread;
        let end = p + u * random.signed().abs() + v * random.signed().abs();
        origins = origins.with(origin);
        rays.push(Ray { origin, direction: end - origin, t_min: 0.0, t_max: 1.0 });
    }
    Bundle { pyramid: Pyramid::to_light(&origins, &light), rays }
}

fn bundle(random: &mut Random) -> Bundle {
    if random.below(2) == 0 { tile(random) } else { shadow(random) }
}

/// What is taken from the front, with all blocks here, and a window as large as need be.
fn all_at_once(pyramid: &Pyramid, blocks: &Blocks) -> Vec<ClipEntry> {
    let mut window = std::vec![ClipEntry::EMPTY; 100_000];
    let mut clip = Clip::new(*pyramid, nesting(blocks), &mut window).unwrap();
    clip.round(&mut Resident(blocks)).unwrap();
    assert!(clip.is_complete());
    let entries = clip.entries().to_vec();
    let popped: Vec<_> = core::iter::from_fn(|| clip.pop()).collect();
    assert_eq!(entries, popped);
    assert!(clip.is_done());
    entries
}

fn nesting(blocks: &Blocks) -> u16 {
    BlockView::trusted(blocks.get(0).unwrap()).header().nesting
}

fn same_subtree(a: &ClipEntry, b: &ClipEntry) -> bool {
    (a.block, a.node) == (b.block, b.node)
}

/// The primitives of a block below a node, without what lies in other blocks.
fn items_below(view: &BlockView<'_>, node: u16, items: &mut Vec<Item>) {
    for child in view.node(node).unwrap().child {
        match Child::decode(child) {
            Child::Node(node) => items_below(view, node, items),
            Child::Leaf { at, count } => {
                for record in view.leaf(at, count) {
                    for primitive in super::primitives(view, record) {
                        items.push((primitive, record.material));
                    }
                }
            }
            Child::Empty | Child::Ref(_) => {}
        }
    }
}

#[test]
fn every_hit_of_a_bundle_lies_in_the_list() {
    let mut random = Random(77);
    let (mut hits, mut listed, mut blocks_in_all) = (0, 0, 0);
    for _ in 0..12 {
        let items = clutter(400, SPHERES, &mut random);
        let blocks = write(&items, 1 << 10, 2, 99);
        check(&blocks);
        for _ in 0..40 {
            let bundle = bundle(&mut random);
            let entries = all_at_once(&bundle.pyramid, &blocks);
            listed += entries.len();
            blocks_in_all += blocks.count();
            let mut found: Vec<Item> = Vec::new();
            for entry in &entries {
                let view = BlockView::trusted(blocks.get(entry.block).unwrap());
                items_below(&view, entry.node, &mut found);
            }
            for ray in &bundle.rays {
                let expected = brute(&items, ray);
                let prepared = PreparedRay::new(ray);
                let of_list: Vec<Hit> =
                    found.iter().filter_map(|i| hit_of(&prepared, &plain(i))).collect();
                let plain_expected =
                    expected.iter().map(|h| Hit { primitive: plain(&(h.primitive, 0)).0, ..*h });
                for hit in plain_expected {
                    hits += 1;
                    assert!(of_list.contains(&hit), "{ray:?} {hit:?}");
                }
            }
        }
    }
    assert!(hits > 4_000, "{hits}");
    // The list is a small part of the scene.
    assert!(listed * 2 < blocks_in_all as usize, "{listed} of {blocks_in_all}");
}

/// Without what a hit does not depend on, and the list does not tell.
fn plain(item: &Item) -> Item {
    match item.0 {
        Primitive::Triangle { vertices, .. } => {
            (Primitive::Triangle { vertices, normals: None }, item.1)
        }
        sphere @ Primitive::Sphere { .. } => (sphere, item.1),
    }
}

#[test]
fn the_least_window_and_late_blocks_give_the_same_list() {
    let mut random = Random(78);
    let mut deepest = 0;
    for _ in 0..6 {
        let items = clutter(1500, SPHERES, &mut random);
        let blocks = write(&items, 1 << 10, 2, 3);
        deepest = deepest.max(nesting(&blocks));
        for _ in 0..12 {
            let bundle = bundle(&mut random);
            let expected = all_at_once(&bundle.pyramid, &blocks);
            let least = Clip::window_min(nesting(&blocks));
            for size in [least, least + 1, least + 7, 64, 1000] {
                let mut window = std::vec![ClipEntry::EMPTY; size.max(least)];
                let mut clip = Clip::new(bundle.pyramid, nesting(&blocks), &mut window).unwrap();
                let mut taken = Vec::new();
                // One block at a time: of those that wait, now the first and now another.
                while !clip.is_done() {
                    let waiting: Vec<u32> = clip.waiting().map(|e| e.block).collect();
                    assert_eq!(waiting.is_empty(), clip.is_complete());
                    if !waiting.is_empty() {
                        let turn = random.below(3).min(random.below(waiting.len() as u32));
                        let here = Some(waiting[turn as usize]);
                        clip.round(&mut Missing { blocks: &blocks, here }).unwrap();
                    }
                    while let Some(entry) = clip.pop() {
                        taken.push(entry);
                    }
                }
                assert!(
                    taken.len() == expected.len()
                        && taken.iter().zip(&expected).all(|(a, b)| same_subtree(a, b)),
                    "{size}: {taken:?}\n{expected:?}"
                );
            }
        }
    }
    assert!(deepest >= 4, "{deepest}");
}

#[test]
fn a_bundle_that_leaves_the_scene_has_an_empty_list_at_once() {
    let mut random = Random(79);
    let items = clutter(300, SPHERES, &mut random);
    let blocks = write(&items, 1 << 10, 2, 99);
    let light = Light {
        kind: LightKind::Parallelogram as u32,
        position: [3.0, 2.0, 2.0],
        u: [0.5, 0.0, 0.0],
        v: [0.0, 0.5, 0.0],
        ..Light::zeroed()
    };
    let from = Aabb { min: Vec3::splat(2.0), max: Vec3::splat(2.0) };
    let mut window = [ClipEntry::EMPTY; 40];
    let mut clip =
        Clip::new(Pyramid::to_light(&from, &light), nesting(&blocks), &mut window).unwrap();
    assert!(!clip.is_done() && !clip.is_complete());
    clip.round(&mut Resident(&blocks)).unwrap();
    assert!(clip.is_done() && clip.is_complete());
    assert!(clip.pop().is_none());
    assert_eq!((clip.counts().blocks, clip.counts().primitives), (1, 0));
}

#[test]
fn entries_come_front_to_back() {
    // Triangles behind each other along a diagonal, one to a leaf: the order of the children is that of the ray.
    let items: Vec<Item> = (0..200)
        .map(|i| {
            let at = Vec3::splat(i as f32 / 100.0 - 1.0);
            let vertices = [at, at + Vec3::X * 0.002, at + Vec3::Y * 0.002];
            (Primitive::Triangle { vertices, normals: None }, 0)
        })
        .collect();
    let blocks = write(&items, 1 << 10, 1, 2);
    for sign in [1.0, -1.0] {
        let corner = |x: f32, y: f32| Ray {
            origin: Vec3::splat(-2.0 * sign),
            direction: Vec3::splat(sign) + Vec3::new(x, y, 0.0) * 0.1,
            t_min: 0.0,
            t_max: f32::INFINITY,
        };
        let corners = [corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
        let entries = all_at_once(&Pyramid::of_tile(&corners), &blocks);
        let mut at: Vec<f32> = Vec::new();
        for entry in entries {
            let mut items = Vec::new();
            let view = BlockView::trusted(blocks.get(entry.block).unwrap());
            items_below(&view, entry.node, &mut items);
            for item in items {
                if let Primitive::Triangle { vertices, .. } = item.0 {
                    at.push(vertices[0].z * sign);
                }
            }
        }
        // Leaves of a block may stand in any order, and before those of its references.
        let inversions = at.windows(2).filter(|w| w[0] > w[1] + 0.3).count();
        assert!(at.len() == 200 && inversions < 8, "{inversions} {at:?}");
    }
}
