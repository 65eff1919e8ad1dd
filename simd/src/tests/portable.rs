//! Lanes of any machine do what those of AVX2 do, to the bit: hits, and all that is counted.

use std::cell::Cell;

use glam::Vec3;
use kiloray_core::block::format::{BlockHeader, Node, Record, order_of};
use kiloray_core::block::{BlockView, ExpandedNode, ExpandedTop, SPHERES};
use kiloray_core::geometry::{PreparedRay, Ray};
use kiloray_core::trace::{
    Batch, Beam, Bundle, Crossings, Cursor, Filled, GROUP, Group, Kind, Lanes, Met, Places, Quad,
    Row, Tracer, Turn, Verdict,
};
use proptest::prelude::*;
use proptest::test_runner::TestRunner;

use super::shared::frames::put_down_expanded;
use super::shared::scenes::{Random, clutter, no_rays, rays};
use super::shared::writer::{Blocks, write};
use super::shared::{Grown, OneFrame, Resident, Source, Topped, erased};
use crate::{Auto, Avx2, Portable};

/// Any numbers: of a size that matters, of all sizes, and those at the ends.
fn number() -> impl Strategy<Value = f32> {
    let ends = [0.0, -0.0, 1.0, -1.0, f32::INFINITY, f32::MIN_POSITIVE, f32::MAX, 1e-45, -1e-45];
    prop_oneof![
        4 => -1f32..1.0,
        2 => any::<u32>().prop_map(f32::from_bits).prop_filter("a NaN", |x| !x.is_nan()),
        1 => prop::sample::select(ends.to_vec()),
    ]
}

fn vector() -> impl Strategy<Value = Vec3> {
    prop::array::uniform3(number()).prop_map(Vec3::from)
}

fn any_ray() -> impl Strategy<Value = Ray> {
    let t_max = prop_oneof![Just(f32::INFINITY), number()];
    let nan = prop::option::weighted(0.1, 0_usize..8);
    (vector(), vector(), prop_oneof![Just(0.0), number()], t_max, nan).prop_map(
        |(origin, direction, t_min, t_max, nan)| {
            let mut ray = Ray { origin, direction, t_min, t_max };
            match nan {
                Some(6) => ray.t_min = f32::NAN,
                Some(7) => ray.t_max = f32::NAN,
                Some(axis @ 3..) => ray.direction[axis - 3] = f32::NAN,
                Some(axis) => ray.origin[axis] = f32::NAN,
                None => {}
            }
            ray
        },
    )
}

fn bounds() -> impl Strategy<Value = [[u16; 8]; 3]> {
    let bound = prop_oneof![any::<u16>(), Just(0), Just(u16::MAX)];
    prop::array::uniform3(prop::array::uniform8(bound))
}

fn rows() -> impl Strategy<Value = [Row; 3]> {
    prop::array::uniform3(prop::array::uniform8(number()))
}

/// What is put down of a node.
fn put_down(visit: impl FnOnce(Places<'_>) -> Met) -> (Option<u32>, Vec<u32>, Vec<u32>) {
    let (mut near, mut entry) = ([f32::NAN; 8], [0; 8]);
    let met = visit(Places { near: Some(&mut near), entry: &mut entry });
    let from = 8 - met.count as usize;
    let near = near[from..].iter().map(|t| t.to_bits()).collect();
    ((met.count > 0).then_some(met.first), near, entry[from..].to_vec())
}

/// The lines that may come with a child: those of its slot where lanes read ahead, and none for a node, which has none.
fn lines_of<L: Lanes>(node: &ExpandedNode, child: u32) -> Vec<u8> {
    let slots = (0..8).filter(|&slot| node.child[slot] == child);
    let of_slot = |slot: usize| {
        let may_be_none = !L::READS_AHEAD || node.nodes >> slot & 1 == 1;
        [Some(node.lines[slot]).filter(|_| L::READS_AHEAD), Some(0).filter(|_| may_be_none)]
    };
    slots.flat_map(of_slot).flatten().collect()
}

/// What is met of a node by a ray, prepared before and from the start.
fn of_node<L: Lanes>(
    lanes: L,
    ray: &Ray,
    (header, node, expanded): (&BlockHeader, &Node, &ExpandedNode),
    turn: Turn,
    span: (f32, f32),
) -> impl PartialEq + std::fmt::Debug + use<L> {
    let met = |ray: &L::Ray| {
        let frame = lanes.frame(ray, header);
        let stored = put_down(|to| lanes.visit(&frame, node, turn, span, 5 << 24, to));
        let frame = lanes.frame(ray, &ExpandedTop::FRAME);
        let visit = |to: Places<'_>| {
            let met = put_down_expanded(lanes, &frame, expanded, turn, span, to);
            assert!(met.count == 0 || lines_of::<L>(expanded, met.first).contains(&met.lines));
            met
        };
        (stored, put_down(visit))
    };
    let prepared = lanes.prepare(ray, &mut PreparedRay::NONE.clone());
    (met(&lanes.ray(&PreparedRay::new(ray))), prepared.map(|ray| met(&ray)))
}

