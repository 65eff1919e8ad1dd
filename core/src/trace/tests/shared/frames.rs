use super::scenes::{Random, clutter, rays};
use super::writer::{bounds, write};
use super::{Grown, check};
use crate::block::format::{Child, Node, order_of};
use crate::block::{BlockView, ExpandedNode, ExpandedTop, SPHERES};
use crate::geometry::{Aabb, PreparedRay};
use crate::trace::{Beam, GROUP, Group, Kind, Lanes, Met, Places, Scalar, Turn};

/// Every own box's interval lies in that of its slot, as the lanes compute it.
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
            for (ray, from_end) in rays.iter().zip([false, true].into_iter().cycle()) {
                let prepared = lanes.ray(ray);
                let frame = lanes.frame(&prepared, view.header());
                let turn = Turn::new(ray.signs, from_end);
                let order = turn.of_node(&node.order);
                let slots = |span, near: &mut _| {
                    let visit = |to: Places<'_>| lanes.visit(&frame, node, turn, span, 0, to);
                    let slot_of = |entry| turn.slot(order, entry >> 16);
                    met(visit, slot_of, near)
                };
                tested += encloses(ray, &view, node, slots);
                let frame = lanes.frame(&prepared, &ExpandedTop::FRAME);
                // Children that are their slots.
                let mut named = ExpandedNode { first: 0, nodes: 0, ..*at };
                for (slot, child) in named.child.iter_mut().enumerate() {
                    if *child != ExpandedTop::EMPTY {
                        *child = slot as u32;
                        named.nodes |= 1 << slot;
                    }
                }
                let slots = |span, near: &mut _| {
                    let visit =
                        |to: Places<'_>| put_down_expanded(lanes, &frame, &named, turn, span, to);
                    met(visit, |entry| entry as usize, near)
                };
                tested += encloses(ray, &view, node, slots);
            }
        }
    }
    assert!(tested > 20_000, "{tested}");
}

/// [`Lanes::visit_expanded`], after which a child alone is put down as well: it need not be, and nobody asks where it is entered.
pub(crate) fn put_down_expanded<L: Lanes>(
    lanes: L,
    frame: &L::Frame,
    node: &ExpandedNode,
    turn: Turn,
    span: (f32, f32),
    Places { mut near, entry }: Places<'_>,
) -> Met {
    let to = Places { near: near.as_deref_mut(), entry: &mut *entry };
    let met = lanes.visit_expanded(&lanes.spread(frame), node, turn, span, to);
    if met.count == 1 {
        entry[7] = met.first;
        if let Some(near) = near {
            near[7] = f32::NEG_INFINITY;
        }
    }
    met
}

