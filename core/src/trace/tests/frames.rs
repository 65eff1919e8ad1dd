use super::scenes::{Random, clutter, rays};
use super::writer::{bounds, write};
use super::{Room, check};
use crate::block::format::{Child, Node};
use crate::block::{BlockView, ExpandedTop, SPHERES};
use crate::geometry::{Aabb, PreparedRay};
use crate::trace::{BoxFrame, BoxRay, Lanes, Scalar};

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
        let mut room = Room::new(512);
        for at in room.grow(&blocks).nodes() {
            let view = BlockView::trusted(blocks.get(at.block).unwrap());
            let node = view.node(at.node).unwrap();
            for ray in &rays {
                let prepared = lanes.ray(ray);
                let frame = lanes.frame(&prepared, view.header());
                let slots = |t0, t1, near: &mut _| lanes.slots(&frame, node, t0, t1, near);
                tested += encloses(ray, &view, node, slots);
                let frame = lanes.frame(&prepared, &ExpandedTop::FRAME);
                let slots = |t0, t1, near: &mut _| lanes.expanded_slots(&frame, at, t0, t1, near);
                tested += encloses(ray, &view, node, slots);
            }
        }
    }
    assert!(tested > 20_000, "{tested}");
}

/// Holds the own boxes of a node's leaves against its slots; how many.
fn encloses(
    ray: &PreparedRay,
    view: &BlockView<'_>,
    node: &Node,
    slots: impl Fn(f32, f32, &mut [f32; 8]) -> u32,
) -> usize {
    let mut tested = 0;
    let mut near = [f32::NAN; 8];
    let mask = slots(f32::NEG_INFINITY, f32::INFINITY, &mut near);
    for (slot, &child) in node.child.iter().enumerate() {
        let Child::Leaf { first, count } = Child::decode(child) else { continue };
        for own in own_boxes(view, first, count) {
            let Some(interval) = ray.own_box(&own) else { continue };
            assert!(mask >> slot & 1 == 1, "{ray:?} {own:?}");
            assert!(near[slot] <= interval.enter, "{ray:?} {own:?} {interval:?} {}", near[slot]);
            // It is still found by a ray that ends or begins at the interval's ends.
            for t in [interval.enter, interval.leave] {
                assert!(slots(t, t, &mut [0.0; 8]) >> slot & 1 == 1);
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