/// What is accepted, with its numbers.
#[derive(Debug, PartialEq)]
struct Hits {
    accepted: u32,
    doubtful: u32,
    found: Vec<[u32; 3]>,
}

impl Hits {
    fn new(verdict: Verdict, lanes: u32, found: &Crossings) -> Self {
        let accepted = verdict.accepted & lanes;
        let of = |lane: usize| [found.t[lane], found.b1[lane], found.b2[lane]].map(f32::to_bits);
        let found = (0..GROUP).filter(|lane| accepted >> lane & 1 == 1).map(of).collect();
        Self { accepted, doubtful: verdict.doubtful & lanes, found }
    }
}

fn prepared<L: Lanes>(lanes: L, ray: &Ray) -> Option<String> {
    let mut to = PreparedRay::NONE;
    lanes.prepare(ray, &mut to)?;
    Some(format!("{to:?}"))
}

/// All that is done with a group: its rays, what they meet, and what of four triangles they hit.
#[derive(Debug, PartialEq)]
struct Grouped {
    kind: Kind,
    filled: Filled,
    rows: Vec<Vec<u32>>,
    any: u8,
    met: Vec<u8>,
    meets: Vec<u8>,
    beam: Option<u8>,
    enter: [u32; 8],
    hits: Vec<Hits>,
}

fn of_group<L: Lanes>(
    lanes: L,
    rays: &[Ray],
    planes: ([&Row; 3], [&Row; 3]),
    quad: &Quad,
) -> Grouped {
    let kind = lanes.kind(&rays[0]);
    let members: Vec<u16> = (0..rays.len() as u16).collect();
    let mut group = Group {
        inv: [[1.0; 8]; 3],
        near: [[0.0; 8]; 3],
        far: [[0.0; 8]; 3],
        t_min: [f32::INFINITY; 8],
        t_max: [f32::NEG_INFINITY; 8],
        origin: [[0.0; 8]; 3],
        sheared: [[0.0; 8]; 3],
        shear: [[0.0; 8]; 3],
    };
    let filled = lanes.fill(rays, &members, kind, &mut group);
    let live = u32::from(filled.lanes);
    let list: Vec<u8> = (0..8).filter(|lane| live >> lane & 1 == 1).collect();
    let mut octet = [[0; GROUP]];
    octet[0][..list.len()].copy_from_slice(&list);
    let mut met = [[0; GROUP]];
    let any = lanes.boxes(&[group], &octet, list.len(), planes, &mut met);
    let meets: Vec<u8> = (0..8).map(|slot| lanes.meets(&group, planes, slot)).collect();
    let mut enter = [0.0; 8];
    // Of no ray there is no beam.
    let beam =
        (live != 0).then(|| lanes.beam(&Beam::of(&[group], kind.signs()), planes, &mut enter));
    let mut found = Crossings::NONE;
    let mut hits = vec![];
    for place in 0..4 {
        let verdict = lanes.triangle(quad, place, &group, kind, &mut found);
        hits.push(Hits::new(verdict, live, &found));
    }
    for &lane in &list {
        let verdict = lanes.quad_of(quad, &group, lane.into(), kind, &mut found);
        hits.push(Hits::new(verdict, 0b1111, &found));
    }
    let bits = |row: &Row| list.iter().map(|&lane| row[usize::from(lane)].to_bits()).collect();
    let rows = [group.inv, group.near, group.far, group.origin, group.sheared, group.shear];
    let ends = [group.t_min, group.t_max];
    Grouped {
        kind,
        filled,
        rows: rows.as_flattened().iter().chain(&ends).map(bits).collect(),
        any,
        met: met[0][..list.len()].to_vec(),
        meets,
        beam,
        // Which zero it is nobody asks.
        enter: enter.map(|t| (t + 0.0).to_bits()),
        hits,
    }
}

