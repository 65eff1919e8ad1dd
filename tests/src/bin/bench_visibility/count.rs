//! How much a ray visits: nodes, records and blocks, on average.

use std::cell::Cell;

use kiloray_core::block::format::{BlockHeader, Node, Record};
use kiloray_core::block::{
    BlockSource, BlockView, Expanded, ExpandedNode, ExpandedTop, NoBlock, Vertices,
};
use kiloray_core::geometry::{PreparedRay, Ray};
use kiloray_core::real::LANES;
use kiloray_core::trace::{
    Crossings, Cursor, Kernel, Lanes, Met, Places, Query, Scalar, Search, TraceError, Tracer, Turn,
    Verdict,
};

use crate::Error;

#[derive(Default)]
struct Counts {
    nodes: Cell<u64>,
    expanded: Cell<u64>,
    records: Cell<u64>,
    candidates: Cell<u64>,
    blocks: Cell<u64>,
}

#[derive(Clone, Copy)]
struct Counting<'a>(&'a Counts);

fn add(to: &Cell<u64>) {
    to.set(to.get() + 1);
}

impl Lanes for Counting<'_> {
    type Frame = <Scalar as Lanes>::Frame;
    type Spread = <Scalar as Lanes>::Spread;
    type Ray = <Scalar as Lanes>::Ray;
    type Real = f32;

    fn read(self, row: &[f32; LANES], first: usize) -> f32 {
        Scalar.read(row, first)
    }

    fn read_whole(self, row: &[u32; LANES], first: usize) -> u32 {
        Scalar.read_whole(row, first)
    }

    fn count_from(self, first: u32) -> u32 {
        Scalar.count_from(first)
    }

    fn ray(self, ray: &PreparedRay) -> Self::Ray {
        Scalar.ray(ray)
    }

    fn frame(self, ray: &Self::Ray, header: &BlockHeader) -> Self::Frame {
        Scalar.frame(ray, header)
    }

    fn visit(
        self,
        frame: &Self::Frame,
        node: &Node,
        turn: Turn,
        span: (f32, f32),
        tag: u32,
        to: Places<'_>,
    ) -> Met {
        add(&self.0.nodes);
        Scalar.visit(frame, node, turn, span, tag, to)
    }

    fn spread(self, frame: &Self::Frame) -> Self::Spread {
        Scalar.spread(frame)
    }

    fn visit_expanded(
        self,
        frame: &Self::Spread,
        node: &ExpandedNode,
        turn: Turn,
        span: (f32, f32),
        to: Places<'_>,
    ) -> Met {
        add(&self.0.expanded);
        Scalar.visit_expanded(frame, node, turn, span, to)
    }

    fn record(
        self,
        ray: &Self::Ray,
        vertices: Vertices<'_>,
        record: &Record,
        t_max: f32,
        crossings: &mut Crossings,
    ) -> Verdict {
        add(&self.0.records);
        let used = record.index.iter().filter(|[a, b, c]| a != b || b != c).count() as u64;
        self.0.candidates.set(self.0.candidates.get() + used);
        Scalar.record(ray, vertices, record, t_max, crossings)
    }
}

impl Tracer for Counting<'_> {
    fn run<T: Search, S: BlockSource, Q: Query>(
        self,
        room: &mut T::Room,
        source: &mut S,
        rays: &T::Rays,
        queries: &mut T::Queries<Q>,
    ) -> Result<(), TraceError<S::Error>> {
        T::run(self, room, source, rays, queries)
    }

    fn compute<K: Kernel>(self, kernel: K) {
        kernel.run(self);
    }
}

struct Source<'a>(Expanded<'a>, &'a Counts);

impl BlockSource for Source<'_> {
    type Error = NoBlock;
    fn block(&mut self, block: u32) -> Result<BlockView<'_>, NoBlock> {
        add(&self.1.blocks);
        self.0.block(block)
    }
    fn holds_all(&self) -> bool {
        self.0.holds_all()
    }
    fn top(&self) -> ExpandedTop<'_> {
        self.0.top()
    }
}

/// Prints the averages of a set of rays.
pub(crate) fn print(source: Expanded<'_>, kind: &str, rays: &[Ray]) -> Result<(), Error> {
    let counts = Counts::default();
    let lanes = Counting(&counts);
    let mut source = Source(source, &counts);
    let mut cursor = Cursor::new();
    for ray in rays {
        if kind == "shadow" {
            lanes.any(&mut cursor, &mut source, ray)?;
        } else {
            lanes.closest(&mut cursor, &mut source, ray)?;
        }
    }
    let per_ray = |n: &Cell<u64>| n.get() as f64 / rays.len() as f64;
    println!(
        "per {kind} ray: {:.2} nodes and {:.2} expanded, {:.2} records, {:.2} triangles, {:.2} times a block",
        per_ray(&counts.nodes),
        per_ray(&counts.expanded),
        per_ray(&counts.records),
        per_ray(&counts.candidates),
        per_ray(&counts.blocks),
    );
    Ok(())
}