/// So do those of groups and of beams.
pub(crate) fn groups_enclose(lanes: impl Lanes) {
    let mut tested = 0;
    for seed in 0..6 {
        let mut random = Random(seed);
        let items = clutter(100, SPHERES, &mut random);
        let mut rays = rays(&items, 400, &mut random);
        rays.sort_by_key(|ray| lanes.kind(ray));
        let blocks = write(&items, 1 << 12, 4, 99);
        let grown = Grown::new(&blocks, 512);
        for rays in rays.chunk_by(|a, b| lanes.kind(a) == lanes.kind(b)) {
            assert!(rays.iter().all(|ray| lanes.kind(ray) == Kind::of(ray)));
            for (rays, members) in rays.chunks(GROUP).map(|rays| (rays, [0, 1, 2, 3, 4, 5, 6, 7])) {
                let kind = Kind::of(&rays[0]);
                let (mut group, mut plain) = (Group::NONE, Group::NONE);
                let filled = lanes.fill(rays, &members[..rays.len()], kind, &mut group);
                assert_eq!(filled, Scalar.fill(rays, &members[..rays.len()], kind, &mut plain));
                let beam = Beam::of(&[group], kind.signs());
                let mut prepared = std::vec![];
                for (lane, ray) in
                    rays.iter().enumerate().filter(|(i, _)| filled.lanes >> i & 1 == 1)
                {
                    let ray = PreparedRay::new(ray);
                    assert_eq!(group.prepared(lane, kind, &rays[lane]), ray);
                    prepared.push((lane, ray));
                }
                for (at, &(block, index)) in grown.nodes.iter().zip(&grown.from) {
                    let view = BlockView::trusted(blocks.get(block).unwrap());
                    let node = view.node(index).unwrap();
                    let (mut near, mut far) = (at.lo, at.hi);
                    for axis in (0..3).filter(|axis| kind.signs() >> axis & 1 == 1) {
                        core::mem::swap(&mut near[axis], &mut far[axis]);
                    }
                    let planes = (near.each_ref(), far.each_ref());
                    for &(lane, ref ray) in &prepared {
                        let slots = |(t_min, t_max): (f32, f32), near: &mut [f32; 8]| {
                            let mut group = group;
                            (group.t_min[lane], group.t_max[lane]) = (t_min, t_max);
                            let mut met = [[0; GROUP]];
                            let list = [[lane as u8, 0, 0, 0, 0, 0, 0, 0]];
                            let any = lanes.boxes(&[group], &list, 1, planes, &mut met);
                            assert_eq!(met, [[any, 0, 0, 0, 0, 0, 0, 0]]);
                            let beam = Beam { t_min, t_max, ..beam };
                            let mut mask = lanes.beam(&beam, planes, near);
                            for slot in 0..8 {
                                let meets = lanes.meets(&group, planes, slot) >> lane & 1;
                                assert!(any >> slot & 1 == meets, "{ray:?} {slot}");
                                mask &= !(u8::from(meets == 0) << slot);
                            }
                            mask.into()
                        };
                        tested += encloses(ray, &view, node, slots);
                    }
                }
            }
        }
    }
    assert!(tested > 5000, "{tested}");
}

/// Lists keep those that meet a slot, in their order.
pub(crate) fn lists_select(lanes: impl Lanes) {
    let mut random = Random(3);
    for _ in 0..2000 {
        let count = random.below(41) as usize;
        let (mut list, mut met, mut to) = ([[0; GROUP]; 5], [[0; GROUP]; 5], [[99; GROUP]; 5]);
        let places = list.as_flattened_mut().iter_mut().zip(met.as_flattened_mut());
        for (i, (id, met)) in places.enumerate().take(count) {
            (*id, *met) = ((i * 7 % 256) as u8, random.below(256) as u8);
        }
        let slot = random.below(8);
        let expected: std::vec::Vec<u8> = (list.as_flattened().iter().zip(met.as_flattened()))
            .filter(|(_, met)| **met >> slot & 1 == 1)
            .map(|(&id, _)| id)
            .collect();
        let selected = lanes.select(&list, &met, count, slot as usize, &mut to);
        assert_eq!(to.as_flattened()[..selected], expected);
        let order = order_of([3, 1, 4, 0, 5, 7, 2, 6]);
        let slots = random.below(256) as u8;
        for signs in 0..8 {
            let turn = Turn::new(signs, false);
            let places = lanes.by_place(turn, order, slots);
            for place in 0..8 {
                assert_eq!(places >> place & 1, slots >> turn.slot(order, place) & 1);
            }
        }
    }
}

/// The mask of the slots that a visit puts down, and where the ray enters them. They come in the order of places.
fn met(
    visit: impl FnOnce(Places<'_>) -> Met,
    slot_of: impl Fn(u32) -> usize,
    near: &mut [f32; 8],
) -> u32 {
    let (mut enters, mut entries) = ([f32::NAN; 8], [0; 8]);
    let met = visit(Places { near: Some(&mut enters), entry: &mut entries });
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
        let Child::Leaf { at, count } = Child::decode(child) else { continue };
        for own in own_boxes(view, at, count) {
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

fn own_boxes(view: &BlockView<'_>, at: u16, count: u16) -> std::vec::Vec<Aabb> {
    let mut boxes = std::vec![];
    for record in view.leaf(at, count) {
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