fn decoded<L: Lanes>(
    lanes: L,
    blocks: &Blocks,
    block: u32,
    ray: &Ray,
) -> impl PartialEq + std::fmt::Debug + use<L> {
    let view = BlockView::trusted(blocks.get(block).unwrap());
    let (vertices, mut prepared) = (view.vertex_numbers(), PreparedRay::NONE);
    let Some(ray) = lanes.prepare(ray, &mut prepared) else { return vec![] };
    let of = |record: &Record| {
        let mut quad = Quad { v01: [[0.0; 8]; 3], v2: [[0.0; 4]; 3], used: 0 };
        let sound = lanes.quad(vertices, record, &mut quad);
        let mut found = Crossings::NONE;
        let verdict = lanes.record(&ray, vertices, record, prepared.t_max, &mut found);
        let quad = sound.then(|| format!("{quad:?}"));
        (quad, Hits::new(verdict, 0b1111, &found))
    };
    // Also as they are not: with vertices that do not exist.
    let broken = view.records().iter().map(|record| Record { base: record.base + 9, ..*record });
    view.records().iter().copied().chain(broken).map(|r| of(&r)).collect::<Vec<_>>()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn nodes_are_met_alike(
        ray in any_ray(),
        (lo, hi) in (bounds(), bounds()),
        (low, high) in (rows(), rows()),
        origin in prop::array::uniform3(-1f32..1.0),
        scale in prop::array::uniform3(-80_i32..2),
        child: [u16; 8],
        (first, known) in any::<(u16, u8)>(),
        (signs, from_end) in (0_u8..8, any::<bool>()),
        span in (prop_oneof![Just(0.0), 0f32..2.0], number()),
    ) {
        let Some(wide) = Avx2::detect() else { return Ok(()) };
        prop_assert_eq!(prepared(Portable, &ray), prepared(wide, &ray));
        prop_assert_eq!(Portable.kind(&ray), wide.kind(&ray));
        let header = BlockHeader { origin, scale: scale.map(|e| 2f32.powi(e)), ..ExpandedTop::FRAME };
        let order = [order_of([0, 1, 2, 3, 4, 5, 6, 7]), order_of([3, 1, 7, 0, 2, 6, 5, 4])];
        let order = [order[0], order[1], order[1], order[0]];
        let node = Node { lo, hi, child, order };
        let expanded = ExpandedNode {
            lo: low,
            hi: high,
            child: std::array::from_fn(|slot| match known >> slot & 1 {
                1 => u32::from(first) + slot as u32,
                _ => child[slot].into(),
            }),
            order,
            first: first.into(),
            nodes: known.into(),
            lines: [1, 2, 3, 4, 5, 6, 7, 8],
        };
        let (turn, nodes) = (Turn::new(signs, from_end), (&header, &node, &expanded));
        prop_assert_eq!(
            format!("{:?}", of_node(Portable, &ray, nodes, turn, span)),
            format!("{:?}", of_node(wide, &ray, nodes, turn, span))
        );
    }
}

/// A ray and others of its kind, planes in the order in which they meet them or not, and four triangles.
fn groups() -> impl Strategy<Value = (Vec<Ray>, [Row; 3], [Row; 3], Quad)> {
    let others = prop::collection::vec((vector(), vector(), number(), number()), 0..8);
    let corners = prop::collection::vec(prop::array::uniform3(-1f32..1.0), 12);
    let sizes = (0_u8..4, 0_i32..40);
    (any_ray(), others, (rows(), rows()), corners, sizes).prop_map(
        |(lead, others, (low, high), corners, (relation, size))| {
            let kind = Portable.kind(&lead);
            let size = 2f32.powi(-size);
            let near =
                |v: Vec3| Vec3::from(v.to_array().map(|x| if x.abs() < 2.0 { x } else { 0.5 }));
            let others = others.iter().map(|&(o, d, t_min, t_max)| match relation {
                0 => Ray { origin: o, direction: d, t_min, t_max },
                1 => Ray { origin: lead.origin + near(o) * size, ..lead },
                _ => Ray { direction: lead.direction + near(d) * size, t_max, ..lead },
            });
            let others = others.filter(|ray| Portable.kind(ray) == kind);
            let rays = std::iter::once(lead).chain(others).collect();
            let mut quad = Quad { v01: [[0.0; 8]; 3], v2: [[0.0; 4]; 3], used: 0b1111 };
            let (mut first, mut last) = (low, high);
            let finite = |x: f32| if x.is_finite() { x } else { 1.0 };
            for axis in 0..3 {
                quad.v01[axis] = std::array::from_fn(|at| corners[at][axis]);
                quad.v2[axis] = std::array::from_fn(|at| corners[8 + at][axis]);
                // A sliver, one that has the ray's origin for a corner, and one that the ray goes through.
                quad.v2[axis][1] = quad.v01[axis][1] + size;
                quad.v01[axis][2] = near(lead.origin)[axis];
                let through = near(lead.origin + lead.direction)[axis];
                quad.v2[axis][3] = 3.0 * through - quad.v01[axis][3] - quad.v01[axis][7];
                for slot in 0..8 {
                    let [a, b] = [low[axis][slot], high[axis][slot]].map(finite);
                    let swap = slot < 6 && (a > b) != (kind.signs() >> axis & 1 == 1);
                    let (a, b) = if swap { (b, a) } else { (a, b) };
                    (first[axis][slot], last[axis][slot]) = (a, b);
                }
            }
            (rays, first, last, quad)
        },
    )
}

