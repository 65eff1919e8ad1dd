//! The primitives of a leaf.

#[cfg(feature = "sphere")]
use glam::Vec3;

use super::group::{Crossings, GROUP, Verdict};
use super::lanes::Lanes;
use super::query::{Query, Whole};
use crate::block::BlockView;
use crate::block::format::{FLAG_NORMALS, RECORD_SPHERES, Record};
use crate::geometry::{Hit, PreparedRay, Primitive};

/// Tests the records of a leaf. `true`: the query ends the traversal.
///
/// `t_max` is the ray's, which is kept apart from it to stay in a register. After calls, which are rare, `renew` makes anew what the traversal has in
/// registers: what is kept over a call is saved before each leaf.
#[inline(always)]
#[expect(clippy::too_many_arguments, reason = "inlined into the traversal, whose state it is")]
pub(super) fn leaf<L: Lanes, Q: Query>(
    lanes: L,
    view: &BlockView<'_>,
    records: &[Record],
    prepared: &L::Ray,
    crossings: &mut Crossings,
    ray: &mut PreparedRay,
    t_max: &mut f32,
    query: &mut Q,
    mut renew: impl FnMut(&PreparedRay),
) -> bool {
    let vertices = view.vertex_numbers();
    for record in records {
        if record.base & RECORD_SPHERES != 0 {
            ray.t_max = *t_max;
            let done = spheres(view, record, ray, query);
            *t_max = ray.t_max;
            if done {
                return true;
            }
            renew(ray);
            continue;
        }
        let Verdict { mut accepted, doubtful } =
            lanes.record(prepared, vertices, record, *t_max, crossings);
        while accepted != 0 {
            let place = accepted.trailing_zeros();
            accepted &= accepted - 1;
            if crossed(view, record, place, (&*crossings, place as usize), t_max, query) {
                return true;
            }
        }
        if doubtful == 0 {
            continue;
        }
        ray.t_max = *t_max;
        let done = lanes.in_doubt(|| triangles(view, record, doubtful, &mut *ray, query));
        *t_max = ray.t_max;
        if done {
            return true;
        }
        renew(ray);
    }
    false
}

/// Tests the triangles in these places by the definition.
#[cfg_attr(feature = "bundles", inline(always))]
#[cfg_attr(not(feature = "bundles"), inline(never))]
pub(super) fn triangles<Q: Query>(
    view: &BlockView<'_>,
    record: &Record,
    mut places: u32,
    ray: &mut PreparedRay,
    query: &mut Q,
) -> bool {
    while places != 0 {
        let place = places.trailing_zeros();
        places &= places - 1;
        if triangle(view, record, place, ray, query) {
            return true;
        }
    }
    false
}

/// Takes the hit of a triangle, in a place of a record, that a lane has found.
#[inline(always)]
pub(super) fn crossed<Q: Query>(
    view: &BlockView<'_>,
    record: &Record,
    place: u32,
    (crossings, lane): (&Crossings, usize),
    t_max: &mut f32,
    query: &mut Q,
) -> bool {
    let at = |row: &[f32; GROUP]| row.get(lane & (GROUP - 1)).copied().unwrap_or(0.0);
    let t = at(&crossings.t);
    let Some(&places) = record.index.get(place as usize) else { return false };
    let index = places.map(|i| usize::from(record.base) + usize::from(i));
    let found = Found { view, record, index, t, b1: at(&crossings.b1), b2: at(&crossings.b2) };
    query.hit(t_max, t, &found)
}

/// The hit of a triangle.
struct Found<'a> {
    view: &'a BlockView<'a>,
    record: &'a Record,
    /// Of its vertices in the block.
    index: [usize; 3],
    t: f32,
    b1: f32,
    b2: f32,
}

impl Whole for Found<'_> {
    // Where it is to stay: a call would leave it elsewhere, to be copied.
    #[inline(always)]
    fn whole(&self) -> Hit {
        let &Self { view, record, index, t, b1, b2 } = self;
        let vertices = index.map(|i| view.vertex(i).unwrap_or_default());
        let primitive = Primitive::Triangle { vertices, normals: normals(view, index) };
        Hit { t, b1, b2, material: record.material, primitive, block: view.number() }
    }
}

/// Tests one triangle by the definition.
#[inline(always)]
pub(super) fn triangle<Q: Query>(
    view: &BlockView<'_>,
    record: &Record,
    place: u32,
    ray: &mut PreparedRay,
    query: &mut Q,
) -> bool {
    let Some(&[a, b, c]) = record.index.get(place as usize) else { return false };
    if a == b && b == c {
        return false;
    }
    // One by one: where code is made small, closures over arrays are calls.
    let base = usize::from(record.base);
    let index = [base + usize::from(a), base + usize::from(b), base + usize::from(c)];
    let [ia, ib, ic] = index;
    let (Some(a), Some(b), Some(c)) = (view.vertex(ia), view.vertex(ib), view.vertex(ic)) else {
        return false;
    };
    let vertices = [a, b, c];
    let Some(hit) = ray.triangle(vertices) else { return false };
    let found = || Hit {
        t: hit.t,
        b1: hit.b1,
        b2: hit.b2,
        material: record.material,
        primitive: Primitive::Triangle { vertices, normals: normals(view, index) },
        block: view.number(),
    };
    query.hit(&mut ray.t_max, hit.t, &found)
}

/// The shading normals of a triangle: none if the block has none, or a vertex has none.
#[inline(always)]
pub(super) fn normals(view: &BlockView<'_>, index: [usize; 3]) -> Option<[u32; 3]> {
    if view.header().flags & FLAG_NORMALS == 0 {
        return None;
    }
    let codes = view.normals();
    let [a, b, c] =
        index.map(|i| codes.get(i).copied().filter(|&n| n != crate::block::octahedral::NONE));
    Some([a?, b?, c?])
}

#[cfg(not(feature = "sphere"))]
pub(super) fn spheres<Q: Query>(
    _: &BlockView<'_>,
    _: &Record,
    _: &mut PreparedRay,
    _: &mut Q,
) -> bool {
    false
}

/// Tests the spheres of a record.
#[cfg(feature = "sphere")]
#[inline(never)]
pub(super) fn spheres<Q: Query>(
    view: &BlockView<'_>,
    record: &Record,
    ray: &mut PreparedRay,
    query: &mut Q,
) -> bool {
    let base = usize::from(record.base & !RECORD_SPHERES);
    for &[a, b, c] in &record.index {
        let vertex = |i: u8| view.vertex(base + usize::from(i));
        let (Some(center), Some(Vec3 { x: radius, y: inward, .. })) = (vertex(a), vertex(b)) else {
            break;
        };
        if a == b && b == c {
            break;
        }
        let Some(t) = ray.sphere(center, radius) else { continue };
        let primitive = Primitive::Sphere { center, radius, inward: inward != 0.0 };
        let (material, block) = (record.material, view.number());
        let hit = || Hit { t, b1: 0.0, b2: 0.0, material, primitive, block };
        if query.hit(&mut ray.t_max, t, &hit) {
            return true;
        }
    }
    false
}
