use super::scenes::{Random, clutter, rays};
use super::writer::{bounds, write};
use super::{Grown, check};
use crate::block::format::{Child, Node};
use crate::block::{BlockView, ExpandedTop, SPHERES};
use crate::geometry::{Aabb, PreparedRay};
use crate::trace::{BoxFrame, BoxRay, Lanes, Met, Places, Scalar, Turn};

/// Every own box's interval lies in that of its slot, as the lanes compute it.
#[test]
fn slots_enclose_the_intervals_of_own_boxes() {
    enclose(Scalar);
}

pub(crate) fn enclose(lanes: impl Lanes) {
    let mut tested = 0;
    for seed in 0..6 {
        let mut random = Random(seed);
        let items = clutter(200, SPHERES, &mut random);
        let rays = rays(&items, 300, &mut random).into_iter().map(|ray| PreparedRay::new(&ray));
        let rays: std::vec::Vec<_> = rays.collect();
        let blocks = write(&items, 1 << 12, 4, 99);
        check(&blocks);
        let grown = Grown::new(&blocks, 512);
        for (at, &(block, index)) in grown.nodes.iter().zip(&grown.from) {
            let view = BlockView::trusted(blocks.get(block).unwrap());
            let node = view.node(index).unwrap();
            for ray in &rays {
                let prepared = lanes.ray(ray);
                let frame = lanes.frame(&prepared, view.header());
                let turn = Turn::of(ray);
                let order = turn.of_node(&node.order);
                let slots = |span, near: &mut _| {
                    let visit = |to: Places<'_>| lanes.visit(&frame, node, turn, span, 0, to);
                    let slot_of = |entry| turn.slot(order, entry >> 16);
                    met(visit, slot_of, near)
                };
                tested += encloses(ray, &view, node, slots);
                let frame = lanes.frame(&prepared, &ExpandedTop::FRAME);
                // Children that are their slots.
                let mut named = *at;
                for (slot, child) in named.child.iter_mut().enumerate() {
                    if *child != ExpandedTop::EMPTY {
                        *child = slot as u32;
                    }
                }
                let slots = |span, near: &mut _| {
                    let visit =
                        |to: Places<'_>| lanes.visit_expanded(&frame, &named, turn, span, to);
                    met(visit, |entry| entry as usize, near)
                };
                tested += encloses(ray, &view, node, slots);
            }
        }
    }
    assert!(tested > 20_000, "{tested}");
}

/// The mask of the slots that a visit puts down, and where the ray enters them. They come in the order of places.
fn met(
    visit: impl FnOnce(Places<'_>) -> Met,
    slot_of: impl Fn(u32) -> usize,
    near: &mut [f32; 8],
) -> u32 {
    let (mut enters, mut entries) = ([f32::NAN; 8], [0; 8]);
    let met = visit(Places { near: &mut enters, entry: &mut entries });
    let from = 8 - met.count as usize;
    assert!(met.count == 0 || met.first == entries[from]);
    let mut mask = 0_u32;
    for (&entry, &enter) in entries[from..].iter().zip(&enters[from..]) {
        near[slot_of(entry)] = enter;
        mask |= 1 << slot_of(entry);
    }
    assert_eq!(mask.count_ones(), met.count, "a slot twice");
    mask
}

/// Holds the own boxes of a node's leaves against its slots; how many.
fn encloses(
    ray: &PreparedRay,
    view: &BlockView<'_>,
    node: &Node,
    slots: impl Fn((f32, f32), &mut [f32; 8]) -> u32,
) -> usize {
    let mut tested = 0;
    let mut near = [f32::NAN; 8];
    let mask = slots((f32::NEG_INFINITY, f32::INFINITY), &mut near);
    for (slot, &child) in node.child.iter().enumerate() {
        let Child::Leaf { first, count } = Child::decode(child) else { continue };
        for own in own_boxes(view, first, count) {
            let Some(interval) = ray.own_box(&own) else { continue };
            assert!(mask >> slot & 1 == 1, "{ray:?} {own:?}");
            assert!(near[slot] <= interval.enter, "{ray:?} {own:?} {interval:?} {}", near[slot]);
            // It is still found by a ray that ends or begins at the interval's ends.
            for t in [interval.enter, interval.leave] {
                assert!(slots((t, t), &mut [0.0; 8]) >> slot & 1 == 1);
            }
            tested += 1;
        }
    }
    tested
}

fn own_boxes(view: &BlockView<'_>, first: u16, count: u16) -> std::vec::Vec<Aabb> {
    let mut boxes = std::vec![];
    for record in &view.records()[usize::from(first)..usize::from(first + count)] {
        if record.base & crate::block::format::RECORD_SPHERES != 0 {
            continue;
        }
        for &[a, b, c] in record.index.iter().filter(|[a, b, c]| a != b || b != c) {
            let v =
                [a, b, c].map(|i| view.vertex(usize::from(record.base) + usize::from(i)).unwrap());
            boxes.push(bounds(&super::writer::triangle(
                v[0].to_array(),
                v[1].to_array(),
                v[2].to_array(),
                0,
            )));
        }
    }
    boxes
}

#[test]
fn no_box_decides_anything_for_a_wild_ray() {
    let mut random = Random(5);
    let items = clutter(20, false, &mut random);
    let blocks = write(&items, 1 << 12, 4, 99);
    let mut header = *BlockView::trusted(blocks.get(0).unwrap()).header();
    header.scale = [2.0_f32.powi(-80); 3];
    let ray = crate::geometry::Ray {
        origin: glam::Vec3::splat(1e30),
        direction: glam::Vec3::new(1e-20, 1e-20, -1e-20),
        t_min: 0.0,
        t_max: f32::INFINITY,
    };
    let ray = BoxRay::new(&PreparedRay::new(&ray));
    let frame = BoxFrame::new(&ray, &header);
    assert_eq!((frame.near, frame.far), ([f32::NEG_INFINITY; 3], [f32::INFINITY; 3]));
    assert!(frame.inv.iter().all(|i| i.abs() == header.scale[0]));
}