#[test]
fn groups_meet_and_hit_alike() {
    let Some(wide) = Avx2::detect() else { return };
    let (met, hit) = (Cell::new(0), Cell::new(0));
    let mut runner = TestRunner::new(ProptestConfig::with_cases(20_000));
    let tested = runner.run(&groups(), |(rays, near, far, quad)| {
        let planes = (near.each_ref(), far.each_ref());
        let of_wide = of_group(wide, &rays, planes, &quad);
        prop_assert_eq!(&of_group(Portable, &rays, planes, &quad), &of_wide);
        met.set(met.get() + of_wide.met.iter().map(|met| met.count_ones()).sum::<u32>());
        hit.set(
            hit.get() + of_wide.hits.iter().map(|hits| hits.accepted.count_ones()).sum::<u32>(),
        );
        Ok(())
    });
    tested.unwrap();
    assert!(met.get() > 5000 && hit.get() > 5000, "{met:?} {hit:?}");
}

/// Every way of asking, with the hits that come of it and what was visited.
fn traced(tracer: Auto, blocks: &Blocks, grown: &Grown, rays: &[Ray]) -> Vec<String> {
    let mut all = vec![];
    let mut cursor = Cursor::new();
    for ray in rays {
        let (mut resident, mut top) = (Resident(blocks), Topped(Resident(blocks), grown.top()));
        let [resident, top] = &mut [erased(&mut resident), erased(&mut top)];
        let hits = (
            tracer.closest(&mut cursor, resident, ray),
            tracer.closest(&mut cursor, top, ray),
            tracer.closest(&mut cursor, &mut erased(&mut OneFrame::new(blocks)), ray),
            tracer.any(&mut cursor, resident, ray),
        );
        all.push(format!("{hits:?} {:?}", cursor.take_visited()));
    }
    bundled(tracer, &mut Resident(blocks), rays, &mut all);
    bundled(tracer, &mut erased(&mut OneFrame::new(blocks)), rays, &mut all);
    bundled(tracer, &mut Topped(Resident(blocks), grown.top()), rays, &mut all);
    all
}

fn bundled(tracer: Auto, mut source: Source<'_>, rays: &[Ray], all: &mut Vec<String>) {
    let source = &mut source;
    let (mut room, mut batch) = (Bundle::new(), Batch::new());
    for rays in rays.chunks(64) {
        let (mut hits, mut found) = (vec![None; rays.len()], vec![false; rays.len()]);
        assert!(tracer.closest_bundle(&mut room, source, rays, &mut hits).is_ok());
        assert!(tracer.any_bundle(&mut room, source, rays, &mut found).is_ok());
        all.push(format!("{hits:?} {found:?} {:?}", room.take_visited()));
        assert!(tracer.closest_batch(&mut batch, source, rays, &mut hits).is_ok());
        all.push(format!("{hits:?}"));
    }
}

#[test]
fn traversals_visit_alike() {
    let Some(wide) = Avx2::detect() else { return };
    for (seed, count) in [(1, 8), (2, 60), (3, 400), (4, 2000)] {
        let mut random = Random(seed);
        let items = clutter(count, SPHERES, &mut random);
        let leads = rays(&items, 80, &mut random);
        // Of each some that go much the same way.
        let mut all = no_rays();
        for (lead, i) in leads.iter().zip(0_u32..) {
            let apart = random.scale(20);
            for _ in 0..=(i % 3) * 5 {
                let bend = Vec3::from(random.point()) * apart * lead.direction.length();
                all.push(Ray { direction: lead.direction + bend, ..*lead });
            }
        }
        let far = Ray { origin: Vec3::splat(1e30), direction: Vec3::NEG_ONE, ..leads[0] };
        all.push(Ray { t_min: 0.0, t_max: f32::INFINITY, ..far });
        for (bytes, leaf, nodes) in [(1 << 10, 1, 1), (1 << 12, 4, 99), (1 << 14, 3, 999)] {
            let blocks = write(&items, bytes, leaf, nodes);
            let grown = Grown::new(&blocks, 100);
            let expected = Auto::all().map(|tracer| traced(tracer, &blocks, &grown, &all));
            let expected: Vec<_> = expected.collect();
            for other in &expected[1..] {
                for (other, first) in other.iter().zip(&expected[0]) {
                    assert_eq!(other, first);
                }
            }
            for ray in leads.iter().take(20) {
                for block in 0..blocks.count().min(30) {
                    assert_eq!(
                        format!("{:?}", decoded(Portable, &blocks, block, ray)),
                        format!("{:?}", decoded(wide, &blocks, block, ray))
                    );
                }
            }
        }
    }
}
