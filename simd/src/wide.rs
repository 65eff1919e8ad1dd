//! Eight boxes, or four triangles, at a time: AVX2, and AVX-512 on vectors of the same length.
//!
//! Both are one set of kernels. They differ in how children are [put down](put_down), and in what the compiler makes of the same
//! instructions with twice the registers. (Vectors of 64 bytes were tried for boxes and for triangles: on processors that join two
//! units for them, all other vector work waits, and a ray takes a fifth longer.)

#[allow(clippy::wildcard_imports, reason = "a kernel names a hundred instructions")]
use core::arch::x86_64::*;
use core::fmt::Debug;
use core::marker::PhantomData;
use core::ops::Range;

use kiloray_core::block::format::{BlockHeader, Node, Record};
use kiloray_core::block::{BlockView, ExpandedNode, Vertices};
use kiloray_core::geometry::{self, PreparedRay};
use kiloray_core::real::{LANES, Part};
use kiloray_core::trace::{
    Beam, Crossings, Filled, Group, Kind, Lanes, Met, Octet, Places, Quad, Row, Turn, Verdict,
};

mod boxes;
mod bundle;
mod double;
mod frame;
mod put_down;
mod real;
mod record;

use frame::{Frame, Ray, Spread};
use put_down::{ByCompression, ByTable, Children, PutDown};
use real::{Eight, Whole};

/// Lanes of AVX2 and FMA. A value of it proves that the machine has them, and what `P` takes.
#[derive(Debug, Clone, Copy)]
pub struct Wide<P>(PhantomData<P>);

/// On any machine with AVX2.
pub type Avx2 = Wide<ByTable>;
/// On one with AVX-512 as well.
pub type Avx512 = Wide<ByCompression>;

impl<P: PutDown> Wide<P> {
    /// The lanes, if the machine has AVX2, FMA, BMI1, BMI2, LZCNT and POPCNT, and what `P` takes.
    #[must_use]
    pub fn detect() -> Option<Self> {
        let found = std::is_x86_feature_detected!("avx2")
            && std::is_x86_feature_detected!("fma")
            && std::is_x86_feature_detected!("bmi1")
            && std::is_x86_feature_detected!("bmi2")
            && std::is_x86_feature_detected!("lzcnt")
            && std::is_x86_feature_detected!("popcnt")
            && P::is_possible();
        found.then_some(Self(PhantomData))
    }
}

/// The same in memory, of which the compiler does not know that. It would take bytes one by one out of a register, or spread numbers over
/// nine of them on the way into a block where two nodes are visited, and keep them in memory for want of registers: loads, and loads that
/// spread a number, cost no more than any other.
#[inline(always)]
fn in_place<T>(value: &T) -> &T {
    let mut place = core::ptr::from_ref(value);
    // SAFETY: it does nothing.
    unsafe {
        core::arch::asm!("/* {0} */", inout(reg) place, options(nostack, preserves_flags, readonly));
    }
    // SAFETY: the reference that came in.
    unsafe { &*place }
}

/// Has lines read, counted from where something begins.
#[inline(always)]
fn fetch<T>(from: &T, lines: Range<usize>) {
    let begin = core::ptr::from_ref(from).cast::<[i8; ExpandedNode::LINE_BYTES]>();
    for line in lines {
        // SAFETY: each x86-64 has SSE, and may be asked for any address: what cannot be read is not.
        unsafe { _mm_prefetch::<_MM_HINT_T0>(begin.wrapping_add(line).cast()) };
    }
}

impl<P: PutDown> Lanes for Wide<P> {
    type Frame = Frame;
    type Spread = Spread;
    type Ray = Ray;
    type Real = Eight;

    #[inline(always)]
    fn read(self, row: &[f32; LANES], _: usize) -> Eight {
        // SAFETY: a value of Wide exists, so the machine has AVX2.
        unsafe { Eight::read(row) }
    }

    #[inline(always)]
    fn read_whole(self, row: &[u32; LANES], _: usize) -> Whole {
        // SAFETY: as above.
        unsafe { Whole::read(row) }
    }

    #[inline(always)]
    fn count_from(self, first: u32) -> Whole {
        // SAFETY: a value of Wide exists, so the machine has AVX2.
        unsafe { Whole::count_from(first) }
    }

    #[inline(always)]
    fn ray(self, ray: &PreparedRay) -> Ray {
        // SAFETY: a value of Wide exists, so the machine has AVX2.
        unsafe { Ray::of(ray) }
    }

    #[inline(always)]
    fn prepare(self, ray: &geometry::Ray, to: &mut PreparedRay) -> Option<Ray> {
        // SAFETY: as above.
        unsafe { frame::prepare(ray, to) }
    }

    #[inline(always)]
    fn frame(self, ray: &Ray, header: &BlockHeader) -> Frame {
        // SAFETY: as above.
        unsafe { Frame::new(ray, header) }
    }

    #[inline(always)]
    fn spread(self, frame: &Frame) -> Spread {
        // Out of memory, where they are: of what is in registers the compiler would spread each number by three instructions.
        // SAFETY: as above.
        unsafe { Spread::of(in_place(frame)) }
    }

    const READS_AHEAD: bool = true;

    #[inline(always)]
    fn fetch<T>(self, what: &T) {
        fetch(what, 0..size_of::<T>().div_ceil(ExpandedNode::LINE_BYTES));
    }

