//! Eight boxes, or four triangles, at a time on any machine: arrays, of which the compiler makes vectors where it can.
//!
//! All that decides what is visited, in which order, and what a ray is in doubt about, is that of [`Avx2`](crate::Avx2) to the bit: what is fused there is fused here,
//! numbers are compared as whole numbers where they are there, and lights have as many lanes. So nodes do the same work on any machine.

use kiloray_core::block::format::{BlockHeader, Node, Record};
use kiloray_core::block::{ExpandedNode, Vertices};
use kiloray_core::geometry::{self, PreparedRay};
use kiloray_core::real::LANES;
use kiloray_core::trace::{
    BoxFrame, BoxRay, Crossings, GROUP, Group, Kind, Lanes, Met, Octet, Places, Quad, Row, Turn,
    Verdict,
};

mod boxes;
mod fused;
mod real;
mod triangles;

pub use fused::Quickest;
use real::Each;

/// Lanes of any machine.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Portable;

/// A ray, for frames and for triangles.
#[derive(Debug, Clone, Copy)]
pub struct Ray {
    boxes: BoxRay,
    prepared: PreparedRay,
}

/// A ray in the frame of a block.
#[derive(Debug, Clone, Copy)]
pub struct Frame {
    of: BoxFrame,
    /// [`PreparedRay::signs`].
    signs: u8,
}

/// In the order in which a ray with these signs meets them.
#[inline(always)]
fn sides<T: Copy>(lo: [T; 3], hi: [T; 3], signs: u8) -> ([T; 3], [T; 3]) {
    let ([lx, ly, lz], [hx, hy, hz]) = (lo, hi);
    let axis = |axis: u8, lo, hi| if signs >> axis & 1 == 0 { (lo, hi) } else { (hi, lo) };
    let ((nx, fx), (ny, fy), (nz, fz)) = (axis(0, lx, hx), axis(1, ly, hy), axis(2, lz, hz));
    ([nx, ny, nz], [fx, fy, fz])
}

// What is more than some instructions is a function: inlined, it would be compiled again with each traversal, for machines that hardly anyone has.
impl Lanes for Portable {
    type Frame = Frame;
    type Spread = Frame;
    type Ray = Ray;
    type Real = Each<f32>;

    #[inline(always)]
    fn read(self, row: &[f32; LANES], _: usize) -> Each<f32> {
        Each(*row)
    }

    #[inline(always)]
    fn read_whole(self, row: &[u32; LANES], _: usize) -> Each<u32> {
        Each(*row)
    }

    #[inline(always)]
    fn count_from(self, first: u32) -> Each<u32> {
        Each(boxes::each(|lane| first.wrapping_add(lane as u32)))
    }

    #[inline(always)]
    fn ray(self, ray: &PreparedRay) -> Ray {
        Ray { boxes: BoxRay::new(ray), prepared: *ray }
    }

    #[inline(always)]
    fn frame(self, ray: &Ray, header: &BlockHeader) -> Frame {
        Frame { of: BoxFrame::new(&ray.boxes, header), signs: ray.prepared.signs }
    }

    #[inline(always)]
    fn spread(self, frame: &Frame) -> Frame {
        *frame
    }

    fn visit(
        self,
        Frame { of, signs }: &Frame,
        node: &Node,
        turn: Turn,
        span: (f32, f32),
        tag: u32,
        to: Places<'_>,
    ) -> Met {
        let (near, far) = sides(node.lo.each_ref(), node.hi.each_ref(), *signs);
        let row = |bounds: &[u16; 8]| boxes::each(|slot| f32::from(bounds[slot]));
        let rows = |[x, y, z]: [&[u16; 8]; 3]| [row(x), row(y), row(z)];
        let hits = boxes::of_ray(of, (rows(near).each_ref(), rows(far).each_ref()), span);
        hits.put_down(turn, turn.of_node(&node.order), to, |slot, place| {
            u32::from(node.child[slot]) | place << 16 | tag
        })
    }

    fn visit_expanded(
        self,
        Frame { of, signs }: &Frame,
        node: &ExpandedNode,
        turn: Turn,
        span: (f32, f32),
        to: Places<'_>,
    ) -> Met {
        let planes = sides(node.lo.each_ref(), node.hi.each_ref(), *signs);
        let hits = boxes::of_ray(of, planes, span);
        hits.put_down(turn, turn.of_node(&node.order), to, |slot, _| node.child[slot])
    }

    fn record(
        self,
        Ray { prepared, .. }: &Ray,
        vertices: Vertices<'_>,
        record: &Record,
        t_max: f32,
        crossings: &mut Crossings,
    ) -> Verdict {
        let mut quad = Quad { v01: [[0.0; 8]; 3], v2: [[0.0; 4]; 3], used: 0 };
        if !triangles::decode(vertices, record, &mut quad) {
            return Verdict { accepted: 0, doubtful: 0b1111 };
        }
        let ray = PreparedRay { t_max, ..*prepared };
        triangles::of_ray(&quad, &ray, crossings)
    }

    const TOGETHER: usize = 3;

    #[inline(always)]
    fn kind(self, ray: &geometry::Ray) -> Kind {
        let [x, y, z] = ray.direction.abs().to_array();
        // The least axis among equals; the last, where a NaN leaves none.
        let axis = match (x >= y && x >= z, y >= z && y >= x) {
            (true, _) => 0,
            (_, true) => 1,
            _ => 2,
        };
        Kind::new(Kind::of(ray).signs(), axis)
    }

    fn boxes(
        self,
        groups: &[Group],
        list: &[Octet],
        count: usize,
        planes: ([&Row; 3], [&Row; 3]),
        met: &mut [Octet],
    ) -> u8 {
        let mut all = 0;
        let places = met.as_flattened_mut().iter_mut();
        for (&id, met) in list.as_flattened().iter().take(count).zip(places) {
            let (group, lane) = (usize::from(id) / GROUP, usize::from(id) % GROUP);
            *met = groups.get(group).map_or(0, |group| {
                let of = |rows: &[Row; 3]| rows.each_ref().map(|row| row[lane]);
                let frame =
                    BoxFrame { inv: of(&group.inv), near: of(&group.near), far: of(&group.far) };
                boxes::of_ray(&frame, planes, (group.t_min[lane], group.t_max[lane])).mask()
            });
            all |= *met;
        }
        all
    }

    fn quad(self, vertices: Vertices<'_>, record: &Record, quad: &mut Quad) -> bool {
        triangles::decode(vertices, record, quad)
    }

    fn quad_of(
        self,
        quad: &Quad,
        group: &Group,
        lane: usize,
        kind: Kind,
        to: &mut Crossings,
    ) -> Verdict {
        triangles::of_ray(quad, &triangles::in_lane(group, lane & (GROUP - 1), kind), to)
    }

    fn triangle(
        self,
        quad: &Quad,
        place: usize,
        group: &Group,
        kind: Kind,
        to: &mut Crossings,
    ) -> Verdict {
        triangles::of_group(quad, place & 3, group, kind, to)
    }

    fn meets(self, group: &Group, (near, far): ([&Row; 3], [&Row; 3]), slot: usize) -> u8 {
        let at = |rows: [&Row; 3]| rows.map(|row| row[slot & 7]);
        boxes::of_group(group, (at(near), at(far))).mask()
    }
}