    #[inline(always)]
    fn fetch_lines<const COUNT: usize>(self, view: &BlockView<'_>, from: usize) {
        fetch(view.header(), from..from + COUNT);
    }

    // A call keeps no wide register.
    #[inline(always)]
    fn renew(self, frame: &mut Frame, ray: &PreparedRay, header: &BlockHeader) {
        *frame = self.frame(&self.ray(ray), header);
    }

    #[inline(always)]
    fn visit(
        self,
        frame: &Frame,
        node: &Node,
        turn: Turn,
        span: (f32, f32),
        tag: u32,
        to: Places<'_>,
    ) -> Met {
        // SAFETY: a value of Wide exists, so the machine has AVX2, FMA and what `P` takes; the load is of eight u16.
        unsafe {
            let hits = boxes::stored(frame, node, span);
            let children = Children::Stored(_mm_loadu_si128(node.child.as_ptr().cast()));
            let first = |slot: usize| (u32::from(node.child[slot & 7]), 0);
            P::put_down(&hits, turn, turn.of_node(&node.order), children, first, Some(tag), to)
        }
    }

    #[inline(always)]
    fn visit_expanded(
        self,
        frame: &Spread,
        node: &ExpandedNode,
        turn: Turn,
        span: (f32, f32),
        to: Places<'_>,
    ) -> Met {
        // SAFETY: as above; the load is of eight u32, aligned as the node is.
        unsafe {
            let hits = boxes::expanded(frame, node, span);
            let children = _mm256_load_si256(node.child.as_ptr().cast());
            let children = Children::Expanded(children, &node.lines);
            let first = |slot: usize| {
                // A branch, which in place it stays: the next node need not wait for a child to be read.
                if node.nodes >> (slot & 7) & 1 == 1 {
                    (node.first.wrapping_add(slot as u32), 0)
                } else {
                    (in_place(node).child[slot & 7], node.lines[slot & 7])
                }
            };
            P::put_down(&hits, turn, turn.of_node(&node.order), children, first, None, to)
        }
    }

    #[inline(always)]
    fn record(
        self,
        ray: &Ray,
        vertices: Vertices<'_>,
        record: &Record,
        t_max: f32,
        crossings: &mut Crossings,
    ) -> Verdict {
        // SAFETY: a value of Wide exists, so the machine has what it takes.
        unsafe { record::record(&ray.along, vertices, record, t_max, crossings) }
    }

    #[inline(always)]
    fn apart<T: Part>(self, so: bool, part: T) -> T::Result {
        if !so {
            return part.run();
        }
        // SAFETY: a value of Wide exists, so the machine has what `P` takes.
        unsafe { P::apart(part) }
    }

    #[cold]
    #[inline(never)]
    fn in_doubt<R>(self, task: impl FnOnce() -> R) -> R {
        task()
    }

    const TOGETHER: usize = 3;

    #[inline(always)]
    fn kind(self, ray: &geometry::Ray) -> Kind {
        // SAFETY: a value of Wide exists, so the machine has what it takes, here and below.
        unsafe { bundle::kind(ray) }
    }

    #[inline(always)]
    fn fill(self, rays: &[geometry::Ray], members: &[u16], kind: Kind, to: &mut Group) -> Filled {
        // SAFETY: as above.
        unsafe { bundle::fill(rays, members, kind, to) }
    }

    #[inline(always)]
    fn boxes(
        self,
        groups: &[Group],
        list: &[Octet],
        count: usize,
        planes: ([&Row; 3], [&Row; 3]),
        met: &mut [Octet],
    ) -> u8 {
        // SAFETY: as above.
        unsafe { bundle::boxes(groups, list, count, planes, met) }
    }

    #[inline(always)]
    fn select(
        self,
        list: &[Octet],
        met: &[Octet],
        count: usize,
        slot: usize,
        to: &mut [Octet],
    ) -> usize {
        // SAFETY: as above.
        unsafe { bundle::select(list, met, count, slot, to) }
    }

    #[inline(always)]
    fn by_place(self, turn: Turn, order: u32, slots: u8) -> u8 {
        // SAFETY: as above.
        unsafe { put_down::by_place(turn, order, slots) }
    }

    #[inline(always)]
    fn quad(self, vertices: Vertices<'_>, record: &Record, quad: &mut Quad) -> bool {
        // SAFETY: as above.
        unsafe { record::quad(vertices, record, quad) }
    }

    #[inline(always)]
    fn quad_of(
        self,
        quad: &Quad,
        group: &Group,
        lane: usize,
        kind: Kind,
        to: &mut Crossings,
    ) -> Verdict {
        // SAFETY: as above.
        unsafe { record::quad_of(quad, group, lane, kind, to) }
    }

    #[inline(always)]
    fn triangle(
        self,
        quad: &Quad,
        place: usize,
        group: &Group,
        kind: Kind,
        to: &mut Crossings,
    ) -> Verdict {
        // SAFETY: as above.
        unsafe { bundle::triangle(quad, place, group, kind, to) }
    }

    #[inline(always)]
    fn beam(self, beam: &Beam, planes: ([&Row; 3], [&Row; 3]), enter: &mut Row) -> u8 {
        // SAFETY: as above.
        unsafe { bundle::beam(beam, planes, enter) }
    }

    #[inline(always)]
    fn meets(self, group: &Group, planes: ([&Row; 3], [&Row; 3]), slot: usize) -> u8 {
        // SAFETY: as above.
        unsafe { bundle::meets(group, planes, slot) }
    }
}
